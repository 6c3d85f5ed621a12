//! The time between observations, and braking without a decision.

use super::Navigator;
use crate::geometry::Twist;
use crate::navigator::observation::CLOCK_JUMP_S;
use crate::navigator::state::brake;
use crate::navigator::{Decision, Fault, Mode, ObservationFault};

impl Navigator {
    /// Measures the time since the last observation. During a pause of the control loop the robot was not stuck, nor did it park.
    pub(super) fn measure_tick(&mut self, now_s: f64) {
        self.tick = self.tick_clock.tick(now_s).at_least_a_period();
        if self.tick.elapsed_s() > CLOCK_JUMP_S {
            self.progress.pause(self.tick.late_s());
            self.behaviours.start_leg();
        }
    }

    /// Brakes from the last command, since pose and speed are unknown; fails when that lasts. Otherwise the present mode
    /// continues after the fault.
    pub(super) fn brake_without_observation(&mut self, fault: ObservationFault) -> Decision {
        let count = self.validator.faults_in_a_row;
        let mut decision = self.brake_from(&self.base.last_command);
        if self.is_over() {
            return decision;
        }
        decision.mode = Mode::SensorFault;
        let patience_s = match fault {
            ObservationFault::Lost(_)
            | ObservationFault::LidarBlind
            | ObservationFault::LidarPartlyBlind => self.settings.localization_patience_s,
            _ => self.settings.sensor_fault_patience_s,
        };
        // After a jump of the clock, the time before it says nothing about how long the fault has lasted.
        let late_s = if fault == ObservationFault::ClockJump { 0.0 } else { self.tick.late_s() };
        self.faulty_late_s = if count == 1 { 0.0 } else { self.faulty_late_s } + late_s;
        if f64::from(count) * self.tick.period_s() + self.faulty_late_s > patience_s {
            self.fail(Fault::FaultyObservation { fault, count });
            decision.mode = Mode::Failed;
        }
        decision
    }

    /// Brakes from a velocity or from the last command, whichever is slower, in the present mode.
    pub(super) fn brake_from(&self, twist: &Twist) -> Decision {
        let command = brake(&self.robot.limits, twist, &self.base.last_command, self.tick);
        Decision::new(command, self.mode, self.goal().position)
    }
}
