//! The figures of a row: how each column follows from a run.

use super::RunRow;
use super::metrics::weighted_success;
use super::outcome::gap_to_moving_m;
use super::paper_drives::Deviation;
use super::row::STANDS_BELOW;
use super::world::Reference;
use crate::bench::{Latencies, LatencySummary};
use crate::robot::MotionEstimate;
use crate::runtime::{Config, MissionResult, PlantKind, TraceRow};
use crate::sim::{Simulation, draw_plant};

impl RunRow {
    /// Fills in the figures of a run.
    pub(super) fn fill(
        &mut self,
        simulation: &Simulation,
        config: &Config,
        result: &MissionResult,
        reference: Reference,
    ) {
        let (trace, mission) = (&result.trace, &simulation.mission);
        let last = trace.rows.last();
        let pose = last.map_or(mission.start, |row| row.pose);
        let [dx_m, dy_m] = Deviation::offset(&pose, &mission.goal.position, &mission.start);
        let (waited_share, longest_wait_s) = waits(&trace.rows, config.local.control_period_s);
        let (x_m, y_m) = result.final_error_m;
        self.fault = result.fault.as_ref().map(|it| fault_name(&it.to_string()));
        self.time_s = result.time_s;
        self.travelled_m = result.travelled_m;
        self.min_clearance_m = Some(result.min_clearance_m).filter(|gap_m| gap_m.is_finite());
        self.omega_sign_changes_per_m = result.omega_sign_changes_per_m();
        self.fill_metrics(config, result, reference);
        self.final_error_m = Some(libm::hypot(x_m, y_m));
        self.final_yaw_error_rad = result.final_yaw_error;
        self.plans = result.plans.len();
        self.ticks = trace.rows.len();
        self.final_dx_m = Some(dx_m);
        self.final_dy_m = Some(dy_m);
        self.final_speed_m_s = Some(last.map_or(0.0, |row| row.twist.linear.abs()));
        let footprint = &config.robot.footprint;
        let gaps = trace
            .rows
            .iter()
            .filter_map(|row| gap_to_moving_m(row, &trace.moving_radii, footprint));
        self.nearest_moving_m = gaps.reduce(f64::min);
        let has_moving = !trace.moving_radii.is_empty();
        self.people_met = has_moving.then_some(result.encounters.people_met);
        self.people_time_lost_s = result.encounters.time_lost_s;
        self.waited_share = Some(waited_share);
        self.longest_wait_s = Some(longest_wait_s);
        self.trace_digest = Some(trace.digest());
        self.protected_ticks = Some(result.protective_actions.values().sum());
        self.fill_identified(&result.motion);
    }

    /// Fills in the figures of the motion. The outcome must be known.
    fn fill_metrics(&mut self, config: &Config, result: &MissionResult, reference: Reference) {
        let (robot, period_s) = (&config.robot, config.local.control_period_s);
        self.fill_motion(&result.trace, &robot.footprint, &robot.drive(), period_s);
        let (reached, Reference { path_m, time_s }) = (self.reached(), reference);
        self.ideal_time_s = Some(time_s);
        self.time_weighted_success = Some(weighted_success(reached, time_s, result.time_s));
        self.path_weighted_success = Some(weighted_success(reached, path_m, result.travelled_m));
    }

    /// The row of a run that did not start.
    pub(super) fn without_success(self) -> Self {
        let none = Some(0.0);
        Self { time_weighted_success: none, path_weighted_success: none, ..self }
    }

    /// Fills in the response of the base as the drive identified it.
    fn fill_identified(&mut self, motion: &MotionEstimate) {
        let Some(delay_s) = motion.delay_s else {
            return;
        };
        self.identified_delay_s = Some(delay_s.value);
        self.identified_delay_low_s = Some(delay_s.low);
        self.identified_delay_high_s = Some(delay_s.high);
        self.identified_acceleration_m_s2 = Some(motion.acceleration_m_s2);
        self.identified_braking_m_s2 = Some(motion.braking_m_s2);
        self.turn_ratio = motion.turn_ratio.map(|ratio| ratio.value);
        self.turn_ratio_low = motion.turn_ratio.map(|ratio| ratio.low);
        self.turn_ratio_high = motion.turn_ratio.map(|ratio| ratio.high);
    }

