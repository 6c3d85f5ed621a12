//! A track's motor under speed control: a DC motor with inertia and friction, and a PI controller.
//!
//! The parameters are chosen for a small 24 V gear motor and belong to no particular product. The track reaches 63 % of a step of
//! its set speed within about 0.05 s.

/// No-load speed of a track, m/s per volt: 1.8 m/s at 24 V, about 1.5 times the default track's highest speed.
const SPEED_PER_V: f64 = 0.075;

/// Mechanical time constant at constant voltage, seconds.
const LAG_S: f64 = 0.12;

/// Rolling resistance as a loss of speed, m/s; a standing track does not start below it.
const FRICTION: f64 = 0.08;

/// Winding resistance, ohm: a blocked motor draws 30 A at 24 V.
const WINDING_OHM: f64 = 0.8;

/// Proportional gain, V per m/s of speed error.
const PROPORTIONAL_GAIN: f64 = 20.0;

/// Integral gain, V per metre of integrated speed error.
const INTEGRAL_GAIN: f64 = 100.0;

/// Weight of a new measurement in the low-pass filtered speed: a slow track moves few ticks per cycle.
const FILTER_WEIGHT: f64 = 0.5;

/// Speed controller of a track, one cycle every 10 ms.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SpeedControl {
    measured: f64,
    integral_v: f64,
}

impl SpeedControl {
    /// The filtered measured speed, m/s.
    pub(super) const fn measured(&self) -> f64 {
        self.measured
    }

    /// Runs one cycle: returns the voltage for a set speed, m/s, from the mean encoder speed since the last cycle, m/s.
    pub(super) fn cycle(
        &mut self,
        set: f64,
        encoder_speed: f64,
        cycle_s: f64,
        battery_v: f64,
    ) -> f64 {
        self.measured += FILTER_WEIGHT * (encoder_speed - self.measured);
        let error = set - self.measured;
        if set == 0.0 {
            // Shorted windings also brake a motor with swapped leads. The integral restarts.
            self.integral_v = 0.0;
            return 0.0;
        }
        let feedforward_v = (set + FRICTION * set.signum()) / SPEED_PER_V;
        let demand_v = feedforward_v + PROPORTIONAL_GAIN * error + self.integral_v;
        let voltage = demand_v.clamp(-battery_v, battery_v);
        // No wind-up while the voltage saturates.
        if voltage == demand_v {
            self.integral_v += INTEGRAL_GAIN * error * cycle_s;
        }
        voltage
    }
}

/// A motor and its track.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motor {
    speed: f64,
    current_a: f64,
}

impl Motor {
    /// Speed of the track, m/s.
    pub(super) const fn speed(&self) -> f64 {
        self.speed
    }

    /// Magnitude of the motor current, A.
    pub(super) const fn current_a(&self) -> f64 {
        self.current_a.abs()
    }

    /// Advances by a short time, seconds, at a voltage. A blocked motor does not move and draws its stall current.
    pub(super) fn run(&mut self, voltage: f64, is_blocked: bool, time_s: f64) {
        let driven = SPEED_PER_V * voltage;
        self.current_a = (driven - self.speed) / SPEED_PER_V / WINDING_OHM;
        if is_blocked {
            self.speed = 0.0;
            return;
        }
        if self.speed == 0.0 && driven.abs() <= FRICTION {
            return;
        }
        let along = if self.speed == 0.0 { driven } else { self.speed };
        let slope = (driven - self.speed - FRICTION * along.signum()) / LAG_S;
        let next = self.speed + slope * time_s;
        // Friction stops a motion and starts none.
        let stops = self.speed * next < 0.0 && driven.abs() <= FRICTION;
        self.speed = if stops { 0.0 } else { next };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Speeds of a track every 10 ms after a step of its set speed.
    fn step_response(start: f64, set: f64, cycles: usize) -> Vec<f64> {
        let (mut motor, mut control) = (Motor::default(), SpeedControl::default());
        let mut run = |set: f64| {
            let voltage = control.cycle(set, motor.speed(), 0.01, 24.0);
            for _ in 0..10 {
                motor.run(voltage, false, 0.001);
            }
            motor.speed()
        };
        for _ in 0..300 {
            run(start);
        }
        (0..cycles).map(|_| run(set)).collect()
    }

    #[test]
    fn speed_control_settles_fast_with_small_overshoot() {
        for (start, set) in [(0.0, 0.5), (0.5, 1.2), (0.5, -0.5), (1.0, 0.0), (0.0, 0.05)] {
            let speeds = step_response(start, set, 200);
            let step = set - start;
            assert!((speeds[14] - set).abs() < 0.3 * step.abs(), "{speeds:?}");
            assert!((speeds[199] - set).abs() < 0.01, "{start} to {set}: {speeds:?}");
            let overshoot = speeds.iter().map(|speed| (speed - set) / step);
            assert!(overshoot.fold(0.0, f64::max) < 0.25, "{speeds:?}");
        }
    }

    #[test]
    fn friction_stops_unpowered_motor_and_starts_none() {
        let mut motor = Motor::default();
        motor.run(1.0, false, 0.001);
        assert_eq!(motor.speed(), 0.0);
        for _ in 0..200 {
            motor.run(12.0, false, 0.001);
        }
        assert!(motor.speed() > 0.5);
        for _ in 0..1000 {
            motor.run(0.0, false, 0.001);
        }
        assert_eq!(motor.speed(), 0.0);
    }
}
