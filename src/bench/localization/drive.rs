//! A drive by matched scans, and what befalls it.

use core::f64::consts::PI;
use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::LocalizationRow;
use super::ground::{coarsened, smooth_roadway, twin_roadways};
use crate::geometry::{Point, Pose, wrap_angle};
use crate::local::CpuEngine;
use crate::localization::State;
use crate::map::{DistanceField, OccupancyGrid};
use crate::navigator::{Fault, Goal};
use crate::sim::{
    Config, Crowd, Mishap, Mission, MissionError, Moment, Observer, PoseFrom, Walkers, crossing,
    roadway as roadway_scene, run_mission,
};

/// When mishaps happen, seconds: the robot is under way.
const MISHAP_S: f64 = 12.0;

/// Within so long a mishap is to be noticed, seconds.
const NOTICED_S: f64 = 1.0;

/// A robot slower than this stands, m/s.
const STANDS: f64 = 0.02;

/// Length and width of the smooth roadways, metres.
const ROADWAY_M: (f64, f64) = (120.0, 3.0);

/// Room about a place that a robot is carried to, metres, its least distance from the start, and how often one is drawn at most.
const ROOM_M: f64 = 1.1;
const AWAY_M: f64 = 20.0;
const TRIES: usize = 100_000;

/// Longest time of a drive, seconds.
const LONGEST_S: f64 = 3600.0;

/// What a drive is to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LocalizationCase {
    /// To and fro between the ends, as long as the tour is to be.
    Tour,
    /// The same among five people that the map does not show.
    People,
    /// The same with a map whose cells are twice as wide as those of the world.
    CoarseMap,
    /// Along a straight smooth roadway of 120 m that does not say how far along it one is.
    Smooth,
    /// Carried two metres back under way.
    Carried,
    /// Carried to any other open place of the map, at least 20 m from the start.
    Elsewhere,
    /// Carried into a smooth roadway beside the smooth one that it drives in: nothing tells them apart.
    Twin,
    /// Its lidar sees nothing from a moment on.
    Blinded,
    /// The same for three seconds.
    BlindedForAMoment,
    /// With the map of another mine than that it is in; both are of the built-in scenes.
    OtherMap,
}

impl LocalizationCase {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Tour,
        Self::People,
        Self::CoarseMap,
        Self::Smooth,
        Self::Carried,
        Self::Elsewhere,
        Self::Twin,
        Self::Blinded,
        Self::BlindedForAMoment,
        Self::OtherMap,
    ];

    /// Its word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Tour => "tour",
            Self::People => "people",
            Self::CoarseMap => "coarse_map",
            Self::Smooth => "smooth",
            Self::Carried => "carried",
            Self::Elsewhere => "elsewhere",
            Self::Twin => "twin",
            Self::Blinded => "blinded",
            Self::BlindedForAMoment => "blinded_for_a_moment",
            Self::OtherMap => "other_map",
        }
    }

    const fn mishap_s(self) -> f64 {
        match self {
            Self::Carried
            | Self::Elsewhere
            | Self::Twin
            | Self::Blinded
            | Self::BlindedForAMoment => MISHAP_S,
            _ => 0.0,
        }
    }
}

/// Where drives go, and how much slips.
#[derive(Clone, Debug)]
pub struct LocalizationPlan {
    /// Name of the map.
    pub name: String,
    /// The map, which is the world.
    pub map: Arc<OccupancyGrid>,
    /// Where drives start.
    pub start: Pose,
    /// Where they turn back.
    pub goal: Point,
    /// Settings of all drives; that the pose is from scans is seen to.
    pub config: Config,
    /// Least length of a tour, metres.
    pub tour_m: f64,
}