    /// Fills in the programs of the settings, and what the simulated robot of the seed truly is.
    pub(super) fn fill_plant(&mut self, config: &Config, seed: u64) {
        self.controller = self.controller.take().or_else(|| config.controller.name());
        self.global_planner = config.global_planner.name();
        self.plant = Some(config.simulation.plant);
        self.pose_source = Some(config.pose_source);
        if config.simulation.plant == PlantKind::Agreeing {
            return;
        }
        let drawn = draw_plant(config, seed);
        let dynamics = &drawn.dynamics;
        self.command_delay_s = Some(dynamics.command_delay_s);
        self.sensing_delay_s = Some(drawn.sensing_delay_s);
        self.motor_lag_s = Some(dynamics.motor_lag_s);
        self.acceleration_ratio = Some(dynamics.acceleration_ratio);
        self.braking_ratio = Some(dynamics.braking_ratio);
        self.deadband_m_s = Some(dynamics.deadband_m_s);
        self.width_ratio = Some(dynamics.slip.width_ratio);
        self.slope_rad = Some(dynamics.slope_rad);
        self.uphill_rad = Some(dynamics.uphill_rad);
        self.range_sigma_m = Some(drawn.lidar.range_sigma_m);
        self.ghosts = Some(drawn.lidar.ghosts);
        self.mixed_pixels = Some(drawn.lidar.mixed_pixels);
        self.map_error_m = Some(drawn.map_error_m);
        self.leg_diameter_m = Some(drawn.pedestrians.leg_diameter_m);
        if drawn.lidar.blind_time_s > 0.0 {
            self.blind_time_s = Some(drawn.lidar.blind_time_s);
            self.blind_start_s = Some(drawn.lidar.blind_start_s);
            self.blind_direction_rad = Some(drawn.lidar.blind_direction_rad);
            self.blind_width_rad = Some(drawn.lidar.blind_width_rad);
        }
    }

    /// Fills in the times of the ticks.
    pub(super) fn fill_times(&mut self, seconds: &[f64]) {
        let mut times = Latencies::default();
        for &seconds in seconds {
            // A clock that ran backwards gives no time.
            let _ = times.record(seconds);
        }
        let times = times.summary();
        let time = |figure: fn(&LatencySummary) -> f64| times.as_ref().map(figure);
        self.tick_p50_ms = time(|times| times.p50_ms);
        self.tick_p95_ms = time(|times| times.p95_ms);
        self.tick_p99_ms = time(|times| times.p99_ms);
        self.tick_max_ms = time(|times| times.max_ms);
    }
}

/// The share of ticks in which the robot stood, and the longest sequence of them in seconds.
fn waits(rows: &[TraceRow], period_s: f64) -> (f64, f64) {
    let stands = |row: &TraceRow| row.twist.is_below(STANDS_BELOW);
    let stood = rows.iter().filter(|row| stands(row)).count();
    let longest = rows
        .chunk_by(|a, b| stands(a) == stands(b))
        .filter(|stretch| stretch.first().is_some_and(stands))
        .map(<[TraceRow]>::len)
        .max();
    (stood as f64 / rows.len().max(1) as f64, longest.unwrap_or(0) as f64 * period_s)
}

/// Nav2's name at the beginning of a fault's sentence; `FAULT` where it has none.
pub(super) fn fault_name(sentence: &str) -> String {
    let name = sentence.split(':').next().unwrap_or_default();
    let is_name = !name.is_empty() && name.chars().all(|c| c.is_ascii_uppercase() || c == '_');
    if is_name { name } else { "FAULT" }.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{Interval, Limits, MotionIdentifier};

    #[test]
    fn row_has_the_identified_response_only_where_the_latency_is_known() {
        let mut motion = *MotionIdentifier::new(&Limits::default(), 0.3).estimate();
        motion.turn_ratio = Some(Interval { value: 0.8, low: 0.7, high: 0.9 });
        let mut row = RunRow::default();
        row.fill_identified(&motion);
        assert_eq!(row, RunRow::default());
        motion.delay_s = Some(Interval { value: 0.1, low: 0.05, high: 0.15 });
        motion.braking_m_s2 = 0.75;
        row.fill_identified(&motion);
        let delays =
            [row.identified_delay_s, row.identified_delay_low_s, row.identified_delay_high_s];
        assert_eq!(delays, [Some(0.1), Some(0.05), Some(0.15)]);
        assert_eq!(row.identified_braking_m_s2, Some(0.75));
        let ratios = [row.turn_ratio, row.turn_ratio_low, row.turn_ratio_high];
        assert_eq!(ratios, [Some(0.8), Some(0.7), Some(0.9)]);
    }
}
