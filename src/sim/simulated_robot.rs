//! A robot in a simulated world.

use core::ops::ControlFlow;

use super::fault_injection::{Displacement, FaultyOdometry};
use super::fixes::SimulatedPositioning;
use super::past_obstacles::PastObstacles;
use super::protected_sender::ProtectedSender;
use super::simulated_lidar::SimulatedLidar;
use super::{FaultInjection, MovingObstacles, SimBase, SimError, Simulation, World, draw_plant};
use crate::base::ProtectiveAction;
use crate::geometry::{Pose, Twist, wrap_angle};
use crate::localization::PoseHistory;
use crate::map::MovingDisc;
use crate::robot::Footprint;
use crate::runtime::{
    Config, Contact, GroundTruth, PoseSource, Robot, SensorData, SimulationSettings, TouchedBody,
};

/// Longest time between two checks for contact, seconds.
const CONTACT_STEP_S: f64 = 0.01;
/// Between two ticks only smaller gaps are measured by the body, metres: a cheaper bound shows that the others are larger.
const MEASURED_GAP_M: f64 = 0.1;

/// A base in a simulated world, with a simulated lidar and simulated positioning. [`Simulation::robot`] makes one.
pub struct SimulatedRobot<B = SimBase> {
    footprint: Footprint,
    base: B,
    world: World,
    /// The simulated robot and its world as they truly are.
    plant: SimulationSettings,
    /// The faults of the simulation and of the plant.
    faults: Vec<FaultInjection>,
    past: PastObstacles,
    moving_obstacles: MovingObstacles,
    displacement: Displacement,
    faulty_odometry: FaultyOdometry,
    /// Time of the last sensing by the base's clock, seconds, for a base in real time.
    sensed_s: Option<f64>,
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
    sender: ProtectedSender,
    lidar: SimulatedLidar,
    positioning: Option<SimulatedPositioning>,
}

crate::settings::opaque_debug!(SimulatedRobot<B>);

impl<B: Robot> SimulatedRobot<B> {
    /// Puts a base, which stands at the mission's start, into the world of a simulation.
    pub(super) fn new(simulation: &Simulation, config: &Config, base: B) -> Result<Self, SimError> {
        let Simulation { mission, seed, .. } = simulation;
        simulation.check_faults()?;
        let sender = ProtectedSender::new(config, *seed)?;
        let plant = draw_plant(config, *seed);
        let blind_sector = FaultInjection::blind_sector(&plant.lidar);
        let faults = simulation.faults.iter().copied().chain(blind_sector).collect();
        let positioning = match config.pose_source {
            PoseSource::Fixes => {
                Some(SimulatedPositioning::new(plant.fixes, mission.start, *seed)?)
            }
            PoseSource::Scans => None,
        };
        Ok(Self {
            footprint: config.robot.footprint.clone(),
            base,
            world: World::new(simulation.true_obstacles(config)),
            lidar: SimulatedLidar::new(plant.lidar, *seed),
            plant,
            faults,
            past: PastObstacles::default(),
            moving_obstacles: simulation.moving_obstacles.clone(),
            displacement: Displacement::default(),
            faulty_odometry: FaultyOdometry::default(),
            sensed_s: None,
            time_s: 0.0,
            pose: mission.start,
            twist: Twist::STOP,
            least_gap_m: f64::INFINITY,
            contact: None,
            true_poses: PoseHistory::new(),
            sender,
            positioning,
        })
    }

    /// Moves the obstacles while the robot drives to a pose, and measures the gaps during the motion. The robot's path within a
    /// period is an arc: an acceleration of 1 m/s^2 moves it along that by 1.3 mm at most.
    fn move_others(&mut self, to: &Pose, elapsed_s: f64) {
        (self.least_gap_m, self.contact) = (f64::INFINITY, None);
        let footprint = &self.footprint;
        let steps = (elapsed_s / CONTACT_STEP_S).round().max(1.0);
        // The mean motion of this time, and the motion before it: a robot that brakes has closed the gap earlier.
        let twists = [self.twist, mean_twist(&self.pose, to, elapsed_s)];
        for step in 1..=steps as u32 {
            let share = f64::from(step) / steps;
            let pose = self.pose.interpolate(to, share);
            self.moving_obstacles.step(elapsed_s / steps, &pose, footprint);
            self.world.moving = self.moving_obstacles.discs();
            if self.world.may_be_nearer(footprint, &pose, MEASURED_GAP_M) {
                let gap_m = self.world.gap_m(footprint, &pose);
                self.least_gap_m = self.least_gap_m.min(gap_m);
                if gap_m <= 0.0 && self.contact.is_none() {
                    let time_s = self.time_s + share * elapsed_s;
                    self.contact = Some(self.contact_at(time_s, &pose, &twists));
                }
            }
        }
    }

