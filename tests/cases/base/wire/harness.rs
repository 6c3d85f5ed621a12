//! The safety controller of a base with a simulated clock.

use inbye::base::{
    BaseSettings, CommandRejected, DriveStatus, Feedback, OutgoingCommand, SafetyController,
    SupervisorSettings,
};
use inbye::geometry::Twist;

pub const PERIOD_S: f64 = 0.02;
pub const AHEAD: Twist = Twist::new(0.6, 0.0);

/// A controller, a base that follows its commands at once, and a clock.
pub struct Harness {
    pub controller: SafetyController,
    pub now_s: f64,
    /// The base's feedback except its motion.
    pub report: Feedback,
    /// Whether the base follows its commands; it keeps the motion of `report` otherwise.
    pub follows: bool,
    /// The motion of the base.
    pub base: Twist,
    pub commands: Vec<OutgoingCommand>,
}

impl Harness {
    /// Starts after the first report of a base that stands.
    pub fn new() -> Self {
        let mut harness = Self::without_feedback();
        harness.cycle();
        harness
    }

    pub fn without_feedback() -> Self {
        let settings = SupervisorSettings::default();
        Self {
            controller: SafetyController::new(&BaseSettings::default(), settings)
                .expect("valid settings"),
            now_s: 100.0,
            report: Feedback::default(),
            follows: true,
            base: Twist::STOP,
            commands: Vec::new(),
        }
    }

    /// A base that has stood for a second.
    pub fn standing() -> Self {
        let mut harness = Self::without_feedback();
        harness.cycles(1.0);
        harness
    }

    /// A base that has reached its target, which is set in every cycle.
    pub fn driving() -> Self {
        let mut harness = Self::standing();
        for _ in 0..50 {
            harness.set_target(0.0).expect("a valid target");
            harness.cycle();
        }
        assert_eq!(harness.base, AHEAD);
        harness
    }

    /// Sets a target with a stamp of this age, seconds.
    pub fn set_target(&mut self, age_s: f64) -> Result<(), CommandRejected> {
        self.controller.set_target(&AHEAD, self.now_s - age_s, self.now_s)
    }

    /// Takes a report of the base.
    pub fn on_feedback(&mut self, feedback: Feedback) {
        self.controller.on_feedback(&feedback, self.now_s);
    }

    pub fn next_command(&mut self) -> OutgoingCommand {
        self.next_after(PERIOD_S)
    }

    pub fn next_after(&mut self, elapsed_s: f64) -> OutgoingCommand {
        self.now_s += elapsed_s;
        let command = self.controller.next_command(self.now_s);
        self.commands.push(command);
        command
    }

    pub fn cycle(&mut self) -> OutgoingCommand {
        self.cycle_after(PERIOD_S)
    }

    pub fn cycle_after(&mut self, elapsed_s: f64) -> OutgoingCommand {
        let command = self.next_after(elapsed_s);
        self.base = match command {
            OutgoingCommand::Drive(twist) if self.follows => twist,
            OutgoingCommand::Drive(_) => self.report.twist,
            OutgoingCommand::EngageStop | OutgoingCommand::ReleaseStop => Twist::STOP,
        };
        self.on_feedback(Feedback { twist: self.base, ..self.report });
        command
    }

    pub fn cycles(&mut self, time_s: f64) {
        for _ in 0..(time_s / PERIOD_S).round() as usize {
            self.cycle();
        }
    }

    /// Sets a target ten times per second.
    pub fn drive(&mut self, twist: Twist, time_s: f64) {
        for _ in 0..(time_s / 0.1).round() as usize {
            self.controller.set_target(&twist, self.now_s, self.now_s).expect("a valid target");
            self.cycles(0.1);
        }
    }

    pub fn speed(&self) -> f64 {
        self.controller.sent().linear
    }

    pub fn status(&self) -> &DriveStatus {
        self.controller.status()
    }
}
