//! The navigator, for a robot that a Python program drives.

use inbye::navigator::{Controller, MapSource, Observation, Waypoints};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;

use super::controller::{ControllerObjects, PythonController, Raised};
use super::conversion::{Numbers, goal, point, points, pose, raise, scan, twist, twist_tuple};
use super::decision::open;
use super::interrupt::Interrupt;
use super::map::Map;
use super::settings::settings;
use super::shared::Shared;

/// The decision of a tick.
#[pyclass(frozen, get_all, module = "inbye")]
pub struct NavigatorDecision {
    /// The velocity to drive.
    command: (f64, f64),
    /// What the navigator does, such as "driving" or "arrived".
    mode: &'static str,
    /// The key node that the robot drives to.
    local_target: (f64, f64),
    /// What is wrong with the observation.
    observation_fault: Option<String>,
    /// Why the mission failed.
    fault: Option<String>,
}

/// Follows global paths to its goals among obstacles that are not in the map.
#[pyclass(frozen, module = "inbye")]
pub struct Navigator {
    state: Shared<State>,
    raised: Raised,
    /// Those of the controller, which may contain this navigator.
    objects: Option<ControllerObjects>,
}

struct State {
    navigator: inbye::navigator::Navigator,
    config: inbye::runtime::Config,
    scan_change: inbye::map::ScanChange,
}

#[pymethods]
impl Navigator {
    #[new]
    #[pyo3(signature = (map, start, goals, *, config=None, controller=None, engine="cpu"))]
    fn new(
        py: Python<'_>,
        map: &Bound<'_, Map>,
        start: Numbers<2>,
        goals: Vec<Vec<f64>>,
        config: Option<&Bound<'_, PyAny>>,
        controller: Option<&Bound<'_, PyAny>>,
        engine: &str,
    ) -> PyResult<Self> {
        let config = settings(config)?;
        if controller.is_some() {
            PythonController::check_settings(&config)?;
        }
        let waypoints = waypoints(start, &goals)?;
        let controller = controller.map(PythonController::of).transpose()?;
        let raised = controller.as_ref().map(PythonController::raised).unwrap_or_default();
        let objects = controller.as_ref().map(PythonController::objects);
        let controller = controller.map(|it| Box::new(it) as Box<dyn Controller>);
        let engine = open(engine, 1)?;
        let map = map.get();
        let made = py.detach(|| {
            let (known, clock) = (map.navigation_map(config.unknown), &mut || 0.0);
            Interrupt::new().watch(&raised, || match controller {
                Some(it) => config.new_navigator_with(known, &waypoints, engine, Some(it), clock),
                None => config.new_navigator(known, &waypoints, engine, clock),
            })
        });
        raised.check()?;
        let navigator = made.map_err(raise)?;
        let scan_change = inbye::map::ScanChange::default();
        Ok(Self { state: Shared::new(State { navigator, config, scan_change }), raised, objects })
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.objects.as_ref().map_or(Ok(()), |objects| objects.traverse(&visit))
    }

    fn __clear__(&self) {
        if let Some(objects) = &self.objects {
            objects.clear();
        }
    }

