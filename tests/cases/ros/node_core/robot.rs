//! A simulated robot that exchanges messages with a node, tick by tick, without DDS.

use std::ops::Range;
use std::thread;
use std::time::Duration;

use inbye::geometry::{Pose, Twist};
use inbye::local::CpuEngine;
use inbye::map::{Cell, OccupancyGrid, UnknownPolicy};
use inbye::ros::msg;
use inbye::ros::node::{ActionUpdate, IncomingMessage, NodeCore, NodeSettings, Outgoing};
use inbye::sim::{Lidar, World};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

/// A room of 12 by 6 m with a wall half across it, cells of 0.2 m.
pub fn rows(wall_at: usize) -> Vec<String> {
    let row = |row: usize| {
        let cell = |column: usize| {
            let border = row == 0 || row == 29 || column == 0 || column == 59;
            let wall = (wall_at..wall_at + 2).contains(&column) && row >= 15;
            if border || wall { '#' } else { '.' }
        };
        (0..60).map(cell).collect()
    };
    (0..30).map(row).collect()
}

pub fn grid(wall_at: usize) -> OccupancyGrid {
    let rows = rows(wall_at);
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    OccupancyGrid::from_rows(&rows, 0.2, Pose::default()).expect("a map")
}

pub fn map(grid: &OccupancyGrid) -> msg::OccupancyGrid {
    msg::OccupancyGrid {
        header: header("map", 1.0),
        info: msg::MapMetaData {
            resolution: 0.2,
            width: 60,
            height: 30,
            ..msg::MapMetaData::default()
        },
        data: grid.cells().to_vec(),
    }
}

pub fn header(frame: &str, stamp_s: f64) -> msg::Header {
    msg::Header {
        stamp: msg::Time { sec: stamp_s as i32, nanosec: (stamp_s.fract() * 1e9) as u32 },
        frame_id: frame.into(),
    }
}

pub fn goal(x: f64, y: f64) -> msg::PoseStamped {
    msg::PoseStamped { header: header("map", 1.0), pose: msg::Pose::from(&Pose::new(x, y, 0.0)) }
}

pub fn transform(parent: &str, child: &str, pose: &Pose, stamp_s: f64) -> msg::TFMessage {
    msg::TFMessage {
        transforms: vec![msg::TransformStamped {
            header: header(parent, stamp_s),
            child_frame_id: child.into(),
            transform: msg::Transform::from(pose),
        }],
    }
}

/// Where a path crosses a line at this x: the y of each crossing.
pub fn crossings_m(path: &msg::Path, x: f64) -> Vec<f64> {
    let crossing = |step: &[msg::PoseStamped]| {
        let [from, to] = [&step[0].pose.position, &step[1].pose.position];
        let share = (x - from.x) / (to.x - from.x);
        (0.0..=1.0).contains(&share).then_some(from.y + share * (to.y - from.y))
    };
    path.poses.windows(2).filter_map(crossing).collect()
}

/// The goal of most tests: beyond the wall.
pub const GOAL: (f64, f64) = (9.5, 1.5);

pub struct Robot {
    pub core: NodeCore,
    pub pose: Pose,
    pub now_s: f64,
    /// Time of a step, seconds.
    pub step_s: f64,
    pub has_scan: bool,
    pub has_odometry: bool,
    /// Share of its speed that the odometry reports.
    pub speed_share: f64,
    /// Whether `tf` gives the pose of the odometry's frame in the map at each step.
    pub has_transform: bool,
    /// Ages of the stamps on arrival, seconds; negative for a clock that is ahead.
    pub scan_late_s: f64,
    pub odometry_late_s: f64,
    pub transform_late_s: f64,
    /// The frame of the odometry, and its pose in the map.
    pub frame: &'static str,
    pub frame_at: Pose,
    /// The pose of the lidar on the robot.
    pub mount: Pose,
    pub notices: Vec<String>,
    pub commands: Vec<Option<Twist>>,
    pub paths: Vec<msg::Path>,
    pub markers: Vec<msg::MarkerArray>,
    pub diagnostics: Vec<msg::DiagnosticArray>,
    /// What the node published on `tf`.
    pub transforms: Vec<msg::TFMessage>,
    pub updated_maps: Vec<msg::OccupancyGrid>,
    pub actions: Vec<ActionUpdate>,
    pub states: Vec<msg::LifecycleAnswer>,
    world: World,
    twist: Twist,
}

