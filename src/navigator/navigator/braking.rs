//! The time between observations, and braking without a decision.

use super::Navigator;
use crate::geometry::Twist;
use crate::navigator::observation::CLOCK_JUMP_S;
use crate::navigator::predicted_state::brake;
use crate::navigator::{Decision, Fault, Mode, NavigatorSettings, ObservationFault};

/// How long the observations have been faulty.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FaultyTime {
    /// Since the last valid observation.
    all: FaultyTicks,
    /// Since the last one that was valid, or faulty because the robot is lost or does not see.
    of_sensors: FaultyTicks,
}

/// Faulty ticks in a row, and by how much they were late together, seconds.
#[derive(Clone, Copy, Debug, Default)]
struct FaultyTicks {
    count: u32,
    late_s: f64,
}

impl FaultyTicks {
    fn add(&mut self, late_s: f64) {
        (self.count, self.late_s) = (self.count + 1, self.late_s + late_s);
    }
}

impl FaultyTime {
    /// Counts a faulty observation with the control period and by what it was late, in seconds. Returns the number of faulty ones if
    /// these have lasted for longer than the settings permit. A lost robot has more patience, which a single late scan does not end.
    fn lasts(
        &mut self,
        fault: ObservationFault,
        (period_s, late_s): (f64, f64),
        settings: &NavigatorSettings,
    ) -> Option<u32> {
        self.all.add(late_s);
        let (ticks, patience_s) = match fault {
            ObservationFault::Lost(_)
            | ObservationFault::LidarBlind
            | ObservationFault::LidarPartlyBlind => {
                self.of_sensors = FaultyTicks::default();
                (self.all, settings.localization_patience_s)
            }
            _ => {
                self.of_sensors.add(late_s);
                (self.of_sensors, settings.sensor_fault_patience_s)
            }
        };
        let lasted_s = f64::from(ticks.count) * period_s + ticks.late_s;
        (lasted_s > patience_s).then_some(ticks.count)
    }
}

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
        let mut decision = self.brake_from(&self.base.last_command);
        if self.is_over() {
            return decision;
        }
        decision.mode = Mode::SensorFault;
        // After a jump of the clock, the time before it says nothing about how long the fault has lasted.
        let late_s = if fault == ObservationFault::ClockJump { 0.0 } else { self.tick.late_s() };
        let times_s = (self.tick.period_s(), late_s);
        if let Some(count) = self.faulty.lasts(fault, times_s, &self.settings) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::localization::LostReason;

    /// After how many faulty observations in a row of each 0.1 s a mission ends: of these kinds in turn.
    fn ends_after(faults: &[ObservationFault]) -> Option<usize> {
        let (settings, mut faulty) = (NavigatorSettings::default(), FaultyTime::default());
        let turns = faults.iter().cycle().take(2000);
        let mut lasts = turns.map(|fault| faulty.lasts(*fault, (0.1, 0.0), &settings));
        lasts.position(|lasting| lasting.is_some()).map(|number| number + 1)
    }

    #[test]
    fn one_late_scan_does_not_end_the_patience_with_a_lost_robot() {
        let (lost, late) =
            (ObservationFault::Lost(LostReason::PoorMatch), ObservationFault::NoScan);
        assert_eq!(ends_after(&[late]), Some(31));
        assert_eq!(ends_after(&[lost]), Some(301));
        assert_eq!(ends_after(&[[lost; 100].as_slice(), &[late]].concat()), Some(301));
        // The sensor fault is the lasting one.
        assert_eq!(ends_after(&[&[lost; 100], [late; 100].as_slice()].concat()), Some(131));
    }
}
