//! A controller in a shared library.

#![expect(unsafe_code, reason = "functions of a shared library are called by pointers")]

use core::error::Error;
use core::ffi::{CStr, c_void};
use std::path::Path;

use libloading::{Library as Loaded, Symbol};

use crate::abi::INBYE_ABI_VERSION;
use crate::interface::{
    AbiVersion, Compute, Create, Destroy, InbyeControllerInput, InbyeRobot, Reason,
};
use crate::messages::{Answer, Start, Tick};

/// An open library.
pub struct Library {
    name: String,
    create: Create,
    compute: Compute,
    destroy: Destroy,
    reason: Option<Reason>,
    /// It stays loaded as long as its functions are.
    _loaded: Loaded,
}

/// A controller of a library, and the path that it follows.
pub struct Controller {
    object: *mut c_void,
    destroy: Destroy,
    path: Vec<f64>,
}

impl Drop for Controller {
    fn drop(&mut self) {
        // SAFETY: the library made the object, and is still loaded: `main` drops it first.
        unsafe { (self.destroy)(self.object) };
    }
}

impl Library {
    pub fn open(file: &Path) -> Result<Self, String> {
        // SAFETY: the user names a library to run, as a program would be; its initialisers may do anything.
        let loaded = unsafe { Loaded::new(file) };
        let loaded = loaded.map_err(|error| format!("{}: {}", file.display(), reason(&error)))?;
        // SAFETY: the header declares these functions with these types.
        let (create, compute, destroy) = unsafe {
            (
                *function::<Create>(&loaded, file, "inbye_controller_create")?,
                *function::<Compute>(&loaded, file, "inbye_controller_compute_velocity")?,
                *function::<Destroy>(&loaded, file, "inbye_controller_destroy")?,
            )
        };
        // SAFETY: likewise.
        let version = unsafe {
            let version = function::<AbiVersion>(&loaded, file, "inbye_controller_abi_version")?;
            version()
        };
        if version != INBYE_ABI_VERSION {
            return Err(format!(
                "{}: it was compiled for version {version} of inbye.h, and this is version {INBYE_ABI_VERSION}: compile it again",
                file.display()
            ));
        }
        // SAFETY: likewise.
        let reason = unsafe { loaded.get::<Reason>("inbye_controller_error") };
        let reason = reason.ok().map(|reason| *reason);
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, create, compute, destroy, reason, _loaded: loaded })
    }

    /// Its file name without an extension.
    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn controller(&self, start: &Start) -> Result<Controller, String> {
        let Start { period_s, ref robot } = *start;
        let robot = InbyeRobot { period_s, radius_m: robot.radius_m, limits: robot.limits };
        // SAFETY: the header declares the function so.
        let object = unsafe { (self.create)(&raw const robot) };
        if object.is_null() {
            let why = self.reason().map_or_else(String::new, |reason| format!(": {reason}"));
            return Err(format!("{}: inbye_controller_create returned null{why}", self.name));
        }
        Ok(Controller { object, destroy: self.destroy, path: Vec::new() })
    }

    /// Why the last call gave no controller or no velocity, if the library tells it.
    fn reason(&self) -> Option<String> {
        // SAFETY: the header declares the function so.
        let text = unsafe { self.reason?() };
        if text.is_null() {
            return None;
        }
        // SAFETY: it is not null, and the library keeps the text until its next call.
        Some(unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned())
    }

    /// The velocity of a tick, or why the controller sees no valid one.
    ///
    /// # Errors
    /// When it is not finite.
    pub fn velocity(&self, controller: &mut Controller, tick: &Tick) -> Result<Answer, String> {
        if let Some(path) = &tick.path {
            controller.path = path.concat();
        }
        let ranges = tick.scan.ranges.iter().map(|range| range.unwrap_or(f64::NAN));
        let ranges: Vec<f64> = ranges.collect();
        let moving = tick.moving_obstacles.iter();
        let moving: Vec<f64> =
            moving.flat_map(|disc| [disc.x, disc.y, disc.radius, disc.vx, disc.vy]).collect();
        let (x, y, yaw) = tick.goal;
        let input = InbyeControllerInput {
            time_s: tick.time_s,
            pose: tick.pose,
            velocity: tick.twist,
            predicted_pose: tick.predicted_pose,
            predicted_velocity: tick.predicted_twist,
            last_command: tick.last_command,
            limits: tick.limits,
            goal: [x, y],
            has_goal_yaw: yaw.is_some(),
            goal_yaw: yaw.unwrap_or_default(),
            local_target: tick.local_target,
            path: controller.path.as_ptr(),
            path_count: controller.path.len() / 2,
            path_progress_m: tick.path_progress_m,
            is_reset: tick.reset,
            ranges: ranges.as_ptr(),
            range_count: ranges.len(),
            angle_min: tick.scan.angle_min,
            angle_increment: tick.scan.angle_increment,
            range_max: tick.scan.range_max,
            scan_s: tick.scan_s,
            moving_obstacles: moving.as_ptr(),
            moving_obstacle_count: moving.len() / 5,
            lidar: tick.scan.origin,
        };
        let (mut linear, mut angular) = (0.0, 0.0);
        // SAFETY: the header declares the function so; all pointers are valid during the call.
        let is_valid = unsafe {
            (self.compute)(controller.object, &raw const input, &raw mut linear, &raw mut angular)
        };
        if !is_valid {
            let reason = self.reason().unwrap_or_else(|| "no valid velocity".to_owned());
            return Ok(Answer::Error { error: reason });
        }
        if !(f64::is_finite(linear) && f64::is_finite(angular)) {
            return Err(format!("{}: the velocity {linear}, {angular} is not finite", self.name));
        }
        Ok(Answer::Velocity { linear, angular })
    }
}

/// A function of a library.
///
/// # Safety
/// The function has the type.
unsafe fn function<'l, T>(
    loaded: &'l Loaded,
    file: &Path,
    name: &str,
) -> Result<Symbol<'l, T>, String> {
    // SAFETY: the caller vouches for the type.
    let found = unsafe { loaded.get(name) };
    found.map_err(|error| {
        let reason = reason(&error);
        format!("{}: it has no function {name} ({reason}): see inbye.h", file.display())
    })
}

/// An error with its cause, which has the message of the system.
fn reason(error: &dyn Error) -> String {
    error.source().map_or_else(|| error.to_string(), |source| format!("{error}: {source}"))
}
