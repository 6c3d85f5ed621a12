//! The log of a drive for `--verbose`: a line for each change of mode, new plan and fault.

use inbye::navigator::Mode;
use inbye::runtime::{FaultEvents, TickEvent};

use super::output;

/// State at the last tick.
#[derive(Default)]
pub struct DriveLog {
    mode: Option<Mode>,
    plans: usize,
    fault_events: FaultEvents,
    faults: Vec<String>,
}

impl DriveLog {
    /// Prints what changed in a tick.
    pub fn update(&mut self, tick: &TickEvent<'_>) {
        let row = tick.row;
        let at = || {
            let position = row.belief.position();
            format!("{:7.1} s at {:.2}, {:.2}", row.time_s, position.x, position.y)
        };
        let plans = tick.navigator.plans();
        for plan in plans.iter().skip(self.plans) {
            output::detail(format!(
                "{}: a plan of {:.1} m, {} cells expanded",
                at(),
                plan.smoothed.length_m(),
                plan.expanded,
            ));
        }
        let faults = self.fault_events.update(tick);
        for fault in faults.iter().filter(|fault| !self.faults.contains(fault)) {
            output::detail(format!("{}: {fault}", at()));
        }
        self.faults = faults;
        if self.mode != Some(row.mode) {
            output::detail(format!("{}: {}", at(), row.mode.as_str().replace('_', " ")));
        }
        self.mode = Some(row.mode);
        self.plans = plans.len();
    }
}
