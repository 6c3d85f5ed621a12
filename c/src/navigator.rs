//! The navigator.

use core::ffi::c_char;
use core::panic::AssertUnwindSafe;
use std::ffi::CString;

use inbye::local::CpuEngine;
use inbye::map::{Scan, ScanChange};
use inbye::navigator::{Goal, MapSource, Navigator, Observation, Waypoints};
use inbye::runtime::Config;

use crate::error::{array, boxed, free, guarded, object, object_mut, place};
use crate::map::write_points;
use crate::map::{InbyeConfig, InbyeMap};
use crate::values::{InbyePoint, InbyePose, InbyeTwist, check_coordinates};

/// Follows global paths to its goals among obstacles that are not in the map.
pub struct InbyeNavigator {
    navigator: Navigator,
    config: Config,
    scan_change: ScanChange,
    fault: CString,
}

/// A goal, with a yaw or without.
#[repr(C)]
pub struct InbyeGoal {
    pub position: InbyePoint,
    pub has_yaw: bool,
    pub yaw: f64,
}

/// What the robot measures at a tick. All times are of one clock, seconds; that of the tick never goes back.
#[repr(C)]
pub struct InbyeObservation {
    pub time_s: f64,
    /// Pose in the map, and the time of the measurement that corrected it last.
    pub pose: InbyePose,
    pub pose_s: f64,
    /// Velocity by odometry, and its time.
    pub velocity: InbyeTwist,
    pub odometry_s: f64,
    /// Ranges of the lidar in metres: infinite for nothing within range, NaN for no measurement.
    pub ranges: *const f64,
    pub range_count: usize,
    /// Direction of the first beam in the robot's frame, angle between beams, both in radians, and the longest range. The last two are
    /// above zero. For a lidar that is mounted upside down, reverse the ranges: its last beam is then the first.
    pub angle_min: f64,
    pub angle_increment: f64,
    pub range_max: f64,
    /// Time of the scan; unchanged where there is no newer one.
    pub scan_s: f64,
    /// Place of the lidar in the robot's frame, metres: the ranges are from there.
    pub lidar: InbyePoint,
}

/// What the navigator does.
#[derive(Clone, Copy)]
#[repr(C)]
pub enum InbyeMode {
    Driving,
    Arrived,
    /// inbye_navigator_fault says why.
    Failed,
    /// It brakes: the observation is faulty, and inbye_navigator_fault says why.
    SensorFault,
}

/// The decision of a tick.
#[repr(C)]
pub struct InbyeCommand {
    /// The velocity to send to the base.
    pub velocity: InbyeTwist,
    pub mode: InbyeMode,
    /// The key node that the robot drives to.
    pub local_target: InbyePoint,
}

/// How far a navigator is.
#[repr(C)]
pub struct InbyeProgress {
    /// Length of the path ahead, to the last goal, metres.
    pub distance_left_m: f64,
    /// Number of goals that the robot has left behind.
    pub goals_passed: usize,
    /// Number of paths planned so far: a larger number means that the path is a new one.
    pub plans: usize,
}

/// Makes a navigator that drives to all goals in turn, and plans a path to each. Its engine is one thread of the CPU. It has no
/// protective layer below it: a program that drives a real base must have its own, which stops the robot before what the lidar sees
/// and when commands stay away. Returns null on failure.
///
/// # Safety
/// `map` and `config` are alive, `goals` points to this many goals.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_navigator_new(
    map: *const InbyeMap,
    config: *const InbyeConfig,
    start: InbyePoint,
    goals: *const InbyeGoal,
    goal_count: usize,
) -> *mut InbyeNavigator {
    boxed(AssertUnwindSafe(|| {
        // SAFETY: the caller vouches for both.
        let (map, config) = unsafe { (object(map, "map")?, object(config, "config")?) };
        // SAFETY: likewise.
        let waypoints = waypoints(start, unsafe { array(goals, goal_count, "goals") }?)?;
        let engine = Box::new(CpuEngine::single_threaded());
        let known = map.navigation_map(config.0.unknown);
        let navigator = config.0.new_navigator(known, &waypoints, engine, &mut || 0.0);
        Ok(InbyeNavigator {
            navigator: navigator.map_err(|error| error.to_string())?,
            config: config.0.clone(),
            scan_change: ScanChange::default(),
            fault: CString::default(),
        })
    }))
}