    /// The contact of the robot at a pose at which it touches something, given its motions in the present period.
    fn contact_at(&self, time_s: f64, pose: &Pose, twists: &[Twist]) -> Contact {
        let footprint = &self.footprint;
        let mut contact = self.world.contact(footprint, time_s, pose, twists);
        if let TouchedBody::Moving { index, .. } = &mut contact.body {
            // The world counts the obstacles that have appeared.
            let states = self.moving_obstacles.states();
            let mut present = states.iter().enumerate().filter(|(_, state)| state.is_some());
            *index = present.nth(*index).map_or(*index, |(index, _)| index);
        }
        contact
    }

    /// True pose at the last sensing.
    pub(super) const fn pose(&self) -> &Pose {
        &self.pose
    }

    /// True motion at the last sensing.
    pub(super) const fn twist(&self) -> &Twist {
        &self.twist
    }

    /// The smallest gap since the sensing before the last one, metres.
    pub(super) fn gap_m(&self) -> f64 {
        self.world.gap_m(&self.footprint, &self.pose).min(self.least_gap_m)
    }

    /// Whether the robot has touched something since then.
    pub(super) fn touches(&self) -> bool {
        let touches_now = || {
            self.world.may_be_nearer(&self.footprint, &self.pose, MEASURED_GAP_M)
                && self.world.gap_m(&self.footprint, &self.pose) <= 0.0
        };
        self.contact.is_some() || touches_now()
    }
}

impl<B: Robot> Robot for SimulatedRobot<B> {
    fn sense(&mut self, time_s: f64) -> SensorData {
        (self.sensed_s, self.time_s) = (self.base.now_s(), time_s);
        let SimulationSettings { sensing_delay_s, stamps_sensing_delay, .. } = self.plant;
        let measured_s = (time_s - sensing_delay_s).max(0.0);
        let stamp_s = if stamps_sensing_delay { measured_s } else { time_s };
        self.world.moving = self.moving_obstacles.discs();
        let scan_s = self.lidar.newest_scan_s(measured_s);
        self.world.seen = if sensing_delay_s > 0.0 || self.plant.lidar.scan_rate_hz.is_some() {
            self.past.record(time_s, self.moving_obstacles.parts());
            Some(self.past.at(scan_s))
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
        let scan_times = (scan_s, stamp_s - (measured_s - scan_s));
        let surroundings = (&self.world, &self.true_poses);
        let lidar = self.lidar.scan(surroundings, &self.faults, time_s, scan_times);
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
        let places = self.moving_obstacles.states();
        let gap_m = self.gap_m();
        let at_present = || self.contact_at(self.time_s, &self.pose, &[self.twist]);
        Some(GroundTruth {
            pose: self.pose,
            twist: self.twist,
            gap_m: Some(gap_m),
            contact: self.contact.or_else(|| (gap_m <= 0.0).then(at_present)),
            moving: places.iter().map(|place| place.as_ref().map(MovingDisc::center)).collect(),
        })
    }

    fn moving_radii_m(&self) -> Vec<f64> {
        self.moving_obstacles.radii()
    }

    fn now_s(&self) -> Option<f64> {
        self.base.now_s()
    }

    fn drive(&mut self, command: &Twist, period_s: f64) -> ControlFlow<()> {
        let truth = (&self.pose, &self.world.moving[..]);
        let command = self.sender.protected(command, &self.faults, self.time_s, truth);
        let flow = self.base.drive(&command, period_s);
        // The world moves on while a real base drives, however long that takes.
        let measured = self.base.now_s().zip(self.sensed_s);
        let elapsed_s = measured.map_or(period_s, |(now_s, sensed_s)| now_s - sensed_s);
        let own = match self.base.ground_truth() {
            Some(truth) => truth.pose,
            None => self.base.sense(self.time_s + elapsed_s).odometry.pose,
        };
        let pose = self.displacement.pose_in_map(&own);
        self.move_others(&pose, elapsed_s);
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
