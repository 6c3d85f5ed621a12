//! The surroundings of an emulated base: a world with people, an LD19 lidar, and the true gaps.

use anyhow::{Context, ensure};
use inbye::base::ld19::LidarSettings;
use inbye::base::{InjectedFault, LidarFaultInjector, ScheduledFault};
use inbye::geometry::{Pose, Twist};
use inbye::map::UnknownPolicy;
use inbye::robot::Footprint;
use inbye::runtime::Config;
use inbye::sim::{Lidar, RotatingLidar, World};

use super::arguments::Place;
use super::base::EmulateArguments;
use super::emulated_person::EmulatedPeople;
use super::map_file;
use super::pseudo_terminal::PseudoTerminal;

/// Speeds above which a robot or a person closes a gap by its own motion, m/s.
const CLOSING_M_S: f64 = 0.02;

/// Distance to the goal within which a robot parks, metres: the navigator's default `xy_goal_tolerance`.
const PARKING_M: f64 = 0.25;

/// A robot's place in a world, and its lidar with its port.
pub struct EmulatedSurroundings {
    lidar: RotatingLidar,
    /// The pose of the base's origin on the map.
    origin: Pose,
    /// Place to which the robot is carried; none after that.
    carry_to: Option<Pose>,
    people: EmulatedPeople,
    footprint: Footprint,
    /// None after the lidar was unplugged.
    pair: Option<PseudoTerminal>,
    faults: Vec<ScheduledFault>,
    injector: LidarFaultInjector,
    until_s: f64,
    goal: Option<Place>,
    line: Vec<u8>,
    observed: Observed,
}

/// Refuses options that would do nothing.
fn check_faults(arguments: &EmulateArguments) -> anyhow::Result<()> {
    let is_carried =
        arguments.fault.iter().any(|scheduled| scheduled.fault == InjectedFault::Carried);
    ensure!(
        is_carried || arguments.carry_to.is_none(),
        "--carry-to: nothing carries the robot there: add --fault {}@SECONDS",
        InjectedFault::Carried
    );
    for &ScheduledFault { fault, from_s, to_s } in &arguments.fault {
        ensure!(
            fault != InjectedFault::Carried || arguments.carry_to.is_some(),
            "--fault {fault}: the place is missing: add --carry-to"
        );
        ensure!(
            !fault.is_instant() || to_s.is_infinite(),
            "--fault {fault}@{from_s}..{to_s}: this fault has no end: write {fault}@{from_s}"
        );
        ensure!(
            !fault.is_of_lidar() || arguments.lidar_map.is_some(),
            "--fault {fault}: no lidar is emulated: add --lidar-map"
        );
        let (protocol, with_sensor) = (arguments.kind.protocol, fault.protocols());
        let names: Vec<String> = with_sensor.iter().map(ToString::to_string).collect();
        ensure!(
            with_sensor.contains(&protocol),
            "--fault {fault}: --protocol {protocol} does not report its sensor: use --protocol {}",
            names.join(" or ")
        );
    }
    Ok(())
}

/// What the surroundings have seen of the robot.
#[derive(Clone, Copy, Debug)]
pub struct Observed {
    /// Least gap to anything solid, metres.
    pub min_gap_m: f64,
    /// Whether the robot's own motion closed a gap.
    pub robot_touched: bool,
    /// Whether the motion of a person closed a gap.
    pub person_touched: bool,
    /// Time at which the robot was first within 0.25 m of its goal, seconds.
    pub parking_from_s: Option<f64>,
}

