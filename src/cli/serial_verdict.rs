//! Whether a robot on an emulated serial line did what its case requires.

use inbye::experiment::FaultRow;
use inbye::geometry::Twist;
use serde_json::Value;

/// Least distance that a robot drives before and after the fault, metres: one that does not drive proves nothing.
const MIN_TRAVEL_M: f64 = 1.5;

/// Time by which the last motion may precede a fault that makes the robot stand at once, seconds.
const SETTLED_S: f64 = 0.1;

/// Zero commands at the end of a program.
const FINAL_ZEROS: u64 = 3;

/// Distance to the goal within which a robot has reached it, metres, and the one within which it is parked, with its yaw, radians.
const AT_GOAL_M: f64 = 0.1;
const PARKED_M: f64 = 0.02;
const PARKED_RAD: f64 = 0.01;

/// What must follow a fault. Each but the last forbids a contact that the robot causes.
#[derive(Clone, Copy, Debug)]
pub enum Required {
    /// The robot stands for good within this time, seconds.
    Stands(f64),
    /// The same, and the last commands are zeros.
    StandsByZeros(f64),
    /// The robot stands within this time, seconds, and may drive on.
    Pauses(f64),
    /// The same by the base's watchdog, and the first commands after it are zeros.
    Restarts(f64),
    /// No contact; the robot may drive on.
    NoContact,
    /// The drive ends at its goal.
    Reaches,
    /// The drive ends at its goal, or with a reason; it does not end elsewhere as if that were the goal.
    FoundOrLost,
    /// The robot parks precisely, within this time after it is first 0.25 m from its goal, seconds.
    Parks(f64),
    /// The drive ends with a reason: no command reaches such a base, so only its own watchdog or its operator can stop it.
    Reported,
}

/// A drive: what the emulated base measured, and what the process that drove it wrote.
#[derive(Clone, Debug, Default)]
pub struct SerialOutcome {
    /// Time of the last motion after the fault, and of the first standstill, seconds.
    pub stood_s: f64,
    pub first_stood_s: Option<f64>,
    /// Whether the robot stood already when the fault began.
    pub stood_before: bool,
    /// Speed at the end, m/s.
    pub speed_m_s: f64,
    pub travelled_m: f64,
    pub min_gap_m: f64,
    pub robot_touched: bool,
    pub final_zeros: u64,
    pub watchdog_stops: u64,
    pub zeros_after_watchdog: u64,
    /// True distance to the goal, metres, and difference of the yaw, radians, for a goal with a yaw.
    pub error_m: f64,
    pub yaw_error_rad: Option<f64>,
    /// Time from the first pose within 0.25 m of the goal to the end of the drive, seconds.
    pub parking_s: Option<f64>,
    pub reached: bool,
    pub reason: Option<String>,
}

impl SerialOutcome {
    /// Reads the summaries of an emulated base and of its drive, null for a drive that was killed. The fault began at `at_s`, the drive
    /// ended at `end_s` by the base's clock, seconds.
    pub fn read(base: &Value, driven: &Value, (at_s, end_s): (f64, f64)) -> Option<Self> {
        let number = |name: &str| base[name].as_f64();
        let standstills: Vec<(f64, f64)> =
            serde_json::from_value(base["standstills"].clone()).ok()?;
        let after = standstills.iter().find(|(_, to_s)| *to_s > at_s);
        let stood_before = after.is_some_and(|(from_s, _)| *from_s < at_s - SETTLED_S);
        Some(Self {
            stood_s: (number("last_motion_s")? - at_s).max(0.0),
            first_stood_s: after.map(|(from_s, _)| (from_s - at_s).max(0.0)),
            stood_before,
            speed_m_s: number("linear")?.abs(),
            travelled_m: number("travelled_m")?,
            min_gap_m: number("min_gap_m")?,
            robot_touched: base["robot_touched"].as_bool()?,
            final_zeros: base["final_zero_commands"].as_u64()?,
            watchdog_stops: base["watchdog_stops"].as_u64()?,
            zeros_after_watchdog: base["zero_commands_after_watchdog"].as_u64()?,
            parking_s: number("parking_from_s").map(|from_s| end_s - from_s),
            reached: driven["reached"] == true,
            reason: driven["fault"].as_str().map(str::to_owned),
            ..Self::default()
        })
    }

