//! Footprint and moving obstacles with their margins, for the local planner.

use super::NavigatorSettings;
use super::predicted_state::PredictedState;
use crate::geometry::Pose;
use crate::local::{ClearanceField, LocalSettings, clearance_error_m};
use crate::map::MovingDisc;
use crate::robot::{Footprint, Limits};

/// A robot within a margin keeps this much less than its present distance, metres: enough to leave the margin slowly. It may
/// drive at the speed from which it stops within this distance.
const SLACK_M: f64 = 0.005;
/// The robot overshoots a margin to a moving obstacle by less than this, metres. An obstacle deeper within the margin came
/// there by itself.
const OVERSHOOT_M: f64 = 0.03;
/// Least radius of an obstacle, metres.
const MIN_RADIUS_M: f64 = 0.002;
/// The robot always keeps this distance to static obstacles, metres, or the safety margin if that is less.
const MIN_STATIC_MARGIN_M: f64 = 0.02;
/// Without passive safety, the robot always keeps this distance to moving obstacles, metres.
const MIN_MOVING_MARGIN_M: f64 = 0.05;

/// Footprint and moving obstacles, inflated: bodies that just touch in the planner are a margin apart in reality.
///
/// The field has lower bounds of the true distances, and the padding contains all that the engines may overlook
/// ([`clearance_error_m`]). So a trajectory that is clear for the inflated footprint keeps `static_margin_m` between the true
/// body and the square of every occupied cell. This holds along the whole true arc, at every resolution of the map.
pub(super) struct InflatedBodies {
    pub footprint: Footprint,
    pub moving: Vec<MovingDisc>,
    /// Whether an obstacle is within its margin: the robot then drives slowly.
    pub within_a_margin: bool,
    /// Distance that the robot keeps to static obstacles, metres.
    static_margin_m: f64,
    /// The least value of that margin, metres.
    min_static_margin_m: f64,
    /// What the engines may overlook, metres.
    error_m: f64,
    /// The whole margin to static obstacles, metres.
    wanted_margin_m: f64,
}

impl InflatedBodies {
    /// Inflates by the whole margins, or by a part of a margin that an obstacle is within. Otherwise no velocity would be
    /// admissible next to a person who came close and stopped, not even one that leads away.
    pub fn new(
        footprint: &Footprint,
        limits: &Limits,
        settings: &NavigatorSettings,
        local: &LocalSettings,
        field: &ClearanceField,
        now: &PredictedState,
    ) -> Self {
        let pose = &now.pose;
        // The planner checks the discs, so their distances count here, not those of the body.
        let footprint = footprint.without_body();
        let error_m = clearance_error_m(&footprint, limits, local, field.unit_m());
        let wanted_m = settings.safety_margin_m;
        let min_static_margin_m = MIN_STATIC_MARGIN_M.min(wanted_m);
        let static_m = field.clearance_m(&footprint, pose).unwrap_or(0.0) - error_m;
        let mut within_a_margin = static_m < wanted_m;
        let static_margin_m = reduced_margin_m(wanted_m, static_m, min_static_margin_m);
        let padding_m = static_margin_m + error_m;
        // Passive safety lets the robot come no nearer to a person next to it, but it must be able to drive away.
        let is_passive = settings.features.passive_safety;
        let min_moving_margin_m = if is_passive { f64::NEG_INFINITY } else { MIN_MOVING_MARGIN_M };
        let inflate = |disc: &MovingDisc| {
            let gap_m = footprint.gap_to_moving_m(pose, disc);
            let came_close = gap_m < settings.moving_margin_m - OVERSHOOT_M;
            within_a_margin |= came_close;
            let margin_m =
                if came_close { settings.passing_margin_m } else { settings.moving_margin_m };
            let kept_m = reduced_margin_m(margin_m, gap_m, min_moving_margin_m);
            // The footprint's own padding counts towards the gap.
            MovingDisc { radius: (disc.radius + (kept_m - padding_m)).max(MIN_RADIUS_M), ..*disc }
        };
        Self {
            moving: now.moving.iter().map(inflate).collect(),
            footprint: footprint.padded(padding_m),
            within_a_margin,
            static_margin_m,
            min_static_margin_m,
            error_m,
            wanted_margin_m: wanted_m,
        }
    }

    /// What is added to each radius of the footprint, metres.
    pub fn padding_m(&self) -> f64 {
        self.static_margin_m + self.error_m
    }

    /// The clearance of a cover at which velocities are admissible: with the least margin, or with the whole one, metres.
    pub fn needed_room_m(&self, with_whole_margin: bool) -> f64 {
        let margin_m =
            if with_whole_margin { self.wanted_margin_m } else { self.min_static_margin_m };
        self.error_m + margin_m + SLACK_M
    }

