//! Controllers in Python.

use std::sync::{Arc, Mutex, PoisonError};

use inbye::geometry::Twist;
use inbye::global::Path;
use inbye::navigator::{self, Controller, ControllerError, ControllerReply};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use super::conversion::{points, pose_tuple, raise, table, twist_tuple};

/// Most characters of an answer that an error quotes.
const MOST_QUOTED: usize = 60;

/// What a controller decides from.
#[pyclass(frozen, get_all, module = "inbye")]
pub struct ControllerInput {
    time_s: f64,
    period_s: f64,
    pose: (f64, f64, f64),
    twist: (f64, f64),
    odometry_s: f64,
    predicted_pose: (f64, f64, f64),
    predicted_twist: (f64, f64),
    last_command: (f64, f64),
    /// Least and largest speed, largest turn rate.
    speed_limits: (f64, f64, f64),
    /// Acceleration and braking along x, then of the turn rate.
    acceleration_limits: (f64, f64, f64, f64),
    footprint: Py<PyArray2<f64>>,
    ranges: Py<PyArray1<f64>>,
    angle_min: f64,
    angle_increment: f64,
    range_max: f64,
    scan_s: f64,
    moving_obstacles: Py<PyArray2<f64>>,
    path: Py<PyArray2<f64>>,
    path_progress_m: f64,
    local_target: (f64, f64),
    goal: (f64, f64, Option<f64>),
}

/// The exception of a controller, which the caller of the drive gets.
#[derive(Clone, Default)]
pub struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    /// Keeps an exception for the caller.
    pub fn set(&self, error: PyErr) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
    }

    /// The exception, if there was one.
    pub fn check(&self) -> PyResult<()> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(Ok(()), Err)
    }
}

/// A Python object as a controller: a callable, or an object with `compute_velocity` and optionally `set_plan`, `reset` and
/// `name`.
pub struct PythonController {
    name: String,
    object: Py<PyAny>,
    compute: Py<PyAny>,
    path: Py<PyArray2<f64>>,
    raised: Raised,
}

impl PythonController {
    /// The controller, and where its exception will be.
    pub fn of(object: &Bound<'_, PyAny>) -> PyResult<(Box<dyn Controller>, Raised)> {
        let compute = match object.getattr_opt("compute_velocity")? {
            Some(method) => method,
            None if object.is_callable() => object.clone(),
            None => {
                return Err(raise("a controller is a callable, or has a method compute_velocity"));
            }
        };
        let name = match object.getattr_opt("name")?.or(object.getattr_opt("__name__")?) {
            Some(name) => name.str()?.extract()?,
            None => object.get_type().name()?.extract()?,
        };
        let raised = Raised::default();
        let controller = Self {
            name,
            object: object.clone().unbind(),
            compute: compute.unbind(),
            path: points(object.py(), &[])?.unbind(),
            raised: raised.clone(),
        };
        Ok((Box::new(controller), raised))
    }

    fn input(
        &self,
        py: Python<'_>,
        input: &navigator::ControllerInput<'_>,
    ) -> PyResult<ControllerInput> {
        let limits = input.limits;
        let discs = input.footprint.discs().iter();
        let discs: Vec<_> = discs.map(|disc| [disc.x, disc.y, disc.radius]).collect();
        let moving = input.moving_obstacles.iter();
        let moving: Vec<_> =
            moving.map(|disc| [disc.x, disc.y, disc.radius, disc.vx, disc.vy]).collect();
        let goal = input.goal;
        Ok(ControllerInput {
            time_s: input.time_s,
            period_s: input.period_s,
            pose: pose_tuple(&input.pose),
            twist: twist_tuple(&input.twist),
            odometry_s: input.odometry_s,
            predicted_pose: pose_tuple(&input.predicted_pose),
            predicted_twist: twist_tuple(&input.predicted_twist),
            last_command: twist_tuple(&input.last_command),
            speed_limits: (limits.min_vel_x, limits.max_vel_x, limits.max_vel_theta),
            acceleration_limits: (
                limits.acc_lim_x,
                limits.decel_lim_x,
                limits.acc_lim_theta,
                limits.decel_lim_theta,
            ),
            footprint: table(py, &discs)?.unbind(),
            ranges: PyArray1::from_slice(py, &input.scan.ranges).unbind(),
            angle_min: input.scan.angle_min,
            angle_increment: input.scan.angle_increment,
            range_max: input.scan.range_max,
            scan_s: input.scan_s,
            moving_obstacles: table(py, &moving)?.unbind(),
            path: self.path.clone_ref(py),
            path_progress_m: input.path_progress_m,
            local_target: (input.local_target.x, input.local_target.y),
            goal: (goal.position.x, goal.position.y, goal.yaw),
        })
    }

    /// The answer of the controller: any sequence of two numbers, or none to brake.
    fn velocity(&self, answer: &Bound<'_, PyAny>) -> PyResult<Option<[f64; 2]>> {
        answer.extract().or_else(|_| {
            let answer: String = answer.repr()?.extract()?;
            let answer: String = answer.replace('\n', " ").chars().take(MOST_QUOTED).collect();
            Err(raise(format!(
                "controller {}: it returned {answer}: return speed and turn rate, two numbers, or None to brake",
                self.name
            )))
        })
    }

    /// Calls an optional method.
    fn call_optional<'py, A>(&self, py: Python<'py>, method: &str, arguments: A) -> PyResult<()>
    where
        A: pyo3::call::PyCallArgs<'py>,
    {
        if let Some(method) = self.object.bind(py).getattr_opt(method)? {
            method.call1(arguments)?;
        }
        Ok(())
    }
}

impl Controller for PythonController {
    fn name(&self) -> &str {
        &self.name
    }

    fn set_plan(&mut self, path: &Path) {
        Python::attach(|py| {
            let set = points(py, path.points()).and_then(|path| {
                self.path = path.clone().unbind();
                self.call_optional(py, "set_plan", (path,))
            });
            if let Err(error) = set {
                self.raised.set(error);
            }
        });
    }

    fn compute_velocity(&mut self, input: &navigator::ControllerInput<'_>) -> ControllerReply {
        let failed = |reason: &str| ControllerError::Failed { reason: reason.to_owned() };
        Python::attach(|py| {
            let answer = py
                .check_signals()
                .and_then(|()| self.raised.check())
                .and_then(|()| self.compute.bind(py).call1((self.input(py, input)?,)))
                .and_then(|answer| self.velocity(&answer));
            match answer {
                Ok(Some([linear, angular])) => Ok(Twist::new(linear, angular)),
                Ok(None) => Err(ControllerError::NoValidControl {
                    reason: "the controller returned None".to_owned(),
                }),
                Err(error) => {
                    let reason = failed(&error.to_string());
                    self.raised.set(error);
                    Err(reason)
                }
            }
        })
    }

    fn reset(&mut self) {
        Python::attach(|py| {
            if let Err(error) = self.call_optional(py, "reset", ()) {
                self.raised.set(error);
            }
        });
    }
}
