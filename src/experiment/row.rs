//! One row for each run, for all kinds of worlds.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::outcome::gap_to_moving_m;
use super::paper_drives::Deviation;
use super::{LocalizationCase, TrafficKind, WorldKind};
use crate::bench::columns::{column_values, columns};
use crate::bench::{Columns, Latencies, LatencySummary};
use crate::external::ProgramSettings;
use crate::robot::MotionEstimate;
use crate::runtime::{Config, MissionResult, PlantKind, PoseSource, TraceRow};
use crate::sim::{Simulation, draw_plant};

/// Below this speed the robot stands: m/s and rad/s.
const STANDS_BELOW: f64 = 0.01;
/// Number of the columns that name a cell, the first of a row.
const NAMES: usize = 9;

/// How a run ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum RunOutcome {
    /// The robot reached its goal.
    Reached,
    /// The robot and something touched.
    Contact,
    /// The time was up.
    Timeout,
    /// The navigator gave up.
    Failed,
    /// The run did not start: a start in a wall, a map without room.
    #[default]
    Error,
}

impl RunOutcome {
    /// As people read it.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Reached => "reached its goal",
            Self::Contact => "touched something",
            Self::Timeout => "ran out of time",
            Self::Failed => "gave up",
            Self::Error => "did not start",
        }
    }
}

/// The body whose motion caused a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ContactCause {
    /// The robot closed the gap by its own motion, or touched what does not move.
    Robot,
    /// An obstacle closed the gap, and in hindsight the robot had a command that keeps clear.
    Avoidable,
    /// An obstacle closed the gap, and no command tried keeps clear.
    Other,
}

column_values! {
    Text: RunOutcome, ContactCause, WorldKind, TrafficKind, LocalizationCase, PlantKind, PoseSource;
}

