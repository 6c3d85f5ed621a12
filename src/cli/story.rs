//! What a drive does, as it goes on: a line for each change of mode, new plan and trouble, for `--verbose`.

use inbye::navigator::Mode;
use inbye::runtime::{FaultEvents, TickEvent};

use super::output;

/// What was told last.
#[derive(Default)]
pub struct Story {
    mode: Option<Mode>,
    plans: usize,
    troubles: FaultEvents,
    /// What was wrong at the last tick.
    wrong: Vec<String>,
}

impl Story {
    /// Tells what is new in a tick.
    pub fn tell(&mut self, moment: &TickEvent<'_>) {
        let row = moment.row;
        let at = || {
            let place = row.belief.position();
            format!("{:7.1} s at {:.2}, {:.2}", row.time_s, place.x, place.y)
        };
        let plans = moment.navigator.plans();
        for plan in plans.iter().skip(self.plans) {
            output::detail(format!(
                "{}: a plan of {:.1} m, {} cells expanded",
                at(),
                plan.smoothed.length_m(),
                plan.expanded,
            ));
        }
        let wrong = self.troubles.at(moment);
        for what in wrong.iter().filter(|what| !self.wrong.contains(what)) {
            output::detail(format!("{}: {what}", at()));
        }
        self.wrong = wrong;
        if self.mode != Some(row.mode) {
            output::detail(format!("{}: {}", at(), row.mode.as_str().replace('_', " ")));
        }
        self.mode = Some(row.mode);
        self.plans = plans.len();
    }
}
