//! A simulated robot that talks to a node in messages, tick by tick, without a wire.

use inbye::geometry::{Pose, Twist};
use inbye::local::CpuEngine;
use inbye::map::{OccupancyGrid, UnknownPolicy};
use inbye::ros::msg;
use inbye::ros::node::{Arrived, NodeCore, NodeSettings, Published};
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
        stamp: msg::Time {
            sec: stamp_s as i32,
            nanosec: (stamp_s.fract() * 1e9) as u32,
        },
        frame_id: frame.into(),
    }
}

pub fn pose(pose: &Pose) -> msg::Pose {
    msg::Pose {
        position: msg::Point {
            x: pose.x,
            y: pose.y,
            z: 0.0,
        },
        orientation: msg::Quaternion {
            x: 0.0,
            y: 0.0,
            z: libm::sin(pose.yaw / 2.0),
            w: libm::cos(pose.yaw / 2.0),
        },
    }
}

pub fn goal(x: f64, y: f64) -> msg::PoseStamped {
    msg::PoseStamped {
        header: header("map", 1.0),
        pose: pose(&Pose::new(x, y, 0.0)),
    }
}

pub fn transform(parent: &str, child: &str, place: &Pose) -> msg::TFMessage {
    let msg::Pose {
        position,
        orientation,
    } = pose(place);
    msg::TFMessage {
        transforms: vec![msg::TransformStamped {
            header: header(parent, 1.0),
            child_frame_id: child.into(),
            transform: msg::Transform {
                translation: position,
                rotation: orientation,
            },
        }],
    }
}

/// The goal of most tests: beyond the wall.
pub const GOAL: (f64, f64) = (9.5, 1.5);

pub struct Robot {
    pub core: NodeCore,
    pub pose: Pose,
    pub now_s: f64,
    pub has_scan: bool,
    pub has_odometry: bool,
    /// The frame of its odometry, and where that lies in the map.
    pub frame: &'static str,
    pub frame_at: Pose,
    /// Where the lidar is.
    pub mount: Pose,
    pub notes: Vec<String>,
    pub commands: Vec<Option<Twist>>,
    pub paths: Vec<msg::Path>,
    pub markers: Vec<msg::MarkerArray>,
    world: World,
    twist: Twist,
}

impl Robot {
    pub fn new(odom_is_map: bool) -> Self {
        let settings = NodeSettings {
            odom_is_map,
            ..NodeSettings::default()
        };
        Self {
            core: NodeCore::new(settings, Box::new(CpuEngine::single_threaded())),
            pose: Pose::new(2.0, 1.5, 0.0),
            now_s: 100.0,
            has_scan: true,
            has_odometry: true,
            frame: "map",
            frame_at: Pose::default(),
            mount: Pose::default(),
            notes: Vec::new(),
            commands: Vec::new(),
            paths: Vec::new(),
            markers: Vec::new(),
            world: World::new(grid(29).obstacles(UnknownPolicy::Blocked)),
            twist: Twist::STOP,
        }
    }

    /// One that has map and goal.
    pub fn ready() -> Self {
        let mut robot = Self::new(false);
        robot.hear(&Arrived::Map(map(&grid(29))));
        robot.hear(&Arrived::Goal(goal(GOAL.0, GOAL.1)));
        robot
    }

    pub fn hear(&mut self, message: &Arrived) {
        self.core.hear(self.now_s, message);
    }

    /// A tenth of a second: it senses, hears what to do and does it.
    pub fn step(&mut self) -> Option<Twist> {
        if self.has_odometry {
            self.hear(&Arrived::Odometry(Box::new(self.odometry())));
        }
        if self.has_scan {
            self.hear(&Arrived::Scan(self.scan()));
        }
        let stamp = header("", self.now_s).stamp;
        let Published {
            command,
            path,
            markers,
            notes,
        } = self.core.tick(self.now_s, stamp, &mut || 0.0);
        self.notes.extend(notes);
        self.paths.extend(path);
        self.markers.extend(markers);
        self.commands.push(command);
        self.twist = command.unwrap_or(Twist::STOP);
        self.pose = self.pose.after(&self.twist, 0.1);
        self.now_s += 0.1;
        command
    }

    /// Steps until something holds; how many that took.
    #[track_caller]
    pub fn until(&mut self, most: usize, done: impl Fn(&Self) -> bool) -> usize {
        for steps in 0..most {
            if done(self) {
                return steps;
            }
            self.step();
        }
        panic!(
            "not within {most} steps, at {:?}: {:?}",
            self.pose, self.notes
        );
    }

    /// From the goal of most tests.
    pub fn away_m(&self) -> f64 {
        libm::hypot(self.pose.x - GOAL.0, self.pose.y - GOAL.1)
    }

    pub fn speed(&self) -> f64 {
        self.twist.linear
    }

    pub fn stands(&self) -> bool {
        self.commands.last() == Some(&Some(Twist::STOP))
    }

    pub fn has_said(&self, words: &str) -> bool {
        self.notes.iter().any(|note| note.contains(words))
    }

    fn odometry(&self) -> msg::Odometry {
        let there = self.frame_at.inverse_transform(&self.pose.position());
        let there = Pose::new(there.x, there.y, self.pose.yaw - self.frame_at.yaw);
        let mut message = msg::Odometry {
            header: header(self.frame, self.now_s),
            child_frame_id: "base_link".into(),
            ..msg::Odometry::default()
        };
        message.pose.pose = pose(&there);
        message.twist.twist.linear.x = self.twist.linear;
        message.twist.twist.angular.z = self.twist.angular;
        message
    }

    fn scan(&self) -> msg::LaserScan {
        let lidar = Lidar {
            range_sigma_m: 0.0,
            dropout: 0.0,
            ..Lidar::default()
        };
        let place = self.pose.transform(&self.mount.position());
        let eye = Pose::new(place.x, place.y, self.pose.yaw + self.mount.yaw);
        let mut unused = Pcg64Mcg::seed_from_u64(0);
        let seen = lidar.scan(&self.world, &eye, &mut unused).scan;
        let last = seen.angle(seen.ranges.len() - 1);
        msg::LaserScan {
            header: header("laser", self.now_s),
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
