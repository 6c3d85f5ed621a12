//! What a robot did in a number of ticks, for the reason of a mission that did not arrive.

use std::collections::BTreeMap;

use super::Mode;
use crate::geometry::Twist;

/// Smaller shares of the time are left out.
const NAMED_SHARE: f64 = 0.05;
/// A command stands if it is at most this fast, m/s and rad/s. Commands that mostly stand are named.
const STANDING: f64 = 0.01;
const MOSTLY: f64 = 0.5;

/// Name of the protective action for a lidar that sees too little, and its cause, which the name does not tell.
const BLIND_SCAN: &str = "blind_scan";
const BLIND_CAUSE: &str = "; too few beams have a return: the lidar is covered, or nothing is within its range, where a lidar that \
    sees farther or collision_monitor.min_return_share = 0 helps";

/// Ticks by what the robot did.
#[derive(Clone, Debug, Default)]
pub(crate) struct ModeTicks {
    by_mode: BTreeMap<&'static str, u32>,
    /// Those with a command to stand.
    standing: u32,
    /// Those in which the protective layer changed the command, by its action.
    by_protection: BTreeMap<&'static str, u32>,
}

impl ModeTicks {
    /// Starts again where the robot has made progress.
    pub fn restart_if(&mut self, has_progress: bool) {
        if has_progress {
            *self = Self::default();
        }
    }

    /// Counts a decision by its mode and command.
    pub fn count(&mut self, mode: Mode, command: &Twist) {
        *self.by_mode.entry(mode.name()).or_default() += 1;
        let stands = [command.linear, command.angular].iter().all(|part| part.abs() <= STANDING);
        self.standing += u32::from(stands);
    }

    /// Counts a command that the protective layer changed, by the name of its action.
    #[cfg(any(test, feature = "sim"))]
    pub fn count_protection(&mut self, action: &'static str) {
        *self.by_protection.entry(action).or_default() += 1;
    }

    /// Whether the local planner found no admissible velocity in most ticks in which it was asked, and the robot tried little else than
    /// to escape.
    pub fn is_blocked(&self) -> bool {
        let ticks = |mode: Mode| self.by_mode.get(mode.name()).copied().unwrap_or_default();
        let blocked = ticks(Mode::Blocked);
        blocked > ticks(Mode::Driving) && self.share(Some(blocked + ticks(Mode::Escaping))) > MOSTLY
    }

    /// What the robot did, and what the protective layer did.
    pub fn text(&self) -> String {
        let standing = self.share(Some(self.standing));
        let stood = if standing > MOSTLY {
            format!(", with a command to stand {:.0} % of it", 100.0 * standing)
        } else {
            String::new()
        };
        let modes = format!("{} of the time{stood}", self.shares(&self.by_mode));
        let actions = self.shares(&self.by_protection);
        if actions.is_empty() {
            return format!("the robot was {modes}");
        }
        let blind = self.share(self.by_protection.get(BLIND_SCAN).copied());
        let cause = if blind > MOSTLY { BLIND_CAUSE } else { "" };
        format!(
            "the robot was {modes}, and the protective layer changed its commands: {actions} of the time{cause}"
        )
    }

    fn share(&self, ticks: Option<u32>) -> f64 {
        let all: u32 = self.by_mode.values().sum();
        f64::from(ticks.unwrap_or_default()) / f64::from(all.max(1))
    }

    /// The names with their shares, the largest first.
    fn shares(&self, counts: &BTreeMap<&'static str, u32>) -> String {
        let shares = counts.iter().map(|(name, ticks)| (self.share(Some(*ticks)), *name));
        let mut shares: Vec<_> = shares.filter(|(share, _)| *share >= NAMED_SHARE).collect();
        shares.sort_by(|one, other| other.0.total_cmp(&one.0));
        let text = |(share, name): &(f64, &str)| {
            format!("{} {:.0} %", name.replace('_', " "), 100.0 * share)
        };
        shares.iter().map(text).collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(modes: &[(Mode, u32)]) -> ModeTicks {
        let mut ticks = ModeTicks::default();
        for (mode, count) in modes {
            (0..*count).for_each(|_| ticks.count(*mode, &Twist::new(0.3, 0.0)));
        }
        ticks
    }

    #[test]
    fn robot_that_mostly_rotates_is_not_blocked_on_all_sides() {
        let rotates = after(&[(Mode::Driving, 1), (Mode::Blocked, 9), (Mode::Rotating, 30)]);
        assert!(!rotates.is_blocked());
        assert_eq!(rotates.text(), "the robot was rotating 75 %, blocked 22 % of the time");
        assert!(after(&[(Mode::Blocked, 9), (Mode::Escaping, 8)]).is_blocked());
    }

    #[test]
    fn commands_to_stand_are_named_where_they_are_most() {
        let mut ticks = after(&[(Mode::Driving, 1)]);
        ticks.count(Mode::Driving, &Twist::STOP);
        assert_eq!(ticks.text(), "the robot was driving 100 % of the time");
        ticks.count(Mode::Driving, &Twist::new(0.005, -0.01));
        let stood = "the robot was driving 100 % of the time, with a command to stand 67 % of it";
        assert_eq!(ticks.text(), stood);
    }

    #[test]
    fn protective_layer_is_named_where_it_holds_the_robot() {
        let mut ticks = after(&[(Mode::Driving, 100)]);
        (0..4).for_each(|_| ticks.count_protection("approach"));
        assert_eq!(ticks.text(), "the robot was driving 100 % of the time");
        (0..44).for_each(|_| ticks.count_protection("blind_scan"));
        let held = "the robot was driving 100 % of the time, and the protective layer changed its commands: blind scan";
        assert_eq!(ticks.text(), format!("{held} 44 % of the time"));
        (0..44).for_each(|_| ticks.count_protection("blind_scan"));
        let cause = "; too few beams have a return: the lidar is covered, or nothing is within its range, where a lidar that sees farther \
            or collision_monitor.min_return_share = 0 helps";
        assert_eq!(ticks.text(), format!("{held} 88 % of the time{cause}"));
    }
}
