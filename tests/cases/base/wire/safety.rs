//! The sender's policy by a made clock: what it tells a base when, and why.

use inbye::base::{
    BaseError, BaseSettings, CommandRejected, DriveStatus, Faults, Feedback, OutgoingCommand,
    SafetyController, StopCause, SupervisorSettings,
};
use inbye::geometry::Twist;

const PERIOD_S: f64 = 0.02;
const AHEAD: Twist = Twist::new(0.6, 0.0);

/// A guard, a base that does what it is told, and a clock.
struct Watch {
    guard: SafetyController,
    now_s: f64,
    /// What the base says besides its motion.
    says: Feedback,
    is_obedient: bool,
    orders: Vec<OutgoingCommand>,
}

impl Watch {
    /// After the first report of a base that stands.
    fn new() -> Self {
        let mut watch = Self::unheard();
        watch.round();
        watch
    }

    fn unheard() -> Self {
        let settings = SupervisorSettings::default();
        Self {
            guard: SafetyController::new(&BaseSettings::default(), settings)
                .expect("valid settings"),
            now_s: 100.0,
            says: Feedback::default(),
            is_obedient: true,
            orders: Vec::new(),
        }
    }

    fn next_command(&mut self) -> OutgoingCommand {
        self.now_s += PERIOD_S;
        let order = self.guard.next_command(self.now_s);
        self.orders.push(order);
        order
    }

    fn round(&mut self) -> OutgoingCommand {
        let order = self.next_command();
        let motion = match order {
            OutgoingCommand::Drive(twist) if self.is_obedient => twist,
            OutgoingCommand::Drive(_) => self.says.twist,
            OutgoingCommand::EngageStop | OutgoingCommand::ReleaseStop => Twist::STOP,
        };
        let feedback = Feedback {
            twist: motion,
            ..self.says
        };
        self.guard.on_feedback(&feedback, self.now_s);
        order
    }

    fn rounds(&mut self, time_s: f64) {
        for _ in 0..(time_s / PERIOD_S).round() as usize {
            self.round();
        }
    }

    /// A planner of ten plans a second.
    fn plan(&mut self, twist: Twist, time_s: f64) {
        for _ in 0..(time_s / 0.1).round() as usize {
            self.guard
                .set_target(&twist, self.now_s, self.now_s)
                .expect("a good plan");
            self.rounds(0.1);
        }
    }

    fn speed(&self) -> f64 {
        self.guard.sent().linear
    }
}

#[test]
fn a_plan_is_ramped_up_and_followed() {
    let mut watch = Watch::new();
    assert_eq!(*watch.guard.status(), DriveStatus::AwaitingFeedback);
    watch.round();
    assert_eq!(*watch.guard.status(), DriveStatus::NoTarget);
    watch.plan(AHEAD, 1.0);
    assert_eq!(*watch.guard.status(), DriveStatus::Driving);
    assert_eq!(watch.speed(), 0.6);
    let speeds: Vec<f64> = watch
        .orders
        .iter()
        .map(|order| match order {
            OutgoingCommand::Drive(twist) => twist.linear,
            other => panic!("{other:?}"),
        })
        .collect();
    // 1.5 m/s^2.
    assert!(speeds.windows(2).all(|pair| pair[1] - pair[0] < 0.0301));
}

/// The planner's thread may live and answer as it likes: what counts is what its last plan was made for.
#[test]
fn a_plan_that_is_too_old_brakes_the_base_whoever_repeats_it() {
    let mut watch = Watch::new();
    watch.plan(AHEAD, 1.0);
    let stuck_s = watch.now_s;
    let mut stopped_after_s = None;
    for _ in 0..100 {
        // A hung planner that sends the same plan again and again.
        let _ = watch.guard.set_target(&AHEAD, stuck_s - 0.1, watch.now_s);
        watch.round();
        if watch.speed() == 0.0 {
            stopped_after_s = stopped_after_s.or(Some(watch.now_s - stuck_s));
        }
    }
    // 0.2 s until it is too old, and 0.4 s to brake from 0.6 m/s at 1.5 m/s^2.
    let stopped_after_s = stopped_after_s.expect("it stopped");
    assert!((0.55..0.67).contains(&stopped_after_s), "{stopped_after_s}");
    assert!(matches!(
        watch.guard.status(),
        DriveStatus::TargetExpired { age_s } if *age_s > 1.0
    ));
    watch.plan(AHEAD, 1.0);
    assert_eq!(watch.speed(), 0.6, "a new plan is followed again");
}

