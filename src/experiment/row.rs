//! One row for each run, for all kinds of worlds.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{ContactCause, LocalizationCase, RunOutcome, TrafficKind, WorldKind};
use crate::bench::Columns;
use crate::bench::columns::{column_values, columns};
use crate::runtime::{PlantKind, PoseSource};

/// Below this speed the robot stands: m/s and rad/s.
pub(super) const STANDS_BELOW: f64 = 0.01;
/// Number of the columns that name a cell, the first of a row.
const NAMES: usize = 9;

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
        /// Ideal time, seconds, the same for every planner: BARN's path at 2 m/s, elsewhere the first global path of the world's
        /// own robot, before any change of settings, at its highest speed. None where the run did not start.
        pub ideal_time_s: Option<f64> => 2,
        /// Success weighted by completion time (Yokoyama, Ha and Batra 2021): ideal over actual time, at most 1; 0 without success.
        pub time_weighted_success: Option<f64> => 3,
        /// Success weighted by path length (Anderson et al. 2018): that of the ideal time over the distance driven, at most 1.
        pub path_weighted_success: Option<f64> => 3,
        /// Share of ticks with a gap below 0.3 m (MRPB, Wen et al. 2021; the distance is our choice).
        pub near_share: Option<f64> => 3,
        /// Mean change of the speed, m/s^2 (MRPB's velocity change over the time of a tick).
        pub speed_change_m_s2: Option<f64> => 3,
        /// Root mean square of the jerk along the motion, m/s^3.
        pub jerk_rms_m_s3: Option<f64> => 3,
        /// Control effort: root mean square of the accelerations of both belts that the commands ask for, m/s^2.
        pub control_effort_m_s2: Option<f64> => 3,
        /// Kinetic energy that the belts put into the motion, J/kg, each with half of the mass.
        pub drive_work_j_per_kg: Option<f64> => 3,
        /// Root mean square distance from the global path of the time, metres.
        pub off_path_rms_m: Option<f64> => 3,
        /// Angle turned per metre driven, rad/m.
        pub angle_per_m: Option<f64> => 3,
        /// Mean curvature of the path driven, 1/m: Menger's, of points at least 0.2 m apart.
        pub curvature_per_m: Option<f64> => 3,
        /// Share of ticks with a moving obstacle within 0.45 m (intimate space, Hall 1966); none without moving obstacles.
        pub intimate_share: Option<f64> => 3,
        /// The same within 1.2 m (personal space).
        pub personal_share: Option<f64> => 3,
        /// The same within 3.6 m (social space).
        pub social_share: Option<f64> => 3,
        /// Least time to a contact with a moving obstacle if both kept their velocities, seconds; none above 10 s.
        pub least_time_to_contact_s: Option<f64> => 2,
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
}
