//! A mission in a simulated world, and the simulated robot that drives it.

use core::ops::ControlFlow;

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::fault_injection::{Displacement, FaultyOdometry};
use super::faulty_lidar::{FaultyLidar, degraded_range};
use super::fixes::SimulatedPositioning;
use super::past_obstacles::PastObstacles;
use super::process_robot::ProcessRobot;
use super::protected_sender::ProtectedSender;
use super::warped_map::warped;
use super::wrong_planner::WrongCommands;
use super::{FaultInjection, MovingObstacles, SimBase, SimError, draw_plant};
use crate::base::ProtectiveAction;
use crate::geometry::{Pose, Twist, wrap_angle};
use crate::local::Engine;
use crate::localization::PoseHistory;
use crate::map::{MovingDisc, ObstacleGrid};
use crate::navigator::Controller;
use crate::robot::Footprint;
use crate::runtime::{
    Config, Contact, GroundTruth, LidarData, Mission, MissionResult, Observer, ObstacleGap,
    PoseSource, Robot, SensorData, SimulationSettings, TouchedBody, run_mission, run_mission_with,
};

/// A mission and its world.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// The mission.
    pub mission: Mission,
    /// True static obstacles, where they differ from the map.
    pub truth: Option<ObstacleGrid>,
    /// The moving obstacles.
    pub moving_obstacles: MovingObstacles,
    /// Faults that happen to the robot.
    pub faults: Vec<FaultInjection>,
    /// Seed of all noise.
    pub seed: u64,
}

impl Simulation {
    /// Creates a simulation in which the map is true and nothing else moves; its seed is zero.
    #[must_use]
    pub fn new(mission: Mission) -> Self {
        Self {
            mission,
            truth: None,
            moving_obstacles: MovingObstacles::default(),
            faults: Vec::new(),
            seed: 0,
        }
    }

    /// The true static obstacles: those of [`Self::truth`] or of the map, with the error of the map.
    #[must_use]
    pub fn true_obstacles(&self, config: &Config) -> ObstacleGrid {
        let error_m = draw_plant(&config.simulation, self.seed).map_error_m;
        let known = || self.mission.map.obstacles(config.unknown);
        let truth = self.truth.clone().unwrap_or_else(known);
        if error_m > 0.0 { warped(&truth, error_m, self.seed) } else { truth }
    }

    /// Runs the mission with a simulated base and a controller that decides in place of inbye's behaviours.
    ///
    /// # Errors
    /// As [`run_mission`].
    pub fn run_controller(
        &self,
        config: &Config,
        controller: Box<dyn Controller>,
        observer: &mut Observer<'_>,
    ) -> Result<MissionResult, SimError> {
        config.validate()?;
        let mut base = SimBase::of(config, self.mission.start, self.seed)?;
        let mut robot = SimulatedRobot::new(self, config, &mut base)?;
        Ok(run_mission_with(&self.mission, config, controller, &mut robot, observer)?)
    }

    /// Runs the mission with a simulated base, or in the simulator of the settings if they name a program.
    ///
    /// # Errors
    /// As [`run_mission`], and when that program cannot be started.
    pub fn run(
        &self,
        config: &Config,
        engine: Box<dyn Engine>,
        observer: &mut Observer<'_>,
    ) -> Result<MissionResult, SimError> {
        if config.simulator.is_set() {
            config.validate()?;
            let mut robot = ProcessRobot::start(self, config)?;
            return Ok(run_mission(&self.mission, config, engine, &mut robot, observer)?);
        }
        let mut base = SimBase::of(config, self.mission.start, self.seed)?;
        self.run_with(&mut base, config, engine, observer)
    }

    /// Runs the mission with another base, real or simulated, which stands at the mission's start. Its own lidar and
    /// positioning are not used: both are simulated at its true pose. A base without a true pose counts as being at the pose
    /// of its odometry.
    ///
    /// # Errors
    /// As [`run_mission`].
    pub fn run_with(
        &self,
        base: &mut dyn Robot,
        config: &Config,
        engine: Box<dyn Engine>,
        observer: &mut Observer<'_>,
    ) -> Result<MissionResult, SimError> {
        config.validate()?;
        let mut robot = SimulatedRobot::new(self, config, base)?;
        let result = run_mission(&self.mission, config, engine, &mut robot, observer);
        Ok(result?)
    }
}

/// Longest time between two checks for contact, seconds.
const CONTACT_STEP_S: f64 = 0.01;
/// Between two ticks only smaller gaps are measured by the body, metres: a cheaper bound shows that the others are larger.
const MEASURED_GAP_M: f64 = 0.1;

