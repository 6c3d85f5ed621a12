//! What may go wrong with an emulated base, and when.

use core::fmt;
use core::str::FromStr;

/// The names of the troubles, as typed.
const NAMES: [(Trouble, &str); 9] = [
    (Trouble::StuckLeft, "stuck-left"),
    (Trouble::StuckRight, "stuck-right"),
    (Trouble::Runaway, "runaway"),
    (Trouble::Reversed, "reversed"),
    (Trouble::Button, "button"),
    (Trouble::Silence, "silence"),
    (Trouble::SlowReads, "slow-reads"),
    (Trouble::Garbage, "garbage"),
    (Trouble::BitFlips, "bit-flips"),
];

/// Something that goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// A stone between the left track and its wheel: it stands, whatever its motor does.
    StuckLeft,
    /// The same on the right.
    StuckRight,
    /// The driver of the left motor is broken and gives it full voltage forward. Only the button stops it.
    Runaway,
    /// The leads of the left motor are swapped, those of its encoder are not: the speed control drives it ever faster the
    /// wrong way, until it is told to stand.
    Reversed,
    /// The emergency button is pressed: the controller knows, and the motors have no power.
    Button,
    /// The base says nothing; it still hears.
    Silence,
    /// The host's bytes are read 0.3 s late.
    SlowReads,
    /// Bursts of random bytes on the line, both ways, ten a second.
    Garbage,
    /// One of two hundred bytes is flipped in a bit, both ways.
    BitFlips,
}

impl Trouble {
    /// All of them.
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

impl fmt::Display for Trouble {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = NAMES.iter().find(|(trouble, _)| trouble == self);
        formatter.write_str(named.map_or("", |(_, name)| name))
    }
}

/// Something that goes wrong from one time to another, seconds since the base was switched on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedTrouble {
    /// What.
    pub trouble: Trouble,
    /// From when on.
    pub from_s: f64,
    /// Until when; infinite for the rest of the time.
    pub to_s: f64,
}

impl PlannedTrouble {
    /// Something that goes wrong from a time on and never ends.
    #[must_use]
    pub const fn from(trouble: Trouble, from_s: f64) -> Self {
        Self {
            trouble,
            from_s,
            to_s: f64::INFINITY,
        }
    }

    /// Whether it holds at a time.
    pub(super) fn holds(&self, now_s: f64) -> bool {
        (self.from_s..self.to_s).contains(&now_s)
    }
}

impl FromStr for PlannedTrouble {
    type Err = String;

    /// `NAME`, `NAME@FROM` or `NAME@FROM..TO`, times in seconds.
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, times) = text.split_once('@').unwrap_or((text, "0"));
        let named = NAMES.iter().find(|(_, known)| *known == name);
        let Some((trouble, _)) = named else {
            let known: Vec<&str> = NAMES.iter().map(|(_, name)| *name).collect();
            return Err(format!(
                "`{}` is no fault: it is one of {}",
                name.escape_debug(),
                known.join(", ")
            ));
        };
        let (from, to) = times
            .split_once("..")
            .map_or((times, None), |(from, to)| (from, Some(to)));
        let seconds = |text: &str| text.parse().ok().filter(|time: &f64| time.is_finite());
        let from_s = seconds(from);
        let to_s = to.map_or(Some(f64::INFINITY), seconds);
        match from_s.zip(to_s) {
            Some((from_s, to_s)) if from_s >= 0.0 && to_s > from_s => Ok(Self {
                trouble: *trouble,
                from_s,
                to_s,
            }),
            _ => Err(format!(
                "`{}` is no time: write {name}@SECONDS or {name}@FROM..TO, such as {name}@2 or {name}@2..3.5",
                times.escape_debug()
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_read_as_it_is_written() {
        for trouble in Trouble::ALL {
            let planned: PlannedTrouble = trouble
                .to_string()
                .parse()
                .expect("a name, or a name and times");
            assert_eq!(planned, PlannedTrouble::from(trouble, 0.0));
        }
        let planned: PlannedTrouble = "button@2..3.5"
            .parse()
            .expect("a name, or a name and times");
        assert_eq!(
            [1.9, 2.0, 3.4, 3.5].map(|now_s| planned.holds(now_s)),
            [false, true, true, false]
        );
        for (text, words) in [
            ("stuck", "`stuck` is no fault: it is one of stuck-left, "),
            ("button@", "`` is no time"),
            ("button@x", "`x` is no time"),
            ("button@-1", "`-1` is no time"),
            ("button@NaN", "`NaN` is no time"),
            ("button@3..2", "`3..2` is no time"),
        ] {
            let message = text.parse::<PlannedTrouble>().unwrap_err();
            assert!(message.starts_with(words), "{message}");
        }
    }
}