impl LocalizationPlan {
    /// One drive.
    ///
    /// # Errors
    /// When a setting is out of range, or no way leads from the start to the goal.
    pub fn drive(
        &self,
        case: LocalizationCase,
        seed: u64,
    ) -> Result<LocalizationRow, MissionError> {
        let config = Config {
            pose_from: PoseFrom::Scans,
            ..self.config.clone()
        };
        let mission = self.mission(case, seed, &config)?;
        let mut watch = Watch::new(case.mishap_s());
        let mut clock = || 0.0;
        let result = run_mission(
            &mission,
            &config,
            Box::new(CpuEngine::single_threaded()),
            &mut Observer {
                clock: &mut clock,
                witness: &mut |moment| watch.see(moment),
            },
        )?;
        Ok(LocalizationRow {
            case: case.word().to_owned(),
            map: self.name.clone(),
            seed,
            slip: config.dynamics.slip.mean,
            reached: result.reached,
            collided: result.collided,
            travelled_m: result.travelled_m,
            time_s: result.time_s,
            fault: result.fault.as_ref().map(ToString::to_string),
            trace_digest: result.trace.digest(),
            ..watch.row()
        })
    }

    fn mission(
        &self,
        case: LocalizationCase,
        seed: u64,
        config: &Config,
    ) -> Result<Mission, MissionError> {
        let (length_m, width_m) = ROADWAY_M;
        let along = |x: f64| Point::new(x, 1.0 + width_m / 2.0);
        let roadway = |map: OccupancyGrid| Mission {
            seed,
            ..Mission::new(
                Arc::new(map),
                Pose::new(3.0, along(3.0).y, 0.0),
                stop(along(length_m - 2.0)),
            )
        };
        let there = Mission {
            seed,
            ..Mission::new(Arc::clone(&self.map), self.start, stop(self.goal))
        };
        let (from_s, to_s) = (MISHAP_S, f64::INFINITY);
        Ok(match case {
            LocalizationCase::Tour => self.to_and_fro(there, config)?,
            LocalizationCase::People => self.among_people(there, config)?,
            LocalizationCase::CoarseMap => {
                let tour = self.to_and_fro(there, config)?;
                Mission {
                    map: Arc::new(coarsened(&self.map)),
                    truth: Some(self.map.obstacles(config.unknown)),
                    ..tour
                }
            }
            LocalizationCase::Smooth => roadway(smooth_roadway(length_m, width_m)),
            LocalizationCase::Carried => {
                let before = self.place_at(config, &there)?;
                Mission {
                    mishaps: vec![Mishap::Carried {
                        at_s: MISHAP_S,
                        to: before,
                    }],
                    ..there
                }
            }
            LocalizationCase::Elsewhere => Mission {
                mishaps: vec![Mishap::Carried {
                    at_s: MISHAP_S,
                    to: self.elsewhere(seed, config),
                }],
                ..there
            },
            LocalizationCase::Twin => Mission {
                mishaps: vec![Mishap::Carried {
                    at_s: MISHAP_S,
                    to: Pose::new(20.0, along(20.0).y + 1.0 + width_m, 0.0),
                }],
                ..roadway(twin_roadways(length_m, width_m))
            },
            LocalizationCase::Blinded => Mission {
                mishaps: vec![Mishap::Blinded { from_s, to_s }],
                ..there
            },
            LocalizationCase::BlindedForAMoment => Mission {
                mishaps: vec![Mishap::Blinded {
                    from_s,
                    to_s: MISHAP_S + 3.0,
                }],
                ..there
            },
            LocalizationCase::OtherMap => {
                let own = roadway_scene();
                Mission {
                    truth: Some(crossing().map.obstacles(config.unknown)),
                    seed,
                    ..Mission::new(Arc::new(own.map), own.start, stop(own.goal))
                }
            }
        })
    }

    /// As many legs as the tour's length asks for.
    fn to_and_fro(&self, there: Mission, config: &Config) -> Result<Mission, MissionError> {
        let length_m = self.leg_m(config)?;
        // Corners are cut: a leg more for that.
        let legs = (self.tour_m / length_m).ceil() as usize + 1;
        let ends = [self.goal, self.start.position()];
        let mut stops: Vec<Goal> = (0..legs).map(|leg| stop(ends[leg % 2])).collect();
        let goal = stops.pop().unwrap_or_else(|| stop(self.goal));
        Ok(Mission {
            via: stops,
            goal,
            time_limit_s: LONGEST_S,
            ..there
        })
    }

