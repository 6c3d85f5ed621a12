//! Faults injected into an emulated base.

use core::fmt;
use core::str::FromStr;

/// Names on the command line.
const NAMES: [(InjectedFault, &str); 9] = [
    (InjectedFault::StuckLeft, "stuck-left"),
    (InjectedFault::StuckRight, "stuck-right"),
    (InjectedFault::Runaway, "runaway"),
    (InjectedFault::Reversed, "reversed"),
    (InjectedFault::Button, "button"),
    (InjectedFault::Silence, "silence"),
    (InjectedFault::SlowReads, "slow-reads"),
    (InjectedFault::Garbage, "garbage"),
    (InjectedFault::BitFlips, "bit-flips"),
];

/// A fault of an emulated base or its serial line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InjectedFault {
    /// The left track is blocked.
    StuckLeft,
    /// The right track is blocked.
    StuckRight,
    /// The driver of the left motor is broken and applies full forward voltage. Only the button stops it.
    Runaway,
    /// The leads of the left motor are swapped, those of its encoder are not: the speed control accelerates it in the wrong
    /// direction until the set speed is zero.
    Reversed,
    /// The emergency button is pressed: the controller reports it and the motors have no power.
    Button,
    /// The base sends nothing; it still receives.
    Silence,
    /// The host's bytes are read 0.3 s late.
    SlowReads,
    /// Bursts of random bytes on the line in both directions, ten per second.
    Garbage,
    /// One of two hundred bytes has one bit flipped, in both directions.
    BitFlips,
}

impl InjectedFault {
    /// Every fault.
    pub const ALL: [Self; 9] = {
        let mut all = [Self::StuckLeft; 9];
        let mut index = 0;
        while index < all.len() {
            all[index] = NAMES[index].0;
            index += 1;
        }
        all
    };
}

impl fmt::Display for InjectedFault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let entry = NAMES.iter().find(|(fault, _)| fault == self);
        formatter.write_str(entry.map_or("", |(_, name)| name))
    }
}

/// A fault with its start and end, seconds since power-on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScheduledFault {
    /// The fault.
    pub fault: InjectedFault,
    /// Start time.
    pub from_s: f64,
    /// End time; infinite if it never ends.
    pub to_s: f64,
}

impl ScheduledFault {
    /// A fault that starts at a time and never ends.
    #[must_use]
    pub const fn from(fault: InjectedFault, from_s: f64) -> Self {
        Self { fault, from_s, to_s: f64::INFINITY }
    }

    /// Whether the fault is active at a time.
    pub(super) fn is_active(&self, now_s: f64) -> bool {
        (self.from_s..self.to_s).contains(&now_s)
    }
}

impl FromStr for ScheduledFault {
    type Err = String;

    /// Parses `NAME`, `NAME@FROM` or `NAME@FROM..TO`, times in seconds.
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, times) = text.split_once('@').unwrap_or((text, "0"));
        let entry = NAMES.iter().find(|(_, known)| *known == name);
        let Some((fault, _)) = entry else {
            let known: Vec<&str> = NAMES.iter().map(|(_, name)| *name).collect();
            return Err(format!(
                "`{}` is not a fault: use one of {}",
                name.escape_debug(),
                known.join(", ")
            ));
        };
        let (from, to) =
            times.split_once("..").map_or((times, None), |(from, to)| (from, Some(to)));
        let seconds = |text: &str| text.parse().ok().filter(|time: &f64| time.is_finite());
        let from_s = seconds(from);
        let to_s = to.map_or(Some(f64::INFINITY), seconds);
        match from_s.zip(to_s) {
            Some((from_s, to_s)) if from_s >= 0.0 && to_s > from_s => {
                Ok(Self { fault: *fault, from_s, to_s })
            }
            _ => Err(format!(
                "`{}` is not a time: write {name}@SECONDS or {name}@FROM..TO, such as {name}@2 or {name}@2..3.5",
                times.escape_debug()
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scheduled_fault_parses_every_name_and_its_times() {
        for fault in InjectedFault::ALL {
            let scheduled: ScheduledFault =
                fault.to_string().parse().expect("a name, or a name and times");
            assert_eq!(scheduled, ScheduledFault::from(fault, 0.0));
        }
        let scheduled: ScheduledFault =
            "button@2..3.5".parse().expect("a name, or a name and times");
        assert_eq!(
            [1.9, 2.0, 3.4, 3.5].map(|now_s| scheduled.is_active(now_s)),
            [false, true, true, false]
        );
        for (text, words) in [
            ("stuck", "`stuck` is not a fault: use one of stuck-left, "),
            ("button@", "`` is not a time"),
            ("button@x", "`x` is not a time"),
            ("button@-1", "`-1` is not a time"),
            ("button@NaN", "`NaN` is not a time"),
            ("button@3..2", "`3..2` is not a time"),
        ] {
            let message = text.parse::<ScheduledFault>().unwrap_err();
            assert!(message.starts_with(words), "{message}");
        }
    }
}
