//! What a cell drives in, and a digest of it: content decides, not names.

use std::sync::Arc;

use crate::digest::BitDigest;
use crate::experiment::barn::{BarnWorld, Course};
use crate::experiment::dynabarn::DynaBarnWorld;
use crate::experiment::missions::Rules;
use crate::geometry::Pose;
use crate::map::OccupancyGrid;
use crate::navigator::Goal;

/// A world to drive in.
#[derive(Clone, Debug)]
pub(super) enum Ground {
    /// A world of BARN.
    Barn(BarnWorld),
    /// A world of `DynaBARN`.
    DynaBarn(DynaBarnWorld),
    /// From a place to another one on a map.
    Route {
        map: Arc<OccupancyGrid>,
        start: Pose,
        goal: Goal,
        people: usize,
        time_limit_s: f64,
    },
    /// A mission drawn by the seed.
    Mission {
        map: Arc<OccupancyGrid>,
        rules: Rules,
    },
}

impl Ground {
    /// A digest of everything of it that decides what happens.
    pub fn digest(&self) -> String {
        let mut digest = BitDigest::default();
        match self {
            Self::Barn(world) => barn(&mut digest, world),
            Self::DynaBarn(world) => dynabarn(&mut digest, world),
            Self::Route {
                map,
                start,
                goal,
                people,
                time_limit_s,
            } => {
                digest.text("route");
                add_map(&mut digest, map);
                add_pose(&mut digest, start);
                digest.real(goal.position.x);
                digest.real(goal.position.y);
                optional(&mut digest, goal.yaw);
                digest.wide(*people as u64);
                digest.real(*time_limit_s);
            }
            Self::Mission { map, rules } => {
                digest.text("mission");
                add_map(&mut digest, map);
                digest.real(rules.least_m);
                digest.real(rules.longest_m);
                digest.wide(rules.most_people as u64);
                digest.real(rules.unmapped_share);
            }
        }
        digest.hex()
    }
}

fn barn(digest: &mut BitDigest, world: &BarnWorld) {
    let Course {
        start,
        goal,
        goal_radius_m,
        time_limit_s,
    } = Course::BARN;
    digest.text("barn");
    add_pose(digest, &start);
    let numbers = [
        goal.x,
        goal.y,
        goal_radius_m,
        time_limit_s,
        world.optimal_time_s,
    ];
    numbers.iter().for_each(|&number| digest.real(number));
    for cylinder in &world.cylinders {
        let numbers = [cylinder.x_m, cylinder.y_m, cylinder.radius_m];
        numbers.iter().for_each(|&number| digest.real(number));
    }
}

fn dynabarn(digest: &mut BitDigest, world: &DynaBarnWorld) {
    digest.text("dynabarn");
    add_pose(digest, &world.start);
    digest.real(world.goal.x);
    digest.real(world.goal.y);
    for body in &world.bodies {
        digest.real(body.radius_m);
        optional(digest, body.script.period_s());
        digest.wide(body.script.keys().len() as u64);
        for (time_s, place) in body.script.keys() {
            [*time_s, place.x, place.y]
                .iter()
                .for_each(|&number| digest.real(number));
        }
    }
}

fn add_map(digest: &mut BitDigest, map: &OccupancyGrid) {
    let frame = map.frame();
    digest.wide(frame.width as u64);
    digest.real(frame.resolution_m);
    add_pose(digest, &frame.origin);
    for &cell in map.cells() {
        digest.word(u32::from(cell as u8));
    }
}

fn add_pose(digest: &mut BitDigest, pose: &Pose) {
    [pose.x, pose.y, pose.yaw]
        .iter()
        .for_each(|&number| digest.real(number));
}

fn optional(digest: &mut BitDigest, number: Option<f64>) {
    digest.word(u32::from(number.is_some()));
    digest.real(number.unwrap_or_default());
}