    fn among_people(&self, there: Mission, config: &Config) -> Result<Mission, MissionError> {
        let ground = self.map.obstacles(config.unknown);
        let path = self.path(config)?;
        let ends = [self.start.position(), self.goal];
        let crowd = Crowd::new(5, there.seed);
        let walkers = Walkers::seeded(&crowd, &ground, &path, &ends)?;
        let tour = self.to_and_fro(there, config)?;
        Ok(Mission { walkers, ..tour })
    }

    /// Two metres behind where the robot is when mishaps happen, by a drive without one.
    fn place_at(&self, config: &Config, there: &Mission) -> Result<Pose, MissionError> {
        let mission = Mission {
            time_limit_s: MISHAP_S,
            ..there.clone()
        };
        let mut clock = || 0.0;
        let mut nobody = |_: &Moment<'_>| {};
        let result = run_mission(
            &mission,
            config,
            Box::new(CpuEngine::single_threaded()),
            &mut Observer {
                clock: &mut clock,
                witness: &mut nobody,
            },
        )?;
        let rows = &result.trace.rows;
        let last = rows.last().map_or(self.start, |row| row.pose);
        let behind = rows
            .iter()
            .rev()
            .find(|row| (row.pose.position() - last.position()).norm() >= 2.0);
        Ok(behind.map_or(self.start, |row| row.pose))
    }

    /// An open place with room for the robot, at least so far from where drives start and turn back, and any yaw.
    fn elsewhere(&self, seed: u64, config: &Config) -> Pose {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let field = DistanceField::new(&self.map.obstacles(config.unknown));
        let frame = field.frame();
        let is_good = |pose: &Pose| {
            let cell = frame.cell_of(&pose.position());
            cell.is_some_and(|cell| field.distance_m(cell) > ROOM_M)
                && (pose.position() - self.start.position()).norm() > AWAY_M
        };
        let mut any = || {
            let cell = frame.cell_at(rng.random_range(0..frame.len()));
            let place = frame.center_of(cell);
            Pose::new(place.x, place.y, rng.random_range(-PI..PI))
        };
        let found = (0..TRIES).map(|_| any()).find(is_good);
        found.unwrap_or_else(|| Pose::new(self.goal.x, self.goal.y, 0.0))
    }

    fn path(&self, config: &Config) -> Result<Vec<Point>, MissionError> {
        let ground = self.map.obstacles(config.unknown);
        let mut planner = config.route_planner(self.map.frame().resolution_m);
        let plan = planner
            .plan(&ground, self.start.position(), self.goal, &mut || 0.0)
            .map_err(Fault::Plan)?;
        Ok(plan.smoothed.points().to_vec())
    }

    fn leg_m(&self, config: &Config) -> Result<f64, MissionError> {
        let path = self.path(config)?;
        let ways = path.windows(2).map(|leg| (leg[1] - leg[0]).norm());
        Ok(ways.sum::<f64>().max(1.0))
    }
}

const fn stop(position: Point) -> Goal {
    Goal {
        position,
        yaw: None,
    }
}

/// Errors as they come.
struct Watch {
    mishap_s: f64,
    row: LocalizationRow,
    squares: f64,
    known_ticks: u64,
    ticks: u64,
    unseen: u64,
    lost_s: Option<f64>,
    /// Way since the mishap, and where the robot was at the tick before.
    driven_m: f64,
    before: Option<Pose>,
    has_stood: bool,
}