impl EmulatedSurroundings {
    /// Opens the emulated lidar in its world, if requested, where the settings mount it.
    pub fn open(
        arguments: &EmulateArguments,
        mounting: &LidarSettings,
    ) -> anyhow::Result<Option<Self>> {
        check_faults(arguments)?;
        let resolution_m = arguments.resolution.of(arguments.lidar_map.as_deref())?;
        let Some(file) = &arguments.lidar_map else {
            return Ok(None);
        };
        ensure!(
            !mounting.upside_down,
            "--base-config: [lidar] upside_down: the emulated lidar is upright: leave it out"
        );
        let lidar = Lidar::turning()
            .mount_x_m(mounting.mount_x_m)
            .mount_y_m(mounting.mount_y_m)
            .mount_yaw_rad(mounting.mount_yaw_rad);
        let map = map_file::load(file, resolution_m)?;
        let start = arguments.start.as_ref();
        let start = start.context("--lidar-map needs --start: give the robot's pose on the map")?;
        let world = World::new(map.obstacles(UnknownPolicy::Blocked));
        let footprint = Config::default().robot.footprint;
        let places = [("--start", Some(start)), ("--carry-to", arguments.carry_to.as_ref())];
        for (flag, place) in places.iter().filter_map(|(flag, place)| Some((flag, (*place)?))) {
            let is_free = world.gap_to_static_m(&footprint, &place.pose()) > 0.0;
            let (x, y, file) = (place.position.x, place.position.y, file.display());
            ensure!(
                is_free,
                "{flag} {x},{y}: the robot touches a wall of {file} or its edge there: choose a free place"
            );
        }
        Ok(Some(Self {
            lidar: RotatingLidar::new(lidar, world, arguments.seed)?,
            origin: start.pose(),
            carry_to: arguments.carry_to.as_ref().map(Place::pose),
            people: EmulatedPeople::new(arguments.person.clone()),
            footprint,
            pair: Some(PseudoTerminal::open()?),
            faults: arguments.fault.clone(),
            injector: LidarFaultInjector::new(&arguments.fault, arguments.seed),
            until_s: arguments.lidar_until.unwrap_or(f64::INFINITY),
            goal: arguments.goal,
            line: Vec::new(),
            observed: Observed {
                min_gap_m: f64::INFINITY,
                robot_touched: false,
                person_touched: false,
                parking_from_s: None,
            },
        }))
    }

    /// Path of the lidar's port.
    pub fn port(&self) -> &str {
        self.pair.as_ref().map_or("", |pair| &pair.name)
    }

    /// The pose on the map; `pose` is relative to the pose at power-on.
    pub fn map_pose(&self, pose: &Pose) -> Pose {
        self.origin.transform_pose(pose)
    }

    /// What was seen so far.
    pub const fn observed(&self) -> &Observed {
        &self.observed
    }

    /// Advances to a time, seconds, with the base's pose since power-on and its velocity.
    pub fn step(&mut self, now_s: f64, pose: &Pose, twist: &Twist) -> anyhow::Result<()> {
        self.carry(now_s, pose);
        let map_pose = self.map_pose(pose);
        self.people.step(now_s, &map_pose, &self.footprint)?;
        self.lidar.world.moving = self.people.discs();
        self.observe(now_s, &map_pose, twist);
        self.line.clear();
        self.lidar.step(now_s, &map_pose, &mut self.line);
        self.injector.apply(now_s, &mut self.line);
        if now_s >= self.until_s {
            self.pair = None;
        }
        if let Some(pair) = &mut self.pair {
            pair.release_exclusive_lock();
            pair.write(&self.line)?;
        }
        Ok(())
    }

    /// Puts the robot at its other place at the time of that fault.
    fn carry(&mut self, now_s: f64, pose: &Pose) {
        let is_due = |scheduled: &ScheduledFault| {
            scheduled.fault == InjectedFault::Carried && now_s >= scheduled.from_s
        };
        if self.faults.iter().any(is_due)
            && let Some(place) = self.carry_to.take()
        {
            let at_power_on = pose.inverse_transform_pose(&Pose::default());
            self.origin = place.transform_pose(&at_power_on);
        }
    }

    fn observe(&mut self, now_s: f64, pose: &Pose, twist: &Twist) {
        let (world, footprint, observed) = (&self.lidar.world, &self.footprint, &mut self.observed);
        observed.min_gap_m = world.gap_m(footprint, pose).min(observed.min_gap_m);
        observed.robot_touched |= world.gap_to_static_m(footprint, pose) <= 0.0;
        for disc in &world.moving {
            if footprint.gap_to_moving_m(pose, disc) > 0.0 {
                continue;
            }
            let person_m_s = libm::hypot(disc.vx, disc.vy);
            let robot_m_s = footprint.closing_speed_m_s(pose, twist, &disc.center());
            let is_robot = robot_m_s > CLOSING_M_S;
            observed.robot_touched |= is_robot;
            observed.person_touched |= !is_robot && person_m_s > CLOSING_M_S;
        }
        let is_near = |goal: &Place| (goal.position - pose.position()).norm() <= PARKING_M;
        if observed.parking_from_s.is_none() && self.goal.as_ref().is_some_and(is_near) {
            observed.parking_from_s = Some(now_s);
        }
    }
}