    /// Decides what to do at a time, seconds. Times that are left out are that of the tick.
    #[pyo3(signature = (time_s, pose, velocity, ranges, *, angle_min, angle_increment, range_max, lidar_position=None, pose_s=None, odometry_s=None, scan_s=None))]
    #[expect(clippy::too_many_arguments, reason = "Python names them")]
    fn step(
        &self,
        py: Python<'_>,
        time_s: f64,
        pose: Numbers<3>,
        velocity: Numbers<2>,
        ranges: &Bound<'_, PyAny>,
        angle_min: f64,
        angle_increment: f64,
        range_max: f64,
        lidar_position: Option<Numbers<2>>,
        pose_s: Option<f64>,
        odometry_s: Option<f64>,
        scan_s: Option<f64>,
    ) -> PyResult<NavigatorDecision> {
        let scan = scan(ranges, lidar_position, angle_min, angle_increment, range_max)?;
        let odometry_s = odometry_s.unwrap_or(time_s);
        let scan_s = scan_s.unwrap_or(time_s);
        let (pose, twist) = (self::pose(pose)?, twist(velocity)?);
        let decision = self.state.with(py, |state| {
            let observation = Observation {
                time_s,
                pose,
                pose_s: pose_s.unwrap_or(odometry_s),
                lost: None,
                twist,
                odometry_s,
                scan_changed_s: state.scan_change.update(scan_s, scan.ranges.iter().copied()),
                scan,
                scan_s,
                sent: None,
            };
            let step = || state.navigator.step(&observation);
            let decision = Interrupt::new().watch(&self.raised, step);
            let navigator = &state.navigator;
            NavigatorDecision {
                command: twist_tuple(&decision.command),
                mode: decision.mode.name(),
                local_target: (decision.local_target.x, decision.local_target.y),
                observation_fault: navigator.observation_fault().map(|fault| fault.to_string()),
                fault: navigator.fault().map(ToString::to_string),
            }
        })?;
        self.raised.check()?;
        Ok(decision)
    }

    /// Limits the speed from the next step on, m/s.
    fn set_speed_limit(&self, py: Python<'_>, limit: Option<f64>) -> PyResult<()> {
        if let Some(limit) = limit.filter(|limit| limit.is_nan() || *limit < 0.0) {
            return Err(raise(format!("the speed limit is {limit}: it must be zero or more")));
        }
        self.state.with(py, |state| state.navigator.set_speed_limit(limit))
    }

    /// Replaces the goals while the robot drives, or after the last one.
    fn set_goals(&self, py: Python<'_>, start: Numbers<2>, goals: Vec<Vec<f64>>) -> PyResult<()> {
        let waypoints = waypoints(start, &goals)?;
        let replaced = self.state.with(py, |state| {
            let State { navigator, config, .. } = state;
            let replace = || config.replace_goals(navigator, &waypoints, &mut || 0.0);
            Interrupt::new().watch(&self.raised, replace)
        })?;
        self.raised.check()?;
        replaced.map_err(raise)
    }

    /// Replaces the map while the robot drives.
    fn set_map(&self, py: Python<'_>, map: &Bound<'_, Map>) -> PyResult<()> {
        let map = map.get();
        let replaced = self.state.with(py, |state| {
            let known = map.navigation_map(state.config.unknown);
            let map = state.config.prepare_map(known)?;
            state.navigator.replace_map(map, MapSource::Given);
            Ok::<(), inbye::navigator::Fault>(())
        })?;
        replaced.map_err(raise)
    }

    /// Length of the path ahead, metres.
    #[getter]
    fn distance_left_m(&self, py: Python<'_>) -> PyResult<f64> {
        self.state.with(py, |state| state.navigator.distance_left_m())
    }

    /// Number of goals that the robot has left behind.
    #[getter]
    fn goals_passed(&self, py: Python<'_>) -> PyResult<usize> {
        self.state.with(py, |state| state.navigator.goals_passed())
    }

    /// The global path that the robot follows.
    #[getter]
    fn path<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, numpy::PyArray2<f64>>> {
        let path = self.state.with(py, |state| {
            let plan = state.navigator.plans().last();
            plan.map(|plan| plan.smoothed.points().to_vec()).unwrap_or_default()
        })?;
        points(py, &path)
    }
}

/// The start and the goals of a mission, checked.
fn waypoints(start: Numbers<2>, goals: &[Vec<f64>]) -> PyResult<Waypoints> {
    let goals = goals.iter().map(|values| goal(values)).collect::<PyResult<Vec<_>>>()?;
    if goals.is_empty() {
        return Err(raise("goals must have at least one"));
    }
    Ok(Waypoints { start: point(start)?, goals })
}