/// A base in a simulated world, with a simulated lidar and simulated positioning.
struct SimulatedRobot<'a> {
    config: &'a Config,
    base: &'a mut dyn Robot,
    world: World,
    /// The simulated robot and its world as they truly are.
    plant: SimulationSettings,
    /// The faults of the simulation and of the plant.
    faults: Vec<FaultInjection>,
    past: PastObstacles,
    moving_obstacles: MovingObstacles,
    displacement: Displacement,
    faulty_odometry: FaultyOdometry,
    /// Time of the last sensing, seconds, and the truth then.
    time_s: f64,
    pose: Pose,
    twist: Twist,
    /// Smallest gap since then, where it was below [`MEASURED_GAP_M`], metres.
    least_gap_m: f64,
    /// The first contact since then.
    contact: Option<Contact>,
    /// Recent true poses.
    true_poses: PoseHistory,
    lidar_rng: Pcg64Mcg,
    wrong_commands: WrongCommands,
    sender: ProtectedSender,
    faulty_lidar: FaultyLidar,
    positioning: Option<SimulatedPositioning>,
}

impl<'a> SimulatedRobot<'a> {
    fn new(
        simulation: &'a Simulation,
        config: &'a Config,
        base: &'a mut dyn Robot,
    ) -> Result<Self, SimError> {
        let Simulation { mission, seed, .. } = simulation;
        let limits = config.robot.limits;
        let sender = ProtectedSender::new(config)?;
        let plant = draw_plant(&config.simulation, *seed);
        let blind_sector = FaultInjection::blind_sector(&plant.lidar);
        let faults = simulation.faults.iter().copied().chain(blind_sector).collect();
        let positioning = match config.pose_source {
            PoseSource::Fixes => {
                Some(SimulatedPositioning::new(plant.fixes, mission.start, *seed)?)
            }
            PoseSource::Scans => None,
        };
        Ok(Self {
            config,
            base,
            world: World::new(simulation.true_obstacles(config)),
            plant,
            faults,
            past: PastObstacles::default(),
            moving_obstacles: simulation.moving_obstacles.clone(),
            displacement: Displacement::default(),
            faulty_odometry: FaultyOdometry::default(),
            time_s: 0.0,
            pose: mission.start,
            twist: Twist::STOP,
            least_gap_m: f64::INFINITY,
            contact: None,
            true_poses: PoseHistory::new(),
            lidar_rng: Pcg64Mcg::seed_from_u64(*seed),
            wrong_commands: WrongCommands::new(config.simulation.wrong_planner, limits, *seed),
            sender,
            faulty_lidar: FaultyLidar::new(*seed),
            positioning,
        })
    }

    /// Scans as of a time, seconds, with that time or the present one as its stamp.
    fn scan(&mut self, measured_s: f64, stamp_s: f64) -> LidarData {
        let lidar = &self.plant.lidar;
        let faults = &self.faults;
        let true_poses = &self.true_poses;
        let pose_at = |time_s: f64| true_poses.at(time_s).unwrap_or_default();
        if lidar.sweep_s > 0.0 {
            let mut sweep = lidar.sweep(&self.world, pose_at, measured_s, &mut self.lidar_rng);
            for beam in &mut sweep.beams {
                beam.range = degraded_range(faults, beam.time_s, beam.angle, beam.range);
                beam.time_s += stamp_s - measured_s;
            }
            return LidarData::TimedScan(sweep);
        }
        let pose = pose_at(measured_s);
        let mut scan = lidar.scan(&self.world, &pose, &mut self.lidar_rng).scan;
        for beam in 0..scan.ranges.len() {
            let direction = scan.angle(beam);
            let range = scan.ranges[beam];
            scan.ranges[beam] = degraded_range(faults, measured_s, direction, range);
        }
        LidarData::Scan(scan)
    }
}