#[test]
fn plans_that_make_no_sense_are_refused_counted_and_change_nothing() {
    let mut watch = Watch::new();
    watch.plan(AHEAD, 1.0);
    let now_s = watch.now_s;
    let mut want = |twist, for_s| watch.guard.set_target(&twist, for_s, now_s);
    let bad = Twist::new(f64::NAN, 0.0);
    assert_eq!(want(bad, now_s), Err(CommandRejected::NotFinite));
    assert_eq!(
        want(Twist::new(0.0, f64::INFINITY), now_s),
        Err(CommandRejected::NotFinite)
    );
    assert_eq!(want(Twist::STOP, f64::NAN), Err(CommandRejected::NotFinite));
    assert!(matches!(
        want(Twist::STOP, now_s - 0.5),
        Err(CommandRejected::OutOfOrder { .. })
    ));
    assert!(matches!(
        want(Twist::STOP, now_s + 0.4),
        Err(CommandRejected::TooFarAhead { .. })
    ));
    assert_eq!(watch.guard.rejected(), 5);
    watch.round();
    assert_eq!(watch.speed(), 0.6);
}

#[test]
fn a_clock_that_runs_backwards_stops_the_base() {
    let mut watch = Watch::new();
    watch.plan(AHEAD, 1.0);
    watch.now_s = 3.0;
    watch.rounds(1.0);
    assert_eq!(watch.speed(), 0.0);
}

#[test]
fn after_a_pause_of_the_sender_speeds_do_not_jump() {
    let mut watch = Watch::new();
    watch.plan(AHEAD, 0.1);
    let before = watch.speed();
    watch.now_s += 5.0;
    let now_s = watch.now_s;
    watch
        .guard
        .set_target(&AHEAD, now_s, now_s)
        .expect("a good plan");
    watch.round();
    assert!(watch.speed() - before <= 0.15 + 1e-9);
}

#[test]
fn a_stop_is_latched_until_it_is_released_and_then_a_new_plan_is_needed() {
    let mut watch = Watch::new();
    watch.plan(AHEAD, 1.0);
    watch.guard.stop(StopCause::Requested);
    assert_eq!(watch.round(), OutgoingCommand::EngageStop);
    let now_s = watch.now_s;
    assert_eq!(
        watch.guard.set_target(&AHEAD, now_s, now_s),
        Err(CommandRejected::Stopped)
    );
    watch.rounds(5.0);
    assert_eq!(watch.guard.stop_cause(), Some(&StopCause::Requested));
    assert!(
        watch.orders[watch.orders.len() - 200..]
            .iter()
            .all(|order| *order == OutgoingCommand::EngageStop)
    );
    watch.guard.release().expect("it stands");
    assert_eq!(watch.round(), OutgoingCommand::ReleaseStop);
    watch.rounds(1.0);
    assert_eq!(watch.round(), OutgoingCommand::Drive(Twist::STOP));
    watch.plan(AHEAD, 1.0);
    assert_eq!(watch.speed(), 0.6);
}

#[test]
fn a_base_that_moves_is_not_released() {
    let mut watch = Watch::new();
    watch.guard.stop(StopCause::Requested);
    watch.round();
    let runs = Feedback {
        twist: Twist::new(0.3, 0.0),
        ..Feedback::default()
    };
    watch.guard.on_feedback(&runs, watch.now_s);
    assert_eq!(watch.guard.release(), Err(CommandRejected::StillMoving));
    assert_eq!(watch.round(), OutgoingCommand::EngageStop);
    watch.guard.release().expect("it stands by now");
}