/// The start and the goals of a mission, checked.
fn waypoints(start: InbyePoint, goals: &[InbyeGoal]) -> Result<Waypoints, String> {
    if goals.is_empty() {
        return Err("there must be at least one goal".to_owned());
    }
    let goal = |goal: &InbyeGoal| {
        let position = goal.position.checked("a goal")?;
        if goal.has_yaw {
            check_coordinates([goal.yaw], "the yaw of a goal")?;
        }
        Ok(Goal { position, yaw: goal.has_yaw.then_some(goal.yaw) })
    };
    let goals = goals.iter().map(goal).collect::<Result<_, String>>()?;
    Ok(Waypoints { start: start.checked("start")?, goals })
}

/// Frees a navigator.
///
/// # Safety
/// `navigator` is null or a navigator that was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_navigator_free(navigator: *mut InbyeNavigator) {
    // SAFETY: the caller vouches for the navigator.
    unsafe { free(navigator) };
}

/// Decides what to do now. Call it every `local.control_period_s` of the configuration, 0.1 s by default. A measurement that is not
/// finite is a faulty observation: the robot brakes.
///
/// On a real robot set `navigator.wait_for_plans = false`; otherwise a step can take as long as a plan. By default a step waits for a
/// plan that is due, so that a simulation is the same at each repetition.
///
/// # Safety
/// `navigator` is alive; `observation` can be read, and so can its ranges; `command` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_navigator_step(
    navigator: *mut InbyeNavigator,
    observation: *const InbyeObservation,
    command: *mut InbyeCommand,
) -> bool {
    let decided = guarded(AssertUnwindSafe(|| {
        // SAFETY: the caller vouches for all of them.
        let this = unsafe { object_mut(navigator, "navigator") }?;
        // SAFETY: likewise.
        let seen = unsafe { object(observation, "observation") }?;
        // SAFETY: likewise.
        let answer = unsafe { place(command, "command") }?;
        // SAFETY: likewise.
        let ranges = unsafe { array(seen.ranges, seen.range_count, "ranges") }?.to_vec();
        let InbyePose { x, y, yaw } = seen.pose;
        let observation = Observation {
            time_s: seen.time_s,
            pose: inbye::geometry::Pose::new(x, y, yaw),
            pose_s: seen.pose_s,
            lost: None,
            twist: inbye::geometry::Twist::new(seen.velocity.linear, seen.velocity.angular),
            odometry_s: seen.odometry_s,
            scan_changed_s: this.scan_change.update(seen.scan_s, ranges.iter().copied()),
            scan: Scan {
                origin: inbye::geometry::Point::new(seen.lidar.x, seen.lidar.y),
                angle_min: seen.angle_min,
                angle_increment: seen.angle_increment,
                range_max: seen.range_max,
                ranges,
            },
            scan_s: seen.scan_s,
            sent: None,
        };
        let decision = this.navigator.step(&observation);
        let fault = this.navigator.fault().map(ToString::to_string);
        let faulty = || this.navigator.observation_fault().map(|fault| fault.to_string());
        let fault = fault.or_else(faulty).unwrap_or_default();
        this.fault = CString::new(fault).unwrap_or_default();
        answer.write(InbyeCommand {
            velocity: (&decision.command).into(),
            mode: match decision.mode {
                inbye::navigator::Mode::Arrived => InbyeMode::Arrived,
                inbye::navigator::Mode::Failed => InbyeMode::Failed,
                inbye::navigator::Mode::SensorFault => InbyeMode::SensorFault,
                _ => InbyeMode::Driving,
            },
            local_target: (&decision.local_target).into(),
        });
        Ok(())
    }));
    decided.is_some()
}

/// Returns why the mission failed, or what is wrong with the last observation; empty where both are sound. It stays valid until the
/// next step.
///
/// # Safety
/// `navigator` is alive.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_navigator_fault(navigator: *const InbyeNavigator) -> *const c_char {
    // SAFETY: the caller vouches for the navigator.
    unsafe { navigator.as_ref() }.map_or(c"".as_ptr(), |this| this.fault.as_ptr())
}