    /// Whether a robot at a pose certainly keeps the least margin to static obstacles.
    pub fn is_clear_of_static(&self, field: &ClearanceField, pose: &Pose) -> bool {
        let inflated_m = field.clearance_m(&self.footprint, pose);
        inflated_m
            .is_some_and(|inflated_m| inflated_m + self.static_margin_m >= self.min_static_margin_m)
    }

    /// Whether a robot at a pose, this many seconds from now, touches no moving obstacle.
    pub fn is_clear_of_moving(&self, pose: &Pose, time_s: f64) -> bool {
        let gap_m = |disc: &MovingDisc| self.footprint.gap_to_moving_m(pose, &disc.after(time_s));
        self.moving.iter().all(|disc| gap_m(disc) > 0.0)
    }
}

/// A margin, or what is left of it at a distance, but never below the least value: else the robot could come nearer by the
/// slack at each tick until it touches.
fn reduced_margin_m(margin_m: f64, distance_m: f64, least_m: f64) -> f64 {
    margin_m.min((distance_m - SLACK_M).max(least_m))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::super::test_state::standing_at;
    use super::*;
    use crate::geometry::{Point, Twist};
    use crate::local::{CpuEngine, DecisionInput, Detail, Engine, QuantizedProblem, SampleStatus};
    use crate::map::{Cell, GridFrame, ObstacleGrid};
    use crate::navigator::RobotModel;
    use crate::robot::Polygon;

    /// A robot in front of random obstacles.
    struct Case {
        obstacles: ObstacleGrid,
        robot: RobotModel,
        local: LocalSettings,
        now: PredictedState,
    }

    impl Case {
        fn random(rng: &mut Pcg64Mcg) -> Self {
            let resolution_m = rng.random_range(0.02..0.25);
            let side = (8.0 / resolution_m) as i32;
            let angle = |rng: &mut Pcg64Mcg| rng.random_range(-3.1..3.1);
            let frame = GridFrame {
                width: side,
                height: side,
                resolution_m,
                origin: Pose::new(rng.random_range(-9.0..9.0), 3.0, angle(rng)),
            };
            let mut obstacles = ObstacleGrid::filled(frame, false);
            for _ in 0..rng.random_range(1..25) {
                let (left, bottom) = (rng.random_range(0..side), rng.random_range(0..side));
                let (wide, high) = (rng.random_range(1..6), rng.random_range(1..6));
                for column in left..left + wide {
                    (bottom..bottom + high)
                        .for_each(|row| obstacles.set(Cell::new(column, row), true));
                }
            }
            let (length_m, width_m) = (rng.random_range(0.2..1.0), rng.random_range(0.2..0.8));
            let body = Polygon::rectangle(length_m, width_m).expect("a rectangle");
            let limits = Limits::default()
                .min_vel_x(-0.3)
                .decel_lim_x(-rng.random_range(0.5..2.0))
                .decel_lim_theta(-rng.random_range(1.0..4.0));
            let middle = f64::from(side) / 2.0;
            let near = |rng: &mut Pcg64Mcg| middle + rng.random_range(-1.0..1.0) / resolution_m;
            let place = frame.from_cell_units(&Point::new(near(rng), near(rng)));
            let twist = Twist::new(rng.random_range(-0.2..1.0), rng.random_range(-1.0..1.0));
            Self {
                obstacles,
                robot: RobotModel { footprint: Footprint::covering(body), limits },
                local: LocalSettings::default().vx_samples(5).vtheta_samples(5).sim_time_s(3.0),
                now: PredictedState {
                    twist,
                    ..standing_at(Pose::new(place.x, place.y, angle(rng)))
                },
            }
        }

        fn inflated(&self, settings: &NavigatorSettings, field: &ClearanceField) -> InflatedBodies {
            let RobotModel { footprint, limits } = &self.robot;
            InflatedBodies::new(footprint, limits, settings, &self.local, field, &self.now)
        }

        /// The lower left corners of all occupied squares, in cells.
        fn squares(&self) -> Vec<Point> {
            let frame = self.obstacles.frame();
            let blocked = (0..frame.len()).filter(|&index| self.obstacles.cells()[index]);
            blocked.map(|index| frame.cell_at(index).corner()).collect()
        }

        /// The true gap between the body at a pose and the nearest of these squares, metres; at most 0.3 m.
        fn gap_m(&self, squares: &[Point], pose: &Pose) -> f64 {
            let frame = self.obstacles.frame();
            let body = self.robot.footprint.body().expect("a polygon");
            let body = body.mapped(|corner| frame.to_cell_units(&pose.transform(corner)));
            let middle = frame.to_cell_units(&pose.position());
            let mut least = 0.3 / frame.resolution_m;
            let reach = self.robot.footprint.body_radius_m() / frame.resolution_m + least + 2.0;
            for square in squares {
                let (dx, dy) = (square.x - middle.x, square.y - middle.y);
                if dx.abs() < reach && dy.abs() < reach {
                    least = least.min(body.distance_to_unit_square(square));
                }
            }
            least * frame.resolution_m
        }

        /// The number of admissible samples, and the least true gap along their arcs minus a margin, metres. Until the first
        /// checked pose the gap counts from that at the start, if that is less than the margin.
        fn evaluate(
            &self,
            field: ClearanceField,
            footprint: &Footprint,
            margin_m: f64,
        ) -> (u32, f64) {
            let input = DecisionInput {
                field: &field.into(),
                pose: self.now.pose,
                twist: self.now.twist,
                last_command: self.now.twist,
                obstacles: &[],
                target: self.now.pose.transform(&Point::new(2.0, 0.0)),
                key_node: self.now.pose.transform(&Point::new(2.0, 0.0)),
                limits: self.robot.limits,
                footprint,
                weights: self.local.weights,
            };
            let problem = input.problem(&self.local);
            let quantized = QuantizedProblem::new(&problem).expect("within the ranges");
            let mut engine = CpuEngine::single_threaded();
            let found = engine.evaluate(&quantized, Detail::Samples).expect("an answer");
            let squares = self.squares();
            let first_m = margin_m.min(self.gap_m(&squares, &self.now.pose) - 0.01);
            let (mut count, mut least_m) = (0, f64::INFINITY);
            for (index, sample) in (0..).zip(found.samples.as_deref().unwrap_or_default()) {
                if sample.status != SampleStatus::Ok {
                    continue;
                }
                count += 1;
                let twist = problem.window.twist(index);
                for tick in 0..=(self.local.sim_time_s / 0.02) as u32 {
                    let pose = self.now.pose.after(&twist, f64::from(tick) * 0.02);
                    let wanted_m = if tick < 5 { first_m } else { margin_m };
                    least_m = least_m.min(self.gap_m(&squares, &pose) - wanted_m);
                }
            }
            (count, least_m)
        }
    }

    #[test]
    fn admissible_arcs_keep_the_margin_to_every_square_at_every_resolution() {
        let mut rng = Pcg64Mcg::seed_from_u64(1);
        let settings = NavigatorSettings::default();
        let (mut admissible, mut reduced, mut violations) = (0, 0, 0);
        for case in 0..300 {
            let it = Case::random(&mut rng);
            let parts = rng.random_range(1..4);
            let field = ClearanceField::of_areas(&it.obstacles, parts).expect("a field");
            let inflated = it.inflated(&settings, &field);
            let kept_m = inflated.static_margin_m;
            assert!((MIN_STATIC_MARGIN_M..=settings.safety_margin_m).contains(&kept_m));
            let (count, beyond_m) = it.evaluate(field, &inflated.footprint, kept_m);
            assert!(beyond_m >= 0.0, "case {case}: {beyond_m} m beyond {kept_m} m");
            admissible += count;
            reduced += u32::from(kept_m < settings.safety_margin_m);
            // The check detects a violated margin: distances between centres are too long.
            let between_centers = ClearanceField::new(&it.obstacles).expect("a field");
            let (_, beyond_m) = it.evaluate(between_centers, &inflated.footprint, kept_m);
            violations += u32::from(beyond_m < 0.0);
        }
        assert!(admissible > 400 && reduced > 10, "{admissible} admissible, {reduced} reduced");
        assert!(violations > 5, "{violations} violations by distances between centres");
    }

    /// A corridor is passed if it is wider than the discs with their margins by two cells of the window.
    #[test]
    fn corridor_wide_enough_for_body_and_margin_is_passed_at_every_resolution() {
        let settings = NavigatorSettings::default();
        let body = Polygon::rectangle(0.7, 0.5).expect("a rectangle");
        let robot = RobotModel { footprint: Footprint::covering(body), limits: Limits::default() };
        for (resolution_m, parts) in [(0.02, 1), (0.05, 1), (0.1, 2), (0.125, 3), (0.25, 5)] {
            let cell_m = resolution_m / f64::from(parts);
            let needed_m = 2.0 * (robot.footprint.max_disc_radius_m() + 0.056) + 2.0 * cell_m;
            let wide = (needed_m / resolution_m).ceil() as i32;
            let frame = GridFrame::new(200, 80, resolution_m, Pose::default()).expect("a size");
            let mut obstacles = ObstacleGrid::filled(frame, true);
            for row in 20..20 + wide {
                (0..200).for_each(|column| obstacles.set(Cell::new(column, row), false));
            }
            let middle = frame.from_cell_units(&Point::new(60.0, 20.0 + f64::from(wide) / 2.0));
            let it = Case {
                obstacles,
                robot: robot.clone(),
                local: LocalSettings::default().vx_samples(8).vtheta_samples(9).sim_time_s(1.0),
                now: standing_at(Pose::new(middle.x, middle.y, 0.0)),
            };
            let field = ClearanceField::of_areas(&it.obstacles, parts).expect("a field");
            let inflated = it.inflated(&settings, &field);
            assert!(!inflated.within_a_margin, "at {resolution_m} m");
            let (count, _) = it.evaluate(field, &inflated.footprint, settings.safety_margin_m);
            assert!(count > 0, "at {resolution_m} m, {wide} cells");
        }
    }

    /// A robot in the open, with walls 5 m away.
    fn in_the_open(moving: Vec<MovingDisc>) -> (InflatedBodies, ClearanceField, f64) {
        let footprint = Footprint::round(0.3).expect("a radius");
        before_a_wall(&footprint, &PredictedState { moving, ..standing_at(Pose::default()) })
    }

    /// A robot before a wall that begins at 5 m.
    fn before_a_wall(
        footprint: &Footprint,
        now: &PredictedState,
    ) -> (InflatedBodies, ClearanceField, f64) {
        let frame = GridFrame::new(201, 201, 0.05, Pose::new(-5.0, -5.0, 0.0)).expect("a size");
        let mut obstacles = ObstacleGrid::filled(frame, false);
        (0..201).for_each(|row| obstacles.set(Cell::new(200, row), true));
        let field = ClearanceField::of_areas(&obstacles, 1).expect("a field");
        let limits = Limits::default();
        let (settings, local) = (NavigatorSettings::default(), LocalSettings::default());
        let error_m = clearance_error_m(footprint, &limits, &local, field.unit_m());
        let inflated = InflatedBodies::new(footprint, &limits, &settings, &local, &field, now);
        (inflated, field, error_m)
    }

    #[test]
    fn moving_obstacles_keep_their_margin_or_what_is_left_of_it() {
        let settings = NavigatorSettings::default();
        let (margin_m, passing_m) = (settings.moving_margin_m, settings.passing_margin_m);
        for (gap_m, kept_m) in [
            (margin_m + 0.5, margin_m),
            (margin_m - 0.025, margin_m - 0.03),
            (margin_m - 0.035, passing_m.min(margin_m - 0.04)),
            (0.06, passing_m.min(0.055)),
            (0.01, 0.005),
        ] {
            let disc = MovingDisc { x: 0.6 + gap_m, y: 0.0, radius: 0.3, vx: 0.0, vy: 0.0 };
            let (inflated, _, _) = in_the_open(vec![disc]);
            let left_m = inflated.footprint.gap_to_moving_m(&Pose::default(), &inflated.moving[0]);
            assert!((left_m - (gap_m - kept_m)).abs() < 1e-9, "{gap_m}: {left_m}");
            assert_eq!(inflated.within_a_margin, gap_m < margin_m - OVERSHOOT_M, "{gap_m}");
        }
    }

    #[test]
    fn later_poses_are_compared_with_moving_obstacles_of_their_time() {
        let disc = MovingDisc { x: 3.0, y: 0.0, radius: 0.3, vx: -1.0, vy: 0.0 };
        let (inflated, _, _) = in_the_open(vec![disc]);
        let clear =
            |x: f64, time_s: f64| inflated.is_clear_of_moving(&Pose::new(x, 0.0, 0.0), time_s);
        assert!(clear(0.0, 0.0) && !clear(3.0, 0.0));
        assert!(!clear(0.0, 3.0) && clear(3.0, 3.0));
        let reach_m = 0.6 + NavigatorSettings::default().moving_margin_m;
        assert!(clear(3.0 - reach_m - 0.01, 0.0) && !clear(3.0 - reach_m + 0.01, 0.0));
    }

    #[test]
    fn pose_is_clear_of_static_obstacles_from_the_least_margin() {
        let (inflated, field, error_m) = in_the_open(Vec::new());
        assert!(!inflated.within_a_margin);
        // The wall begins at 5 m.
        let clear = |gap_m: f64| {
            inflated.is_clear_of_static(&field, &Pose::new(5.0 - 0.3 - gap_m, 0.0, 0.0))
        };
        assert!(!clear(MIN_STATIC_MARGIN_M - 0.001));
        assert!(clear(MIN_STATIC_MARGIN_M + error_m + field.unit_m() + 0.05));
        // Beyond the map nothing is certain.
        assert!(!inflated.is_clear_of_static(&field, &Pose::new(50.0, 0.0, 0.0)));
    }

    #[test]
    fn padding_covers_the_static_margin_and_all_that_the_engines_overlook() {
        let (inflated, _, error_m) = in_the_open(Vec::new());
        let padding_m = inflated.footprint.max_disc_radius_m() - 0.3;
        let needed_m = NavigatorSettings::default().safety_margin_m + error_m;
        assert!(error_m > 0.0 && (padding_m - needed_m).abs() < 1e-9, "{padding_m} of {needed_m}");
    }

    /// Otherwise no velocity would be admissible there.
    #[test]
    fn robot_near_a_wall_is_slow_and_its_inflated_footprint_still_fits() {
        let wanted_m = NavigatorSettings::default().safety_margin_m;
        let body = Polygon::rectangle(0.7, 0.5).expect("a rectangle");
        for footprint in [Footprint::round(0.3).expect("a radius"), Footprint::covering(body)] {
            let discs = footprint.without_body();
            let (mut slow, mut fast) = (0, 0);
            for step in 0..200 {
                let pose = Pose::new(4.4 + 0.002 * f64::from(step), 0.0, 0.0);
                let now = standing_at(pose);
                let (inflated, field, error_m) = before_a_wall(&footprint, &now);
                let certain_m = field.clearance_m(&discs, &pose).expect("in the map") - error_m;
                assert_eq!(inflated.within_a_margin, certain_m < wanted_m, "{pose:?}");
                if certain_m > MIN_STATIC_MARGIN_M + SLACK_M {
                    let left_m = field.clearance_m(&inflated.footprint.without_body(), &pose);
                    assert!(left_m >= Some(-1e-9), "{pose:?}: {left_m:?}");
                    *(if inflated.within_a_margin { &mut slow } else { &mut fast }) += 1;
                }
            }
            assert!(slow > 5 && fast > 5, "{slow} slow, {fast} fast");
        }
    }

    /// The discs of a body reach beyond it.
    #[test]
    fn discs_of_a_body_fit_between_people_around_it() {
        let body = Polygon::rectangle(0.7, 0.5).expect("a rectangle");
        let footprint = Footprint::covering(body);
        let person = |direction: i32| {
            let (sin, cos) = libm::sincos(0.1 * f64::from(direction));
            MovingDisc { x: 0.8 * cos, y: 0.8 * sin, radius: 0.3, vx: 0.0, vy: 0.0 }
        };
        let moving = (0..63).map(person).collect();
        let now = PredictedState { moving, ..standing_at(Pose::default()) };
        let (inflated, _, _) = before_a_wall(&footprint, &now);
        let discs = inflated.footprint.without_body();
        for person in &inflated.moving {
            let left_m = discs.gap_to_moving_m(&Pose::default(), person);
            assert!(left_m > -1e-9, "{person:?}: {left_m} m");
        }
    }

    #[test]
    fn robot_beyond_the_map_is_slow() {
        let footprint = Footprint::round(0.3).expect("a radius");
        let now = standing_at(Pose::new(50.0, 0.0, 0.0));
        assert!(before_a_wall(&footprint, &now).0.within_a_margin);
    }

    #[test]
    fn pose_nearer_to_a_wall_than_the_least_margin_is_not_clear() {
        let pose = Pose::new(4.5, 0.0, 0.0);
        let (mut nearer, mut farther) = (0, 0);
        for step in 0..100 {
            let footprint = Footprint::round(0.3 + 0.002 * f64::from(step)).expect("a radius");
            let now = standing_at(Pose::default());
            let (inflated, field, error_m) = before_a_wall(&footprint, &now);
            let certain_m = field.clearance_m(&footprint, &pose).expect("in the map") - error_m;
            let is_clear = inflated.is_clear_of_static(&field, &pose);
            if certain_m > MIN_STATIC_MARGIN_M + 1e-9 {
                assert!(is_clear, "{certain_m} m");
                farther += 1;
            } else if (0.0..MIN_STATIC_MARGIN_M - 1e-9).contains(&certain_m) {
                assert!(!is_clear, "{certain_m} m");
                nearer += 1;
            }
        }
        assert!(nearer > 5 && farther > 5, "{nearer} nearer, {farther} farther");
    }
}