columns! {
    /// One run: its cell, how it ended, and its figures. Only the fields from `ran_on` on depend on the machine. The row of a
    /// cell that was not run yet has the fields up to `latency`, `case` and `key`.
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
    #[serde(default)]
    pub struct RunRow {
        /// Kind of the world.
        pub kind: WorldKind,
        /// Name or number of the world.
        pub world: String,
        /// Name of the settings; none where the plan has only one.
        pub config: Option<String>,
        /// Name of the weights; none where the plan has none.
        pub weights: Option<String>,
        /// Forward speeds of the dynamic window.
        pub vx_samples: u32,
        /// Turn rates of the dynamic window.
        pub vtheta_samples: u32,
        /// The engine, as the plan names it.
        pub engine: String,
        /// Seed of noise and moving obstacles.
        pub seed: u64,
        /// Whether the cell measures latency and so has the machine to itself.
        pub latency: bool,
        /// How the run ended.
        pub outcome: RunOutcome,
        /// Whose motion caused the contact; none without contact.
        pub contact_cause: Option<ContactCause>,
        /// Nav2's name of the navigator's fault; none where it did not give up.
        pub fault: Option<String>,
        /// Why the goal was not reached, a sentence; none where it was.
        pub reason: Option<String>,
        /// Simulated time, seconds.
        pub time_s: f64 => 2,
        /// Length of the first global path, metres, of a random mission or of a drive of the paper; none elsewhere.
        pub path_m: Option<f64> => 2,
        /// Distance driven, metres.
        pub travelled_m: f64 => 2,
        /// Smallest true gap during the run, metres; none where no tick was driven.
        pub min_clearance_m: Option<f64> => 3,
        /// Sign changes of the turn rate per metre driven, 1/m; turn rates of at most 0.05 rad/s count as none. None where the
        /// robot did not drive.
        pub omega_sign_changes_per_m: Option<f64> => 3,
        /// True distance from the goal at the end, metres; none where no tick was driven.
        pub final_error_m: Option<f64> => 4,
        /// True yaw minus the goal's at the end, radians, -pi to pi; none without a goal yaw.
        pub final_yaw_error_rad: Option<f64> => 4,
        /// Time that BARN's own path takes at 2 m/s, seconds; none elsewhere.
        pub optimal_time_s: Option<f64> => 2,
        /// BARN's score, 0 to 0.5; none elsewhere.
        pub score: Option<f64> => 4,
        /// Kind of the moving obstacles of a random mission or of a drive of the paper; none elsewhere.
        pub traffic: Option<TrafficKind>,
        /// Number of moving obstacles.
        pub obstacles: usize,
        /// Number of obstacles on the path that the map does not show.
        pub unmapped: usize,
        /// The program that decided in place of inbye's controller; none for inbye.
        pub controller: Option<String>,
        /// The program that planned in place of inbye's global planner; none for inbye.
        pub global_planner: Option<String>,
        /// Whether the simulated robot was as the settings say.
        pub plant: Option<PlantKind>,
        /// Source of the pose.
        pub pose_source: Option<PoseSource>,
        /// What the robot truly was, drawn by the seed; this and the next columns are none for an agreeing plant. Time until
        /// the base acts on a command, seconds.
        pub command_delay_s: Option<f64>,
        /// Age of scan, odometry and fixes, seconds.
        pub sensing_delay_s: Option<f64>,
        /// Time constant of the motors, seconds.
        pub motor_lag_s: Option<f64>,
        /// Acceleration over that of the robot's limits.
        pub acceleration_ratio: Option<f64>,
        /// Deceleration over that of the robot's limits.
        pub braking_ratio: Option<f64>,
        /// Belt speed below which a motor stood still, m/s.
        pub deadband_m_s: Option<f64>,
        /// Effective over geometric track width.
        pub width_ratio: Option<f64>,
        /// Slope of the ground, radians.
        pub slope_rad: Option<f64>,
        /// Direction of the steepest ascent, radians.
        pub uphill_rad: Option<f64>,
        /// Standard deviation of a range, metres; all noise grows by the same factor.
        pub range_sigma_m: Option<f64>,
        /// Fraction of the beams that returned from dust.
        pub ghosts: Option<f64>,
        /// Fraction of the beams at edges with a range in between.
        pub mixed_pixels: Option<f64>,
        /// Largest distance of a wall from where the map shows it, metres.
        pub map_error_m: Option<f64>,
        /// Time for which a sector of the lidar was blind, seconds; this and the next columns are none for a lidar that
        /// always saw.
        pub blind_time_s: Option<f64>,
        /// Start of that time, seconds.
        pub blind_start_s: Option<f64>,
        /// Middle of the blind sector in the robot's frame, radians.
        pub blind_direction_rad: Option<f64>,
        /// Width of the blind sector, radians.
        pub blind_width_rad: Option<f64>,
        /// Diameter of the pedestrians' legs, metres.
        pub leg_diameter_m: Option<f64>,
        /// Number of global plans.
        pub plans: usize,
        /// Number of ticks.
        pub ticks: usize,
        /// Distance of the true final position from the goal along the x axis of the start pose, metres.
        pub final_dx_m: Option<f64> => 4,
        /// The same along its y axis.
        pub final_dy_m: Option<f64> => 4,
        /// The robot's true forward speed at the end, m/s, without its sign.
        pub final_speed_m_s: Option<f64> => 2,
        /// Smallest gap to a moving obstacle, metres; none without any.
        pub nearest_moving_m: Option<f64> => 3,
        /// Number of moving obstacles that the robot met: within 4 m and in sight; none without any.
        pub people_met: Option<usize>,
        /// Time with them, less the time of the same distance at the mean speed without them, seconds; none where the robot met
        /// none, or was alone for less than 5 s.
        pub people_time_lost_s: Option<f64> => 1,
        /// Share of the ticks in which the robot stood.
        pub waited_share: Option<f64> => 3,
        /// The longest time in which it stood, seconds.
        pub longest_wait_s: Option<f64> => 1,
        /// Number of ticks in which the protective layer changed the command.
        pub protected_ticks: Option<u64>,
        /// Latency that the drive identified, from a command to its measured effect, seconds. This and the next columns are
        /// none where the drive did not identify it.
        pub identified_delay_s: Option<f64> => 3,
        /// Lower end of its interval, seconds.
        pub identified_delay_low_s: Option<f64> => 3,
        /// Upper end of its interval, seconds.
        pub identified_delay_high_s: Option<f64> => 3,
        /// Identified acceleration, m/s^2: the limit, unless the base accelerates less.
        pub identified_acceleration_m_s2: Option<f64> => 2,
        /// Identified deceleration, m/s^2, positive: the limit, unless the base brakes less.
        pub identified_braking_m_s2: Option<f64> => 2,
        /// Identified ratio of the measured to the commanded turn rate.
        pub turn_ratio: Option<f64> => 3,
        /// Lower end of its interval.
        pub turn_ratio_low: Option<f64> => 3,
        /// Upper end of its interval.
        pub turn_ratio_high: Option<f64> => 3,
        /// The case of the localization experiment; none elsewhere.
        pub case: Option<LocalizationCase>,
        /// Share of each track's speed that is lost to slip. This and the next columns are none unless the pose comes from scans.
        pub slip: Option<f64>,
        /// Largest error of the estimated position over all ticks at which the robot was not lost, metres; the first second
        /// after an injected fault does not count.
        pub pose_error_max_m: Option<f64> => 4,
        /// The same of the yaw, radians.
        pub pose_error_max_rad: Option<f64> => 4,
        /// Largest position error over the ticks at which it was neither lost nor uncertain, metres.
        pub tracking_error_max_m: Option<f64> => 4,
        /// Root mean square of the position errors, metres.
        pub pose_error_rms_m: Option<f64> => 4,
        /// Largest position error of odometry alone over the same ticks, metres.
        pub odometry_error_max_m: Option<f64> => 2,
        /// The same of the yaw, radians.
        pub odometry_error_max_rad: Option<f64> => 4,
        /// Largest standard deviation that the robot reported for its position, metres.
        pub pose_sigma_max_m: Option<f64> => 3,
        /// Share of revolutions in which scans did not observe at least one direction.
        pub unobserved_share: Option<f64> => 3,
        /// Smallest share of beams that agree with the map.
        pub agreement_min_share: Option<f64> => 3,
        /// Number of ticks at which the robot was uncertain of its pose.
        pub uncertain_ticks: Option<u64>,
        /// Number of ticks at which it was lost.
        pub lost_ticks: Option<u64>,
        /// Why it was first lost.
        pub lost_reason: Option<String>,
        /// Time from the injected fault, or from the start without one, until the robot was lost, seconds.
        pub lost_after_s: Option<f64> => 1,
        /// Distance driven from the fault until it stood or was localized again, metres.
        pub driven_on_m: Option<f64> => 1,
        /// Time from being lost until it was localized again, seconds.
        pub found_after_s: Option<f64> => 1,
        /// Digest of the trace; none where no tick was driven.
        pub trace_digest: Option<String>,
        /// The cell's key; empty for a run outside a plan.
        pub key: String,
        /// The engine with its threads and instructions, or its adapter.
        pub ran_on: Option<String>,
        /// The machine; none where latency is not measured.
        pub machine: Option<String>,
        /// Threads of the CPU engine; none where latency is not measured.
        pub threads: Option<usize>,
        /// Wall-clock time of a tick, from the scan to the command, the median, milliseconds.
        pub tick_p50_ms: Option<f64> => 3,
        /// The same, the 95th percentile.
        pub tick_p95_ms: Option<f64> => 3,
        /// The same, the 99th percentile.
        pub tick_p99_ms: Option<f64> => 3,
        /// The same, the slowest.
        pub tick_max_ms: Option<f64> => 3,
    }
}

