//! What to tell the base now: the policy of the sender, without thread, line or clock.

use thiserror::Error;

use super::KeeperSettings;
use crate::base::{BaseError, BaseSettings, Feedback, Observation, Plausibility, Verdict};
use crate::geometry::Twist;
use crate::robot::Mixer;

/// Longest time that a ramp goes on in one step, seconds: after a pause of the caller speeds must not jump.
const LONGEST_STEP_S: f64 = 0.1;

/// For so long after a release the base may still say that it is stopped, seconds: the command is on its way, and the report
/// back.
const RELEASING_S: f64 = 0.5;

/// What goes to the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// A motion, ramped and within the tracks' limits.
    Run(Twist),
    /// The stop that is latched.
    Stop,
    /// The end of that stop, once.
    Release,
}

/// Why a plan or a release was refused.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Refusal {
    /// A motion or a time that is NaN or infinite.
    #[error("the plan is not a number")]
    NotFinite,
    /// Made for a time before that of the last plan.
    #[error("the plan is {by_s:.3} s older than the last one")]
    OutOfOrder {
        /// By so much.
        by_s: f64,
    },
    /// Made for a time farther ahead than a plan lasts: it would never grow old.
    #[error("the plan is for {ahead_s:.3} s ahead")]
    Ahead {
        /// By so much.
        ahead_s: f64,
    },
    /// A stop is latched.
    #[error("a stop is latched: release it first")]
    Stopped,
    /// The base still moves.
    #[error("the base still moves: a stop is released at a standstill")]
    StillMoving,
}

/// Why a stop is latched.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum StopReason {
    /// Somebody asked for it.
    #[error("a stop was asked for")]
    Asked,
    /// The base does not do what it is told, or says that it cannot.
    #[error(transparent)]
    Verdict(#[from] Verdict),
}

/// What a base is just now told, and why.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Condition {
    /// To stand: nothing has been planned.
    #[default]
    NoPlan,
    /// What is planned.
    Driving,
    /// To brake and stand: the plan is so old, seconds.
    PlanTooOld {
        /// Its age.
        age_s: f64,
    },
    /// To stand: it has not answered since the line was opened.
    NotHeard,
    /// Nothing: there is no line.
    NoLine(BaseError),
    /// To stand, until this is released.
    Stopped(StopReason),
}

/// The policy of the sender. Times in seconds from one origin; nothing in it fails or panics when they run backwards.
#[derive(Clone, Debug)]
pub struct Guard {
    settings: KeeperSettings,
    base: BaseSettings,
    mixer: Mixer,
    judge: Plausibility,
    plan: Option<Plan>,
    /// What the newest plan ever taken was made for.
    newest_s: f64,
    stop: Option<StopReason>,
    release: Release,
    condition: Condition,
    is_heard: bool,
    is_still: bool,
    sent: Twist,
    last_s: Option<f64>,
    refused: u64,
}

#[derive(Clone, Copy, Debug)]
struct Plan {
    twist: Twist,
    for_s: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Release {
    None,
    /// Is to be sent.
    Due,
    /// Was sent at this time, and the base has not yet said that its stop has ended.
    Sent(f64),
}

impl Guard {
    /// A guard of a base that stands and has not been heard.
    ///
    /// # Errors
    /// Those of the settings' own checks.
    pub fn new(base: &BaseSettings, settings: KeeperSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        Ok(Self {
            judge: Plausibility::new(base, settings.plausibility)?,
            settings,
            base: *base,
            mixer: Mixer::new(base.drive(), base.tracks),
            plan: None,
            newest_s: f64::NEG_INFINITY,
            stop: None,
            release: Release::None,
            condition: Condition::NoPlan,
            is_heard: false,
            is_still: true,
            sent: Twist::STOP,
            last_s: None,
            refused: 0,
        })
    }

    /// Takes a motion planned for a time; it replaces the last.
    ///
    /// # Errors
    /// [`Refusal`]: the last plan then stays, and grows old.
    pub fn want(&mut self, twist: &Twist, for_s: f64, now_s: f64) -> Result<(), Refusal> {
        if self.stop.is_some() {
            return Err(Refusal::Stopped);
        }
        let checked = self.check(twist, for_s, now_s);
        match checked {
            Ok(()) => {
                self.newest_s = for_s;
                self.plan = Some(Plan {
                    twist: *twist,
                    for_s,
                });
            }
            Err(_) => self.refused += 1,
        }
        checked
    }