impl Robot {
    /// A robot that an operator has armed.
    pub fn new(odom_is_map: bool) -> Self {
        let robot = Self::unarmed(odom_is_map);
        robot.core.operator().arm();
        robot
    }

    pub fn unarmed(odom_is_map: bool) -> Self {
        let mut settings = NodeSettings::default();
        settings.odom_is_map = odom_is_map;
        Self::with_settings(settings)
    }

    pub fn with_settings(settings: NodeSettings) -> Self {
        let engine = Box::new(CpuEngine::single_threaded());
        Self {
            core: NodeCore::new(settings, engine).expect("valid settings"),
            pose: Pose::new(2.0, 1.5, 0.0),
            now_s: 100.0,
            step_s: 0.1,
            has_scan: true,
            has_odometry: true,
            speed_share: 1.0,
            has_transform: false,
            scan_late_s: 0.0,
            odometry_late_s: 0.0,
            transform_late_s: 0.0,
            frame: "map",
            frame_at: Pose::default(),
            mount: Pose::default(),
            notices: Vec::new(),
            commands: Vec::new(),
            paths: Vec::new(),
            markers: Vec::new(),
            diagnostics: Vec::new(),
            transforms: Vec::new(),
            updated_maps: Vec::new(),
            actions: Vec::new(),
            states: Vec::new(),
            world: World::new(grid(29).obstacles(UnknownPolicy::Blocked)),
            twist: Twist::STOP,
        }
    }

    /// Takes the wall across the room away.
    pub fn without_wall(&mut self) {
        self.rebuild(29..31, 1..15, false);
    }

    /// Sets cells of the world.
    pub fn rebuild(&mut self, columns: Range<i32>, rows: Range<i32>, blocked: bool) {
        let mut world = grid(29).obstacles(UnknownPolicy::Blocked);
        for row in rows {
            columns.clone().for_each(|column| world.set(Cell::new(column, row), blocked));
        }
        self.world = World::new(world);
    }

    /// An armed robot with map, goal and the lidar's place.
    pub fn ready() -> Self {
        Self::new(false).with_goal()
    }

    /// An armed robot with map and the lidar's place.
    pub fn with_map() -> Self {
        let mut robot = Self::new(false);
        robot.publish_mount();
        robot.receive(&IncomingMessage::Map(map(&grid(29))));
        robot
    }

    /// The robot with map, goal and the lidar's place.
    pub fn with_goal(mut self) -> Self {
        self.publish_mount();
        self.receive(&IncomingMessage::Map(map(&grid(29))));
        self.receive(&IncomingMessage::Goal(goal(GOAL.0, GOAL.1)));
        self
    }

    /// Publishes the lidar's pose on the robot.
    pub fn publish_mount(&mut self) {
        let mount = transform("base_link", "laser", &self.mount, 1.0);
        self.receive(&IncomingMessage::StaticTransforms(mount));
    }

    pub fn receive(&mut self, message: &IncomingMessage) {
        self.core.receive(self.now_s, message);
    }

    /// Simulates the time of a step: publishes odometry and scan, and executes the command.
    pub fn step(&mut self) -> Option<Twist> {
        if self.has_transform {
            let stamp_s = self.now_s - self.transform_late_s;
            let message = transform("map", self.frame, &self.frame_at, stamp_s);
            self.receive(&IncomingMessage::Transforms(message));
        }
        if self.has_odometry {
            self.receive(&IncomingMessage::Odometry(Box::new(self.odometry())));
        }
        if self.has_scan {
            self.receive(&IncomingMessage::Scan(self.scan()));
        }
        let Outgoing {
            command,
            path,
            markers,
            transforms,
            updated_map,
            diagnostics,
            action,
            states,
            notices,
            ..
        } = self.core.tick(self.now_s, &mut || 0.0);
        self.updated_maps.extend(updated_map);
        self.actions.extend(action);
        self.states.extend(states);
        self.transforms.extend(transforms);
        self.diagnostics.extend(diagnostics);
        self.notices.extend(notices);
        self.paths.extend(path);
        self.markers.extend(markers);
        self.commands.push(command);
        self.twist = command.unwrap_or(Twist::STOP);
        self.pose = self.pose.after(&self.twist, self.step_s);
        self.now_s += self.step_s;
        command
    }