/// Limits the speed from the next step on, m/s; infinite for no limit. A robot that is faster brakes. With a limit of zero it stands
/// or turns on the spot, and this time does not count as time without progress. Limits of zones count too.
///
/// # Safety
/// `navigator` is alive.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_navigator_set_speed_limit(
    navigator: *mut InbyeNavigator,
    limit_m_s: f64,
) -> bool {
    let is_set = guarded(AssertUnwindSafe(|| {
        // SAFETY: the caller vouches for the navigator.
        let this = unsafe { object_mut(navigator, "navigator") }?;
        if limit_m_s.is_nan() || limit_m_s < 0.0 {
            return Err(format!("the speed limit is {limit_m_s}: it must be zero or more"));
        }
        this.navigator.set_speed_limit(limit_m_s.is_finite().then_some(limit_m_s));
        Ok(())
    }));
    is_set.is_some()
}

/// Replaces the goals while the robot drives, or after it arrived or failed: plans a path to each of them on the present map, and the
/// next step drives to the first. `start` is where the robot is. What the scans showed is kept. The call takes as long as the plans: on
/// a large map stop the robot before, with a speed limit of zero. On failure the goals so far remain.
///
/// # Safety
/// `navigator` is alive; `goals` has `goal_count` goals.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_navigator_set_goals(
    navigator: *mut InbyeNavigator,
    start: InbyePoint,
    goals: *const InbyeGoal,
    goal_count: usize,
) -> bool {
    let is_set = guarded(AssertUnwindSafe(|| {
        // SAFETY: the caller vouches for both.
        let (this, goals) =
            unsafe { (object_mut(navigator, "navigator")?, array(goals, goal_count, "goals")?) };
        let InbyeNavigator { navigator, config, .. } = this;
        let replaced = config.replace_goals(navigator, &waypoints(start, goals)?, &mut || 0.0);
        replaced.map_err(|error| error.to_string())
    }));
    is_set.is_some()
}

/// Replaces the map, in the same frame, while the robot drives: the next step avoids its obstacles and zones, and a path on it is
/// planned at once. Obstacles that only the lidar saw remain. Where the map has no path even without them, the mission fails within
/// a second by the default settings. It takes time in proportion to the map's area.
///
/// # Safety
/// `navigator` and `map` are alive.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_navigator_set_map(
    navigator: *mut InbyeNavigator,
    map: *const InbyeMap,
) -> bool {
    let is_set = guarded(AssertUnwindSafe(|| {
        // SAFETY: the caller vouches for both.
        let (this, map) = unsafe { (object_mut(navigator, "navigator")?, object(map, "map")?) };
        let known = map.navigation_map(this.config.unknown);
        let map = this.config.prepare_map(known).map_err(|error| error.to_string())?;
        this.navigator.replace_map(map, MapSource::Given);
        Ok(())
    }));
    is_set.is_some()
}

/// Returns how far the robot is.
///
/// # Safety
/// `navigator` is alive; `progress` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_navigator_progress(
    navigator: *const InbyeNavigator,
    progress: *mut InbyeProgress,
) -> bool {
    let is_written = guarded(AssertUnwindSafe(|| {
        // SAFETY: the caller vouches for the navigator.
        let navigator = &unsafe { object(navigator, "navigator") }?.navigator;
        // SAFETY: likewise for the place.
        unsafe { place(progress, "progress") }?.write(InbyeProgress {
            distance_left_m: navigator.distance_left_m(),
            goals_passed: navigator.goals_passed(),
            plans: navigator.plans().len(),
        });
        Ok(())
    }));
    is_written.is_some()
}

/// Writes up to `capacity` points of the path that the robot follows into `points`, and the number of all of them into `count`.
///
/// # Safety
/// `navigator` is alive; `points` has room for `capacity` points; `count` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn inbye_navigator_path(
    navigator: *const InbyeNavigator,
    points: *mut InbyePoint,
    capacity: usize,
    count: *mut usize,
) -> bool {
    let is_written = guarded(AssertUnwindSafe(|| {
        // SAFETY: the caller vouches for the navigator.
        let navigator = &unsafe { object(navigator, "navigator") }?.navigator;
        let path = navigator.plans().last().map_or(&[][..], |plan| plan.smoothed.points());
        // SAFETY: the caller vouches for the places.
        unsafe { write_points(path, points, capacity, count) }
    }));
    is_written.is_some()
}