    /// Writes the drive into its row, with whether it did what is required.
    pub fn judge(&self, required: Required, row: &mut FaultRow) {
        let (stood_s, limit_s) = match required {
            Required::Stands(limit_s) | Required::StandsByZeros(limit_s) => {
                (Some(self.stood_s), Some(limit_s))
            }
            Required::Pauses(limit_s) | Required::Restarts(limit_s) => {
                (self.first_stood_s, Some(limit_s))
            }
            Required::Parks(limit_s) => (None, Some(limit_s)),
            _ => (None, None),
        };
        (row.stood_s, row.limit_s) = (stood_s, limit_s);
        row.min_gap_m = Some(self.min_gap_m);
        row.contacts_robot = usize::from(self.robot_touched);
        if matches!(required, Required::Reaches | Required::Parks(_)) {
            row.final_error_m = Some(self.error_m);
            row.final_yaw_error_rad = self.yaw_error_rad;
        }
        if matches!(required, Required::Parks(_)) {
            row.parking_s = self.parking_s;
        }
        let failure = self.failure(required);
        row.passed = failure.is_none();
        row.reason = match (failure, self.reason.clone()) {
            (Some(failure), Some(reason)) => Some(format!("{failure} ({reason})")),
            (failure, reason) => failure.or(reason),
        };
    }

    /// Why the drive did not do what is required, if so.
    fn failure(&self, required: Required) -> Option<String> {
        if self.travelled_m < MIN_TRAVEL_M {
            return Some(format!("the robot drove {:.2} m only", self.travelled_m));
        }
        if self.stood_before {
            return Some("the robot stood before the fault".to_owned());
        }
        if self.robot_touched && !matches!(required, Required::Reported) {
            return Some("the robot caused a contact".to_owned());
        }
        let late = |stood_s: Option<f64>, limit_s: f64| match stood_s {
            Some(stood_s) if stood_s <= limit_s => None,
            Some(stood_s) => Some(format!("the robot stood after {stood_s:.2} s")),
            None => Some("the robot did not stand".to_owned()),
        };
        let moves = || {
            (self.speed_m_s >= Twist::STANDING)
                .then(|| "the robot still moves at the end".to_owned())
        };
        let elsewhere = || {
            (self.error_m > AT_GOAL_M)
                .then(|| format!("the drive ended {:.2} m from its goal", self.error_m))
        };
        let unreached = || (!self.reached).then(|| "the drive did not reach its goal".to_owned());
        match required {
            Required::Stands(limit_s) => late(Some(self.stood_s), limit_s).or_else(moves),
            Required::StandsByZeros(limit_s) => {
                let zeros = self.final_zeros;
                let missing =
                    (zeros < FINAL_ZEROS).then(|| format!("{zeros} zero commands at the end"));
                late(Some(self.stood_s), limit_s).or_else(moves).or(missing)
            }
            Required::Pauses(limit_s) => late(self.first_stood_s, limit_s),
            Required::Restarts(limit_s) => {
                let starts = self.watchdog_stops > 0 && self.zeros_after_watchdog == 0;
                let starts = starts.then(|| "a motion came first after the gap".to_owned());
                late(self.first_stood_s, limit_s).or(starts)
            }
            Required::NoContact => None,
            Required::Reaches => unreached().or_else(elsewhere),
            Required::FoundOrLost if self.reached => elsewhere(),
            Required::FoundOrLost | Required::Reported => match self.reason {
                Some(_) => None,
                None => Some("the drive ended without a reason".to_owned()),
            },
            Required::Parks(limit_s) => unreached().or_else(|| self.unparked(limit_s)),
        }
    }

