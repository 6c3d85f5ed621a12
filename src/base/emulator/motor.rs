//! A track's motor under speed control: a direct-current motor with inertia and friction, and a PI controller.
//!
//! The numbers are our own choice for a small geared motor of 24 V; none is of a certain product. They make a track that
//! follows a step of its set speed to 63 % within about 0.05 s.

/// Speed of a track without load, m/s for each volt: 1.8 m/s at 24 V, half as much again as the default track asks for.
const SPEED_PER_V: f64 = 0.075;

/// Time constant by inertia, at constant voltage, seconds.
const LAG_S: f64 = 0.12;

/// Rolling resistance as the speed that it costs, m/s; below it a standing track does not start.
const FRICTION: f64 = 0.08;

/// Resistance of the windings, ohm: 30 A through a motor that is held at 24 V.
const WINDING_OHM: f64 = 0.8;

/// Gain of the controller, V for each m/s that is missing.
const PROPORTIONAL: f64 = 20.0;

/// Its integral gain, V for each metre that is missing.
const INTEGRAL: f64 = 100.0;

/// Share of a new measurement in the controller's speed: in one turn a slow track moves few ticks.
const FRESH: f64 = 0.5;

/// The speed control of a track, one turn each 10 ms.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SpeedControl {
    measured: f64,
    integral_v: f64,
}

impl SpeedControl {
    /// The speed it measures, m/s.
    pub(super) const fn measured(&self) -> f64 {
        self.measured
    }

    /// One turn: the voltage for a set speed, m/s, by the speed that the encoder showed since the last turn, and the battery.
    pub(super) fn turn(&mut self, set: f64, shown: f64, turn_s: f64, battery_v: f64) -> f64 {
        self.measured += FRESH * (shown - self.measured);
        let missing = set - self.measured;
        if set == 0.0 {
            // The windings are shorted: that brakes also a motor whose leads are swapped. Nothing is made up for later.
            self.integral_v = 0.0;
            return 0.0;
        }
        let known_v = (set + FRICTION * set.signum()) / SPEED_PER_V;
        let wanted_v = known_v + PROPORTIONAL * missing + self.integral_v;
        let voltage = wanted_v.clamp(-battery_v, battery_v);
        // No winding up while the battery gives no more.
        if voltage == wanted_v {
            self.integral_v += INTEGRAL * missing * turn_s;
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
    /// How fast the track runs, m/s.
    pub(super) const fn speed(&self) -> f64 {
        self.speed
    }

    /// Current through the motor, A, either way.
    pub(super) const fn current_a(&self) -> f64 {
        self.current_a.abs()
    }

    /// Lets a short time pass, seconds, under a voltage. A motor that is held does not move and draws what it can.
    pub(super) fn run(&mut self, voltage: f64, is_held: bool, time_s: f64) {
        let driven = SPEED_PER_V * voltage;
        self.current_a = (driven - self.speed) / SPEED_PER_V / WINDING_OHM;
        if is_held {
            self.speed = 0.0;
            return;
        }
        if self.speed == 0.0 && driven.abs() <= FRICTION {
            return;
        }
        let along = if self.speed == 0.0 {
            driven
        } else {
            self.speed
        };
        let slope = (driven - self.speed - FRICTION * along.signum()) / LAG_S;
        let next = self.speed + slope * time_s;
        // Friction ends a motion and begins none.
        let stops = self.speed * next < 0.0 && driven.abs() <= FRICTION;
        self.speed = if stops { 0.0 } else { next };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Speeds of a track each 10 ms after its set speed changed.
    fn follow(start: f64, set: f64, turns: usize) -> Vec<f64> {
        let (mut motor, mut control) = (Motor::default(), SpeedControl::default());
        let mut run = |set: f64| {
            let voltage = control.turn(set, motor.speed(), 0.01, 24.0);
            for _ in 0..10 {
                motor.run(voltage, false, 0.001);
            }
            motor.speed()
        };
        for _ in 0..300 {
            run(start);
        }
        (0..turns).map(|_| run(set)).collect()
    }

    #[test]
    fn a_set_speed_is_reached_soon_and_without_much_beyond() {
        for (start, set) in [(0.0, 0.5), (0.5, 1.2), (0.5, -0.5), (1.0, 0.0), (0.0, 0.05)] {
            let speeds = follow(start, set, 200);
            let step = set - start;
            assert!((speeds[14] - set).abs() < 0.3 * step.abs(), "{speeds:?}");
            assert!(
                (speeds[199] - set).abs() < 0.01,
                "{start} to {set}: {speeds:?}"
            );
            let beyond = speeds.iter().map(|speed| (speed - set) / step);
            assert!(beyond.fold(0.0, f64::max) < 0.25, "{speeds:?}");
        }
    }

    #[test]
    fn friction_stops_a_motor_without_voltage_and_starts_none() {
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