impl SimulatedRobot<'_> {
    /// Moves the obstacles while the robot drives to a pose, and measures the gaps during the motion. The robot's path within the
    /// period is an arc: an acceleration of 1 m/s^2 moves it along that by 1.3 mm at most.
    fn move_others(&mut self, to: &Pose, period_s: f64) {
        (self.least_gap_m, self.contact) = (f64::INFINITY, None);
        let footprint = &self.config.robot.footprint;
        let steps = (period_s / CONTACT_STEP_S).round().max(1.0);
        // The mean motion of the period, and the motion before it: a robot that brakes has closed the gap earlier.
        let twists = [self.twist, mean_twist(&self.pose, to, period_s)];
        for step in 1..=steps as u32 {
            let share = f64::from(step) / steps;
            let pose = self.pose.interpolate(to, share);
            self.moving_obstacles.step(period_s / steps, &pose, footprint);
            self.world.moving = self.moving_obstacles.discs();
            if self.world.lower_gap_m(footprint, &pose) < MEASURED_GAP_M {
                let gap_m = self.world.gap_m(footprint, &pose);
                self.least_gap_m = self.least_gap_m.min(gap_m);
                if gap_m <= 0.0 && self.contact.is_none() {
                    let time_s = self.time_s + share * period_s;
                    self.contact = Some(self.contact_at(time_s, &pose, &twists));
                }
            }
        }
    }

    /// The contact of the robot at a pose at which it touches something, given its motions in the present period.
    fn contact_at(&self, time_s: f64, pose: &Pose, twists: &[Twist]) -> Contact {
        let footprint = &self.config.robot.footprint;
        let mut contact = self.world.contact(footprint, time_s, pose, twists);
        if let TouchedBody::Moving { index, .. } = &mut contact.body {
            // The world counts the obstacles that have appeared.
            let states = self.moving_obstacles.states();
            let mut present = states.iter().enumerate().filter(|(_, state)| state.is_some());
            *index = present.nth(*index).map_or(*index, |(index, _)| index);
        }
        contact
    }

    /// The command that the sender lets through.
    fn protected(&mut self, command: &Twist) -> Twist {
        let people = &self.world.moving;
        let faults = &self.faults;
        let command = self.wrong_commands.instead(command, faults, self.time_s, &self.pose, people);
        self.sender.protected(&command, self.time_s)
    }
}

impl Robot for SimulatedRobot<'_> {
    fn sense(&mut self, time_s: f64) -> SensorData {
        self.time_s = time_s;
        let SimulationSettings { sensing_delay_s, stamps_sensing_delay, .. } = self.plant;
        let measured_s = (time_s - sensing_delay_s).max(0.0);
        let stamp_s = if stamps_sensing_delay { measured_s } else { time_s };
        self.world.moving = self.moving_obstacles.discs();
        self.world.seen = if sensing_delay_s > 0.0 {
            self.past.record(time_s, self.moving_obstacles.parts());
            Some(self.past.at(measured_s))
        } else {
            self.moving_obstacles.legs()
        };
        let sensed = self.base.sense(time_s);
        let (own, twist) = match self.base.ground_truth() {
            Some(truth) => (truth.pose, truth.twist),
            None => (sensed.odometry.pose, sensed.odometry.twist),
        };
        let faults = &self.faults;
        let (odometry, odometry_s) =
            self.faulty_odometry.reported(faults, time_s, sensed.odometry, sensed.odometry_s);
        self.pose = self.displacement.pose(&self.faults, time_s, &own);
        self.twist = if self.displacement.is_bogged() { Twist::STOP } else { twist };
        self.true_poses.record(time_s, &self.pose);
        let measured = self.scan(measured_s, stamp_s);
        let lidar = self.faulty_lidar.sent(&self.faults, time_s, stamp_s, measured);
        self.sender.update(time_s, (&odometry.twist, odometry_s), &lidar);
        let then = self.true_poses.at(measured_s).unwrap_or(self.pose);
        let mut positioning = self.positioning.as_mut();
        let faults = &self.faults;
        let pose =
            positioning.as_mut().map(|it| it.pose(faults, measured_s, &odometry.pose, &then));
        let fixed_s = positioning.and_then(|it| it.fixed_s());
        SensorData {
            odometry,
            odometry_s,
            lidar: Some(lidar),
            pose,
            pose_s: fixed_s.map(|fixed_s| fixed_s + stamp_s - measured_s),
            sent: sensed.sent.or(Some(self.sender.sent)),
        }
    }

    fn ground_truth(&self) -> Option<GroundTruth> {
        let footprint = &self.config.robot.footprint;
        let places = self.moving_obstacles.states();
        let gap_m = self.world.gap_m(footprint, &self.pose);
        let at_present = || self.contact_at(self.time_s, &self.pose, &[self.twist]);
        Some(GroundTruth {
            pose: self.pose,
            twist: self.twist,
            gap_m: Some(gap_m.min(self.least_gap_m)),
            contact: self.contact.or_else(|| (gap_m <= 0.0).then(at_present)),
            moving: places.iter().map(|place| place.as_ref().map(MovingDisc::center)).collect(),
        })
    }

    fn moving_radii_m(&self) -> Vec<f64> {
        self.moving_obstacles.radii()
    }

    fn is_real_time(&self) -> bool {
        self.base.is_real_time()
    }

    fn drive(&mut self, command: &Twist, period_s: f64) -> ControlFlow<()> {
        let command = self.protected(command);
        let flow = self.base.drive(&command, period_s);
        let own = match self.base.ground_truth() {
            Some(truth) => truth.pose,
            None => self.base.sense(self.time_s + period_s).odometry.pose,
        };
        let pose = self.displacement.pose_in_map(&own);
        self.move_others(&pose, period_s);
        flow
    }

    fn protective_action(&self) -> ProtectiveAction {
        self.sender.action()
    }

    fn fault(&self) -> Option<String> {
        self.base.fault()
    }
}