    /// Why a robot that has reached its goal is not parked in time, if so.
    fn unparked(&self, limit_s: f64) -> Option<String> {
        let yaw_error_rad = self.yaw_error_rad.unwrap_or(0.0);
        if self.error_m > PARKED_M || yaw_error_rad > PARKED_RAD {
            let error_m = self.error_m;
            return Some(format!("parked {error_m:.3} m and {yaw_error_rad:.3} rad off"));
        }
        match self.parking_s {
            Some(parking_s) if parking_s <= limit_s => None,
            Some(parking_s) => Some(format!("parking took {parking_s:.1} s")),
            None => Some("the robot was never at its goal".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// A robot that stood 1 s after the fault, and drove on to its goal.
    fn good() -> SerialOutcome {
        SerialOutcome {
            stood_s: 1.0,
            first_stood_s: Some(1.0),
            travelled_m: 8.0,
            min_gap_m: 0.5,
            final_zeros: 5,
            watchdog_stops: 1,
            zeros_after_watchdog: 5,
            error_m: 0.01,
            yaw_error_rad: Some(0.005),
            parking_s: Some(4.0),
            reached: true,
            ..SerialOutcome::default()
        }
    }

    const ALL: [Required; 9] = [
        Required::Stands(1.5),
        Required::StandsByZeros(1.5),
        Required::Pauses(1.5),
        Required::Restarts(1.5),
        Required::NoContact,
        Required::Reaches,
        Required::FoundOrLost,
        Required::Parks(5.0),
        Required::Reported,
    ];

    /// The requirements that a drive fails, by their index in `ALL`.
    fn failed(change: impl Fn(&mut SerialOutcome)) -> Vec<usize> {
        let mut outcome = good();
        change(&mut outcome);
        let passes = |required: &Required| {
            let mut row = FaultRow::new("a", "b");
            outcome.judge(*required, &mut row);
            assert_eq!(row.passed, outcome.failure(*required).is_none());
            row.passed
        };
        (0..ALL.len()).filter(|&index| !passes(&ALL[index])).collect()
    }

    #[test]
    fn each_requirement_fails_for_its_own_reasons_only() {
        // The last one needs a reason.
        assert_eq!(failed(|_| {}), [8]);
        let with = |change: fn(&mut SerialOutcome)| {
            failed(|outcome| {
                outcome.reason = Some("a fault".to_owned());
                change(outcome);
            })
        };
        assert!(with(|_| {}).is_empty());
        assert_eq!(with(|outcome| outcome.travelled_m = 1.0), [0, 1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(with(|outcome| outcome.robot_touched = true), [0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(with(|outcome| outcome.stood_before = true), [0, 1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(with(|outcome| outcome.stood_s = 1.6), [0, 1]);
        assert_eq!(with(|outcome| outcome.speed_m_s = 0.1), [0, 1]);
        assert_eq!(with(|outcome| outcome.final_zeros = 2), [1]);
        assert_eq!(with(|outcome| outcome.first_stood_s = None), [2, 3]);
        assert_eq!(with(|outcome| outcome.zeros_after_watchdog = 0), [3]);
        assert_eq!(with(|outcome| outcome.reached = false), [5, 7]);
        assert_eq!(with(|outcome| outcome.error_m = 0.05), [7]);
        assert_eq!(with(|outcome| outcome.error_m = 10.0), [5, 6, 7]);
        assert_eq!(with(|outcome| outcome.yaw_error_rad = Some(0.02)), [7]);
        assert_eq!(with(|outcome| outcome.parking_s = Some(25.0)), [7]);
        // A lost robot that stands with a reason has not claimed its goal.
        let lost = |outcome: &mut SerialOutcome| (outcome.reached, outcome.error_m) = (false, 10.0);
        assert_eq!(with(lost), [5, 7]);
    }

    #[test]
    fn first_standstill_is_the_first_one_that_lasts_beyond_the_fault() {
        let base = json!({
            "last_motion_s": 20.0, "standstills": [[0.0, 4.0], [10.25, 12.0], [20.0, 30.0]],
            "linear": 0.0, "travelled_m": 9.0, "min_gap_m": 0.4, "robot_touched": false,
            "final_zero_commands": 3, "watchdog_stops": 1, "zero_commands_after_watchdog": 4,
            "parking_from_s": 18.0,
        });
        let driven = json!({ "reached": true, "fault": null });
        let outcome = SerialOutcome::read(&base, &driven, (9.0, 24.0)).expect("complete");
        assert_eq!((outcome.first_stood_s, outcome.stood_s), (Some(1.25), 11.0));
        assert_eq!((outcome.parking_s, outcome.reached), (Some(6.0), true));
        assert!(SerialOutcome::read(&json!({}), &driven, (9.0, 24.0)).is_none());
    }
}
