//! What a drive does, as it goes on: a line for each change of mode, new plan and doubt, for `--verbose`.

use inbye::navigator::Mode;
use inbye::sim::Moment;

use super::output;

/// What was told last.
#[derive(Default)]
pub struct Story {
    mode: Option<Mode>,
    plans: usize,
    doubts: u64,
}

impl Story {
    /// Tells what is new in a tick.
    pub fn tell(&mut self, moment: &Moment<'_>) {
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
        let doubts = moment.navigator.doubts();
        let count = doubts.values().sum();
        if count > self.doubts && self.mode != Some(Mode::Doubting) {
            let kinds: Vec<String> = doubts.keys().map(ToString::to_string).collect();
            let kinds = kinds.join(", ");
            output::detail(format!("{}: senses not believed, so far: {kinds}", at()));
        }
        if self.mode != Some(row.mode) {
            output::detail(format!("{}: {}", at(), row.mode.word().replace('_', " ")));
        }
        *self = Self {
            mode: Some(row.mode),
            plans: plans.len(),
            doubts: count,
        };
    }
}