    /// Time passes without a tick; the base stands by its own time-out.
    pub fn pause(&mut self, time_s: f64) {
        self.now_s += time_s;
        self.twist = Twist::STOP;
    }

    /// Steps until a condition holds. Returns the number of steps.
    #[track_caller]
    pub fn until(&mut self, max: usize, done: impl Fn(&Self) -> bool) -> usize {
        self.until_after(max, done, |_| ())
    }

    /// Steps until a condition holds, with time for the threads that plan: more after each step, so that a busy machine passes too.
    #[track_caller]
    pub fn until_planned(&mut self, max: usize, done: impl Fn(&Self) -> bool) {
        let wait = |steps: usize| thread::sleep(Duration::from_millis(1 << steps.min(9)));
        self.until_after(max, done, wait);
    }

    #[track_caller]
    fn until_after(
        &mut self,
        max: usize,
        done: impl Fn(&Self) -> bool,
        after: impl Fn(usize),
    ) -> usize {
        for steps in 0..max {
            if done(self) {
                return steps;
            }
            self.step();
            after(steps);
        }
        panic!("not within {max} steps, at {:?}: {:?}", self.pose, self.notices);
    }

    /// Steps without a stop until a number of paths is published.
    #[track_caller]
    pub fn until_published(&mut self, max: usize, paths: usize) {
        self.until_planned(max, |robot| {
            assert!(robot.speed() > 0.1, "{:?}", robot.notices);
            robot.paths.len() >= paths
        });
    }

    /// Receives a map with five more rows of unknown cells, and steps until its path is published.
    #[track_caller]
    pub fn receive_grown_map(&mut self) {
        let mut grown = map(&grid(29));
        grown.info.height += 5;
        grown.data.extend([-1; 5 * 60]);
        self.receive(&IncomingMessage::Map(grown));
        self.until_published(20, 2);
    }

    /// Distance to the goal of most tests.
    pub fn away_m(&self) -> f64 {
        libm::hypot(self.pose.x - GOAL.0, self.pose.y - GOAL.1)
    }

    pub fn speed(&self) -> f64 {
        self.twist.linear
    }

    pub fn stands(&self) -> bool {
        self.commands.last() == Some(&Some(Twist::STOP))
    }

    /// Level and message of the latest status with a name.
    pub fn status(&self, name: &str) -> (msg::Byte, &str) {
        let latest = self.diagnostics.last().expect("diagnostics");
        let status = latest.status.iter().find(|status| status.name == name);
        status.map(|status| (status.level, &*status.message)).expect("a status")
    }

    pub fn has_notice(&self, words: &str) -> bool {
        self.notices.iter().any(|notice| notice.contains(words))
    }

    fn odometry(&self) -> msg::Odometry {
        let position = self.frame_at.inverse_transform(&self.pose.position());
        let in_frame = Pose::new(position.x, position.y, self.pose.yaw - self.frame_at.yaw);
        let mut message = msg::Odometry {
            header: header(self.frame, self.now_s - self.odometry_late_s),
            child_frame_id: "base_link".into(),
            ..msg::Odometry::default()
        };
        message.pose.pose = msg::Pose::from(&in_frame);
        message.twist.twist.linear.x = self.speed_share * self.twist.linear;
        message.twist.twist.angular.z = self.speed_share * self.twist.angular;
        message
    }

    pub fn scan(&self) -> msg::LaserScan {
        let lidar = Lidar::default().range_sigma_m(0.0).dropout(0.0);
        let position = self.pose.transform(&self.mount.position());
        let lidar_pose = Pose::new(position.x, position.y, self.pose.yaw + self.mount.yaw);
        let mut unused = Pcg64Mcg::seed_from_u64(0);
        let seen = lidar.scan(&self.world, &lidar_pose, &mut unused).scan;
        let last = seen.angle(seen.ranges.len() - 1);
        msg::LaserScan {
            header: header("laser", self.now_s - self.scan_late_s),
            angle_min: seen.angle_min as f32,
            angle_max: last as f32,
            angle_increment: seen.angle_increment as f32,
            range_min: 0.05,
            range_max: seen.range_max as f32,
            ranges: seen.ranges.iter().map(|range| *range as f32).collect(),
            ..msg::LaserScan::default()
        }
    }
}
