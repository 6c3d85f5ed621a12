//! Controllers in Python.

use std::sync::{Arc, Mutex, PoisonError};

use inbye::geometry::Twist;
use inbye::global::Path;
use inbye::navigator::{self, Controller, ControllerError, ControllerReply};
use inbye::runtime::Config;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::PyType;

use super::conversion::{points, pose_tuple, raise, table, twist_tuple};

/// Most characters of an answer that an error quotes.
const MOST_QUOTED: usize = 60;

/// What a controller decides from.
#[pyclass(frozen, get_all, module = "inbye")]
pub struct ControllerInput {
    /// Time of the tick.
    time_s: f64,
    /// Control period.
    period_s: f64,
    /// Estimated pose at the time of the odometry.
    pose: (f64, f64, f64),
    /// Measured velocity at the time of the odometry.
    twist: (f64, f64),
    /// Time of the odometry.
    odometry_s: f64,
    /// Pose when a command of this tick takes effect.
    predicted_pose: (f64, f64, f64),
    /// Velocity when a command of this tick takes effect.
    predicted_twist: (f64, f64),
    /// The command of the last tick.
    last_command: (f64, f64),
    /// Least speed, largest speed, largest turn rate.
    speed_limits: (f64, f64, f64),
    /// Acceleration and braking, the latter below zero: of the speed, then of the turn rate.
    acceleration_limits: (f64, f64, f64, f64),
    /// Discs of the robot: rows of x, y and radius in its own frame.
    footprint: Py<PyArray2<f64>>,
    /// Newest scan: infinite for nothing within range, NaN for no measurement.
    ranges: Py<PyArray1<f64>>,
    /// Position of the lidar in the robot's frame, from which the ranges are.
    lidar_position: (f64, f64),
    /// Direction of the first beam in the robot's frame.
    angle_min: f64,
    /// Angle between beams.
    angle_increment: f64,
    /// Longest range.
    range_max: f64,
    /// Time of the scan.
    scan_s: f64,
    /// Tracked moving obstacles: rows of x, y, radius, vx and vy.
    moving_obstacles: Py<PyArray2<f64>>,
    /// The global path: rows of x and y. All ticks share this array, and it is read-only.
    path: Py<PyArray2<f64>>,
    /// Length of the path behind the robot.
    path_progress_m: f64,
    /// The key node that inbye would drive to.
    local_target: (f64, f64),
    /// The goal, with its yaw if it has one.
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

/// The object of a controller and the callable that computes its velocities. The owner of the controller shares them, so that
/// Python's garbage collector finds and breaks cycles. They are locked only while no Python code runs.
#[derive(Clone)]
pub struct ControllerObjects(Arc<Mutex<Option<[Py<PyAny>; 2]>>>);

impl ControllerObjects {
    fn get(&self, py: Python<'_>) -> PyResult<[Py<PyAny>; 2]> {
        let objects = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let objects = objects.as_ref().ok_or_else(|| raise("the controller no longer exists"))?;
        Ok(objects.each_ref().map(|object| object.clone_ref(py)))
    }

    /// Visits the objects for the garbage collector.
    pub fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        let Ok(objects) = self.0.try_lock() else { return Ok(()) };
        objects.iter().flatten().try_for_each(|object| visit.call(object))
    }

    /// Drops the objects for the garbage collector.
    pub fn clear(&self) {
        let objects = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        // This can run Python code, and must not happen with the lock.
        drop(objects);
    }
}

/// A Python object as a controller: a callable, or an object with `compute_velocity` and optionally `set_plan`, `reset` and
/// `name`.
pub struct PythonController {
    name: String,
    objects: ControllerObjects,
    path: Py<PyArray2<f64>>,
    raised: Raised,
}

impl PythonController {
    /// Rejects a program of the settings where an object decides: it would not run.
    pub fn check_settings(config: &Config) -> PyResult<()> {
        if config.controller.is_set() {
            return Err(raise(
                "controller.command: controller= decides, and the program would not run: leave one of them out",
            ));
        }
        Ok(())
    }

    /// The callable that computes the velocities of a controller.
    pub fn compute_method<'py>(object: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        if let Ok(class) = object.cast::<PyType>() {
            let name = class.name()?;
            return Err(raise(format!(
                "controller: {name} is a class: give an object of it, {name}()"
            )));
        }
        match object.getattr_opt("compute_velocity")? {
            Some(method) => Ok(method),
            None if object.is_callable() => Ok(object.clone()),
            None => {
                let kind = object.get_type().name()?;
                Err(raise(format!(
                    "a value of type {kind} is no controller: give a callable, or an object with a method compute_velocity"
                )))
            }
        }
    }

    /// A controller that begins a drive: its object is reset.
    pub fn of(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        let compute = Self::compute_method(object)?;
        let name = match object.getattr_opt("name")?.or(object.getattr_opt("__name__")?) {
            Some(name) => name.str()?.extract()?,
            None => object.get_type().name()?.extract()?,
        };
        let objects = [object.clone().unbind(), compute.unbind()];
        let mut controller = Self {
            name,
            objects: ControllerObjects(Arc::new(Mutex::new(Some(objects)))),
            path: points(object.py(), &[])?.unbind(),
            raised: Raised::default(),
        };
        controller.reset();
        Ok(controller)
    }

    /// Where its exception will be.
    pub fn raised(&self) -> Raised {
        self.raised.clone()
    }

    /// Its Python objects.
    pub fn objects(&self) -> ControllerObjects {
        self.objects.clone()
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
            lidar_position: (input.scan.origin.x, input.scan.origin.y),
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
        let [object, _] = self.objects.get(py)?;
        if let Some(method) = object.bind(py).getattr_opt(method)? {
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
                // It is the array of all ticks: a change in place would stay.
                drop(path.try_readwrite().map_err(raise)?.make_nonwriteable());
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
                .and_then(|()| {
                    let [_, compute] = self.objects.get(py)?;
                    compute.bind(py).call1((self.input(py, input)?,))
                })
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