/// The mean motion from one pose to another within a time, seconds.
fn mean_twist(from: &Pose, to: &Pose, time_s: f64) -> Twist {
    let moved = from.inverse_transform(&to.position());
    Twist::new(moved.x / time_s, wrap_angle(to.yaw - from.yaw) / time_s)
}

/// Everything that the robot can touch. All gaps are in metres, exact to rounding; at or below zero there is contact.
#[derive(Clone, Debug)]
pub struct World {
    obstacles: ObstacleGap,
    /// Moving obstacles at their present positions.
    pub moving: Vec<MovingDisc>,
    /// What a lidar hits of them, each part with the index of its obstacle: legs, or an earlier position. None: the discs of
    /// `moving`.
    pub seen: Option<Vec<(usize, MovingDisc)>>,
}

impl World {
    /// Creates a world without moving obstacles.
    #[must_use]
    pub fn new(obstacles: ObstacleGrid) -> Self {
        Self { obstacles: ObstacleGap::new(obstacles), moving: Vec::new(), seen: None }
    }

    /// The static obstacles.
    #[must_use]
    pub const fn obstacles(&self) -> &ObstacleGrid {
        self.obstacles.obstacles()
    }

    /// The smallest gap between the body and anything solid.
    #[must_use]
    pub fn gap_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        self.gap_to_static_m(footprint, pose).min(self.gap_to_moving_m(footprint, pose))
    }

    /// As [`Self::gap_m`], by the discs of the footprint: at most that of the body, and faster.
    #[must_use]
    fn lower_gap_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        self.obstacles.disc_gap_m(footprint, pose).min(self.gap_to_moving_m(footprint, pose))
    }

    /// The smallest gap between the body and the static obstacles: see [`ObstacleGap::gap_m`].
    #[must_use]
    pub fn gap_to_static_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        self.obstacles.gap_m(footprint, pose)
    }

    /// The contact at a time, seconds, of a robot at a pose, by the nearest body. The robot closes the gap at the highest speed
    /// of these motions. A moving body has its index in `moving`.
    #[must_use]
    pub fn contact(
        &self,
        footprint: &Footprint,
        time_s: f64,
        pose: &Pose,
        twists: &[Twist],
    ) -> Contact {
        let gap_m = |disc: &MovingDisc| footprint.gap_to_disc_m(pose, &disc.center(), disc.radius);
        let by_gap = self.moving.iter().enumerate().map(|(index, disc)| (gap_m(disc), index, disc));
        let nearest = by_gap.min_by(|one, other| one.0.total_cmp(&other.0));
        let to_static_m = self.gap_to_static_m(footprint, pose);
        let touched = |(_, index, disc): (f64, usize, &MovingDisc)| {
            let closing = |twist| footprint.closing_speed_m_s(pose, twist, &disc.center());
            TouchedBody::Moving {
                index,
                speed_m_s: libm::hypot(disc.vx, disc.vy),
                closing_m_s: twists.iter().map(closing).fold(f64::NEG_INFINITY, f64::max),
            }
        };
        let nearest = nearest.filter(|nearest| nearest.0 < to_static_m);
        let body = nearest.map_or(TouchedBody::Static, touched);
        Contact { time_s, pose: *pose, body }
    }

    /// The smallest gap between the body and the moving obstacles; infinite without any.
    #[must_use]
    pub fn gap_to_moving_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        self.moving
            .iter()
            .map(|disc| footprint.gap_to_disc_m(pose, &disc.center(), disc.radius))
            .fold(f64::INFINITY, f64::min)
    }
}