    fn check(&self, twist: &Twist, for_s: f64, now_s: f64) -> Result<(), Refusal> {
        if !(twist.is_finite() && for_s.is_finite()) {
            return Err(Refusal::NotFinite);
        }
        if for_s < self.newest_s {
            let by_s = self.newest_s - for_s;
            return Err(Refusal::OutOfOrder { by_s });
        }
        let ahead_s = for_s - now_s;
        if ahead_s > self.settings.plan_within_s {
            return Err(Refusal::Ahead { ahead_s });
        }
        Ok(())
    }

    /// Latches a stop. One that is latched already keeps its reason.
    pub fn stop(&mut self, reason: StopReason) {
        self.stop = self.stop.or(Some(reason));
        self.plan = None;
        self.release = Release::None;
    }

    /// Ends a stop that is latched, as an operator's explicit wish: the base stands until the next plan. What still holds is
    /// found again.
    ///
    /// # Errors
    /// [`Refusal::StillMoving`] for a base that says so.
    pub fn release(&mut self) -> Result<(), Refusal> {
        if self.is_heard && !self.is_still {
            return Err(Refusal::StillMoving);
        }
        self.stop = None;
        self.plan = None;
        self.release = Release::Due;
        self.judge.release();
        Ok(())
    }

    /// What goes to the base now. To be called at the fixed rate, and what it returns to be sent.
    pub fn order(&mut self, now_s: f64) -> Order {
        let elapsed_s = now_s - self.last_s.replace(now_s).unwrap_or(now_s);
        let elapsed_s = elapsed_s.clamp(0.0, LONGEST_STEP_S);
        if let Some(reason) = self.stop {
            self.stand(Condition::Stopped(reason));
            return Order::Stop;
        }
        if self.release == Release::Due && self.is_heard {
            self.release = Release::Sent(now_s);
            self.stand(Condition::NoPlan);
            return Order::Release;
        }
        if !self.is_heard {
            self.stand(Condition::NotHeard);
            return Order::Run(Twist::STOP);
        }
        let wanted = self.wanted(now_s);
        let told = self.mixer.mix(&wanted, elapsed_s);
        self.sent = self.mixer.twist(&told);
        Order::Run(self.sent)
    }

    /// The motion that is planned, if the plan still counts.
    fn wanted(&mut self, now_s: f64) -> Twist {
        let Some(Plan { twist, for_s }) = self.plan else {
            self.condition = Condition::NoPlan;
            return Twist::STOP;
        };
        let age_s = now_s - for_s;
        // A plan for a time far ahead is one of before the clock ran backwards.
        if age_s.abs() > self.settings.plan_within_s {
            self.condition = Condition::PlanTooOld { age_s };
            return Twist::STOP;
        }
        self.condition = Condition::Driving;
        twist
    }

    /// Begins anew from a standstill, for a reason; that there is no line comes before all others.
    fn stand(&mut self, why: Condition) {
        if !matches!(self.condition, Condition::NoLine(_)) {
            self.condition = why;
        }
        self.mixer.reset();
        self.sent = Twist::STOP;
    }

    /// Takes the base's newest report, which may be the same again.
    pub fn heard(&mut self, feedback: &Feedback, now_s: f64) {
        self.is_heard = true;
        let tracks = self.base.drive().tracks(&feedback.twist);
        let fastest = tracks.left.abs().max(tracks.right.abs());
        self.is_still = fastest < self.settings.plausibility.sure_to_move;
        if self.stop.is_some() {
            return;
        }
        match self.release {
            Release::Due => return,
            Release::Sent(at_s) if feedback.emergency_stop && now_s - at_s < RELEASING_S => return,
            _ => self.release = Release::None,
        }
        let look = Observation {
            now_s,
            sent: self.sent,
            feedback: *feedback,
        };
        if let Some(verdict) = self.judge.judge(&look).copied() {
            self.stop(StopReason::Verdict(verdict));
        }
    }

    /// The line has failed, or could not be opened.
    pub fn line_lost(&mut self, why: BaseError) {
        self.is_heard = false;
        self.condition = Condition::NoPlan;
        self.stand(Condition::NoLine(why));
    }

    /// A line was opened: the base is not known to hear.
    pub fn line_opened(&mut self) {
        self.is_heard = false;
        self.condition = Condition::NoPlan;
        self.stand(Condition::NotHeard);
    }

    /// What the base was last told, and why.
    #[must_use]
    pub const fn condition(&self) -> &Condition {
        &self.condition
    }

    /// The stop that is latched, if any.
    #[must_use]
    pub const fn stopped(&self) -> Option<&StopReason> {
        self.stop.as_ref()
    }

    /// What the base was last told.
    #[must_use]
    pub const fn sent(&self) -> &Twist {
        &self.sent
    }

    /// Plans refused so far because they made no sense.
    #[must_use]
    pub const fn refused(&self) -> u64 {
        self.refused
    }
}