impl RunRow {
    /// The row under the names and the key of a cell.
    #[must_use]
    pub fn named(self, cell: &Self) -> Self {
        let cell = cell.clone();
        Self {
            kind: cell.kind,
            world: cell.world,
            config: cell.config,
            weights: cell.weights,
            vx_samples: cell.vx_samples,
            vtheta_samples: cell.vtheta_samples,
            engine: cell.engine,
            seed: cell.seed,
            latency: cell.latency,
            key: cell.key,
            ..self
        }
    }

    /// The columns that name the cell, and its key, as a JSON object.
    #[must_use]
    pub fn names(&self) -> Value {
        let mut names = serde_json::to_value(self).unwrap_or_default();
        if let Some(fields) = names.as_object_mut() {
            let listed = &Self::COLUMNS[..NAMES];
            fields.retain(|name, _| name == "key" || listed.iter().any(|it| it.name == name));
        }
        names
    }

    /// The row without the columns that depend on the wall clock or the machine: the same bits on every machine.
    #[must_use]
    pub fn without_clock(self) -> Self {
        Self {
            ran_on: None,
            machine: None,
            threads: None,
            tick_p50_ms: None,
            tick_p95_ms: None,
            tick_p99_ms: None,
            tick_max_ms: None,
            ..self
        }
    }

    /// Whether the run reached its goal.
    #[must_use]
    pub fn reached(&self) -> bool {
        self.outcome == RunOutcome::Reached
    }

    /// Whether the run ended in contact.
    #[must_use]
    pub fn collided(&self) -> bool {
        self.outcome == RunOutcome::Contact
    }

    /// Whether the robot moved at the end.
    #[must_use]
    pub fn was_moving(&self) -> bool {
        self.final_speed_m_s.is_some_and(|speed_m_s| speed_m_s >= STANDS_BELOW)
    }

    /// Fills in the figures of a run.
    pub(super) fn fill(
        &mut self,
        simulation: &Simulation,
        config: &Config,
        result: &MissionResult,
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
        let program =
            |program: &ProgramSettings| program.is_set().then(|| program.command.join(" "));
        self.controller = program(&config.controller);
        self.global_planner = program(&config.global_planner);
        self.plant = Some(config.simulation.plant);
        self.pose_source = Some(config.pose_source);
        if config.simulation.plant == PlantKind::Agreeing {
            return;
        }
        let drawn = draw_plant(&config.simulation, seed);
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
    let stands = |row: &TraceRow| {
        row.twist.linear.abs() < STANDS_BELOW && row.twist.angular.abs() < STANDS_BELOW
    };
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
