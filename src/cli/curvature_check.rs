//! Checks whether a base can follow a path: its curvature against eq. 12 of the paper and the limit of the turn rate.

use inbye::global::Curvature;
use inbye::runtime::RobotConfig;
use serde_json::{Value, json};

/// A path's curvature compared with a base's limits.
pub struct CurvatureCheck {
    max_per_m: f64,
    sharp_turns: usize,
    /// Highest speed, m/s.
    max_speed: f64,
    /// Highest curvature at that speed, 1/m; infinite for a base that does not drive forward.
    limit_per_m: f64,
    within_limit_share: f64,
    slowest: f64,
}

impl CurvatureCheck {
    /// Compares a path's curvature with a robot's limits.
    pub fn new(curvature: &Curvature, robot: &RobotConfig) -> Self {
        let (drive, limits) = (robot.drive(), &robot.limits);
        let (max_speed, turn_rate) = (limits.max_vel_x, limits.max_vel_theta);
        let top_track = drive.top_track_speed(limits);
        let limit_per_m = if max_speed > 0.0 {
            drive.max_curvature(max_speed, top_track, turn_rate)
        } else {
            f64::INFINITY
        };
        let max_per_m = curvature.max_per_m();
        let slowest = if curvature.sharp_turns > 0 {
            0.0
        } else if max_per_m > limit_per_m {
            drive.max_speed(max_per_m, top_track, turn_rate).min(max_speed)
        } else {
            max_speed
        };
        Self {
            max_per_m,
            sharp_turns: curvature.sharp_turns,
            max_speed,
            limit_per_m,
            within_limit_share: curvature.fraction_within(limit_per_m),
            slowest,
        }
    }

    /// The JSON object.
    pub fn object(&self) -> Value {
        json!({
            "max_per_m": self.max_per_m,
            "min_radius_m": self.min_radius_m(),
            "sharp_turns": self.sharp_turns,
            "limit_per_m": self.limit_per_m.is_finite().then_some(self.limit_per_m),
            "within_limit_share": self.within_limit_share,
            "slowest_speed_mps": self.slowest,
        })
    }

    /// The line of text.
    pub fn line(&self) -> String {
        let bends = match self.min_radius_m() {
            Some(radius_m) => {
                format!("{:8.3} 1/m at the tightest, radius {radius_m:.2} m", self.max_per_m)
            }
            None => "   0.000 1/m".to_owned(),
        };
        let turns = match self.sharp_turns {
            0 => "no sharp turn".to_owned(),
            1 => "1 sharp turn, in place".to_owned(),
            sharp => format!("{sharp} sharp turns, in place"),
        };
        let followed = if self.within_limit_share == 1.0 {
            format!("all followed at {:.2} m/s", self.max_speed)
        } else {
            let share = format!(
                "{:.1} % followed at {:.2} m/s",
                self.within_limit_share * 100.0,
                self.max_speed
            );
            if self.slowest > 0.0 {
                format!("{share}, all at {:.2} m/s", self.slowest)
            } else {
                share
            }
        };
        format!("curvature {bends}; {turns}; {followed}")
    }

    /// Radius of the tightest bend, metres; none for a straight path.
    fn min_radius_m(&self) -> Option<f64> {
        (self.max_per_m > 0.0).then(|| self.max_per_m.recip())
    }
}