#[test]
fn a_base_that_is_doubted_is_stopped_with_the_judges_words() {
    let mut watch = Watch::new();
    watch.is_obedient = false;
    // It stands, whatever it is told.
    for _ in 0..20 {
        let now_s = watch.now_s;
        let _ = watch.guard.set_target(&AHEAD, now_s, now_s);
        watch.rounds(0.1);
    }
    let reason = watch.guard.stop_cause().expect("a stuck base is stopped");
    assert!(matches!(reason, StopCause::Stuck { .. }));
    let words = reason.to_string();
    assert!(words.starts_with("the left track stands"), "{words}");
    assert_eq!(watch.round(), OutgoingCommand::EngageStop);
}

#[test]
fn the_bases_own_stop_is_kept_and_may_end_late_after_a_release() {
    let mut watch = Watch::new();
    watch.says.emergency_stop = true;
    watch.round();
    let button = StopCause::EmergencyStop;
    assert_eq!(watch.guard.stop_cause(), Some(&button));
    // Released too early: it is found again.
    watch.guard.release().expect("it stands");
    watch.rounds(0.6);
    assert_eq!(watch.guard.stop_cause(), Some(&button));
    // The button is out, and the base needs a moment to say so.
    watch.guard.release().expect("it stands");
    watch.rounds(0.2);
    watch.says.emergency_stop = false;
    watch.rounds(1.0);
    assert_eq!(watch.guard.stop_cause(), None);
    watch.says.emergency_stop = true;
    watch.round();
    assert_eq!(watch.guard.stop_cause(), Some(&button));
}

#[test]
fn a_fault_of_the_base_is_a_stop_and_its_watchdog_is_none() {
    let mut watch = Watch::new();
    watch.says.faults = Faults::WATCHDOG;
    watch.rounds(0.2);
    assert_eq!(watch.guard.stop_cause(), None);
    watch.says.faults = Faults::OVERHEATED;
    watch.round();
    let words = watch.guard.stop_cause().expect("a stop").to_string();
    assert_eq!(words, "the base reports: overheated");
}

#[test]
fn a_lost_line_stops_and_a_new_one_begins_with_zeros() {
    let mut watch = Watch::new();
    watch.plan(AHEAD, 1.0);
    let why = BaseError::Disconnected {
        port: "port".to_owned(),
    };
    watch.guard.on_disconnect(why.clone());
    watch.next_command();
    assert_eq!(*watch.guard.status(), DriveStatus::Disconnected(why));
    let new_line = |watch: &mut Watch| {
        watch.guard.on_connect();
        let now_s = watch.now_s;
        watch
            .guard
            .set_target(&AHEAD, now_s, now_s)
            .expect("a good plan");
        watch.next_command()
    };
    assert_eq!(new_line(&mut watch), OutgoingCommand::Drive(Twist::STOP));
    // Zeros until the base is heard, and then the ramp from a standstill.
    for _ in 0..5 {
        assert_eq!(watch.next_command(), OutgoingCommand::Drive(Twist::STOP));
    }
    assert_eq!(*watch.guard.status(), DriveStatus::AwaitingFeedback);
    watch.guard.on_feedback(&Feedback::default(), watch.now_s);
    let OutgoingCommand::Drive(first) = watch.next_command() else {
        panic!("no stop was asked for");
    };
    assert!(first.linear <= 0.03 + 1e-9, "{first:?}");
}

/// A stop that was latched before the line was lost holds on the new one.
#[test]
fn a_stop_outlives_its_line() {
    let mut watch = Watch::new();
    watch.guard.stop(StopCause::Requested);
    watch.guard.on_disconnect(BaseError::Disconnected {
        port: "port".to_owned(),
    });
    watch.guard.on_connect();
    assert_eq!(watch.round(), OutgoingCommand::EngageStop);
    assert_eq!(watch.guard.stop_cause(), Some(&StopCause::Requested));
}