impl Watch {
    fn new(mishap_s: f64) -> Self {
        Self {
            mishap_s,
            row: LocalizationRow {
                case: String::new(),
                map: String::new(),
                seed: 0,
                slip: 0.0,
                reached: false,
                collided: false,
                travelled_m: 0.0,
                time_s: 0.0,
                worst_m: 0.0,
                worst_rad: 0.0,
                worst_tracking_m: 0.0,
                rms_m: 0.0,
                odometry_worst_m: 0.0,
                odometry_worst_rad: 0.0,
                sigma_m: 0.0,
                unseen_share: 0.0,
                least_agreement: 1.0,
                uncertain_ticks: 0,
                lost_ticks: 0,
                lost_why: None,
                lost_after_s: None,
                driven_on_m: None,
                found_after_s: None,
                fault: None,
                trace_digest: String::new(),
            },
            squares: 0.0,
            known_ticks: 0,
            ticks: 0,
            unseen: 0,
            lost_s: None,
            driven_m: 0.0,
            before: None,
            has_stood: false,
        }
    }

    fn see(&mut self, moment: &Moment<'_>) {
        let Some(fix) = moment.fix else {
            return;
        };
        let (truth, now_s) = (&moment.row.pose, moment.row.time_s);
        let is_unnoticed = self.is_unnoticed(now_s);
        let row = &mut self.row;
        let off = |pose: &Pose| {
            let off_m = (pose.position() - truth.position()).norm();
            (off_m, wrap_angle(pose.yaw - truth.yaw).abs())
        };
        self.ticks += 1;
        self.unseen += u64::from(fix.unseen_directions > 0);
        row.sigma_m = row.sigma_m.max(fix.sigma_m());
        row.least_agreement = row.least_agreement.min(fix.agreement.agree_share());
        match fix.state {
            State::Lost(why) => {
                row.lost_ticks += 1;
                if self.lost_s.is_none() {
                    self.lost_s = Some(now_s);
                    row.lost_why = Some(why.to_string());
                    row.lost_after_s = Some(now_s - self.mishap_s);
                }
            }
            // What nobody can know before it has been looked at is no error.
            _ if is_unnoticed => {}
            State::Tracking | State::Uncertain => {
                row.uncertain_ticks += u64::from(fix.state == State::Uncertain);
                if let Some(lost_s) = self.lost_s {
                    row.found_after_s.get_or_insert(now_s - lost_s);
                }
                let ((off_m, off_rad), (drift_m, drift_rad)) =
                    (off(&moment.row.belief), off(&moment.odometry.pose));
                if fix.state == State::Tracking {
                    row.worst_tracking_m = row.worst_tracking_m.max(off_m);
                }
                row.worst_m = row.worst_m.max(off_m);
                row.worst_rad = row.worst_rad.max(off_rad);
                row.odometry_worst_m = row.odometry_worst_m.max(drift_m);
                row.odometry_worst_rad = row.odometry_worst_rad.max(drift_rad);
                self.squares += off_m * off_m;
                self.known_ticks += 1;
            }
        }
        // The tick of the mishap is a leap and no way.
        if let Some(before) = self.before.filter(|_| now_s > self.mishap_s + 0.15) {
            self.driven_m += (truth.position() - before.position()).norm();
        }
        self.before = Some(*truth);
        let is_over = moment.row.twist.linear.abs() < STANDS || row.found_after_s.is_some();
        if self.lost_s.is_some() && is_over && !self.has_stood {
            self.has_stood = true;
            row.driven_on_m = Some(self.driven_m);
        }
    }

    /// Whether a mishap has happened that the robot has not yet noticed, and is about to.
    fn is_unnoticed(&self, now_s: f64) -> bool {
        let since_s = now_s - self.mishap_s;
        self.mishap_s > 0.0 && self.lost_s.is_none() && (0.0..NOTICED_S).contains(&since_s)
    }

    fn row(self) -> LocalizationRow {
        LocalizationRow {
            rms_m: (self.squares / self.known_ticks.max(1) as f64).sqrt(),
            unseen_share: self.unseen as f64 / self.ticks.max(1) as f64,
            ..self.row
        }
    }
}
