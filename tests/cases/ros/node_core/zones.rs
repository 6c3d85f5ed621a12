//! Masks of Nav2's costmap filters, and speed limits.

use inbye::geometry::Twist;
use inbye::ros::msg;
use inbye::ros::node::IncomingMessage;

use super::robot::{Robot, grid, header, map};

/// A mask of the room with a value in some columns and rows.
fn mask(
    columns: core::ops::Range<usize>,
    rows: core::ops::Range<usize>,
    value: i8,
) -> msg::OccupancyGrid {
    let mut mask = map(&grid(29));
    mask.data.fill(0);
    for row in rows {
        mask.data[row * 60 + columns.start..row * 60 + columns.end].fill(value);
    }
    mask
}

fn info(kind: u8, topic: &str, base: f32, multiplier: f32) -> IncomingMessage {
    IncomingMessage::FilterInfo(msg::CostmapFilterInfo {
        header: header("map", 1.0),
        r#type: kind,
        filter_mask_topic: topic.to_owned(),
        base,
        multiplier,
    })
}

/// The lowest position of the robot while its x is within a range, until it reaches its goal.
fn lowest_y_m(robot: &mut Robot, x: core::ops::Range<f64>) -> f64 {
    let mut lowest_m = f64::INFINITY;
    for _ in 0..900 {
        if robot.has_notice("reached the goal") {
            return lowest_m;
        }
        robot.step();
        if x.contains(&robot.pose.x) {
            lowest_m = lowest_m.min(robot.pose.y);
        }
    }
    panic!("{:?}", robot.notices);
}

/// The wall ends at 3 m; a zone above its end leaves the upper part of the room.
#[test]
fn closed_zone_is_driven_around() {
    let mut robot = Robot::ready();
    robot.receive(&IncomingMessage::KeepoutMask(mask(28..32, 15..20, 100)));
    // The filter's info says no more than the topic.
    robot.receive(&info(msg::CostmapFilterInfo::KEEPOUT, "/keepout_filter_mask", 0.0, 1.0));
    let lowest_m = lowest_y_m(&mut robot, 5.6..6.4);
    assert!(lowest_m > 4.0 + 0.2, "{lowest_m}");
    assert!(robot.core.stats().rejected.is_empty());
    let mut free = Robot::ready();
    let lowest_m = lowest_y_m(&mut free, 5.6..6.4);
    assert!(lowest_m < 4.0, "without the zone {lowest_m}");
}

#[test]
fn zone_that_closes_ahead_of_a_driving_robot_is_driven_around() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.5);
    robot.receive(&IncomingMessage::KeepoutMask(mask(28..32, 15..20, 100)));
    robot.until_published(20, 2);
    let lowest_m = lowest_y_m(&mut robot, 5.6..6.4);
    assert!(lowest_m > 4.0 + 0.2, "{lowest_m}");
}

#[test]
fn speed_mask_limits_the_speed_by_its_info() {
    // Nav2's usual scale: the darker, the slower. And metres per second.
    let percent = info(msg::CostmapFilterInfo::SPEED_PERCENT, "speed_filter_mask", 100.0, -1.0);
    let absolute =
        info(msg::CostmapFilterInfo::SPEED_ABSOLUTE, "/robot/speed_filter_mask", 1.0, -0.01);
    for info in [percent, absolute] {
        let mut robot = Robot::ready();
        robot.receive(&IncomingMessage::SpeedMask(mask(20..30, 1..29, 70)));
        for _ in 0..10 {
            assert_eq!(robot.step(), Some(Twist::STOP));
        }
        assert!(robot.has_notice("without a message on costmap_filter_info"));
        robot.receive(&info);
        let (mut inside, mut outside) = (0.0_f64, 0.0_f64);
        while !robot.has_notice("reached the goal") {
            robot.step();
            let fastest =
                if (4.0..6.0).contains(&robot.pose.x) { &mut inside } else { &mut outside };
            *fastest = fastest.max(robot.speed());
            assert!(robot.commands.len() < 900, "{:?}", robot.notices);
        }
        assert!(inside <= 0.31 && outside > 0.8, "{inside} {outside}");
    }
}

#[test]
fn speed_limit_holds_everywhere_until_it_is_lifted() {
    let limit = |speed_limit: f64, percentage: bool| {
        IncomingMessage::SpeedLimit(msg::SpeedLimit {
            header: header("map", 1.0),
            percentage,
            speed_limit,
        })
    };
    let mut robot = Robot::ready();
    robot.receive(&limit(40.0, true));
    let mut fastest = 0.0_f64;
    for _ in 0..40 {
        robot.step();
        fastest = fastest.max(robot.speed());
    }
    assert!((0.3..=0.4001).contains(&fastest), "{fastest}");
    robot.receive(&limit(0.2, false));
    for _ in 0..8 {
        robot.step();
    }
    assert!(robot.speed() <= 0.2001, "{}", robot.speed());
    robot.receive(&limit(0.0, false));
    robot.until(600, |robot| robot.speed() > 0.8);
    robot.receive(&limit(-1.0, false));
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    assert!(robot.has_notice("its speed_limit is -1"));
}

#[test]
fn message_of_a_goal_in_a_closed_zone_names_the_zones() {
    let mut robot = Robot::ready();
    robot.receive(&IncomingMessage::KeepoutMask(mask(45..50, 5..10, 100)));
    robot.step();
    let words = "; the closed zones of keepout_filter_mask count as obstacles";
    assert!(robot.has_notice("aborted the goal: GOAL_OCCUPIED"), "{:?}", robot.notices);
    assert!(robot.has_notice(words), "{:?}", robot.notices);
}

/// A wrong origin would take the protection away: the robot waits, as without a map.
#[test]
fn mask_without_effect_on_the_map_stops_the_robot_until_a_usable_one_comes() {
    let mut beside = mask(28..32, 15..20, 100);
    beside.info.origin.position.x = -20.0;
    for (unusable, words) in [
        (IncomingMessage::KeepoutMask(beside.clone()), "does not lie on the map"),
        (IncomingMessage::KeepoutMask(mask(28..32, 15..20, 99)), "no cell of the map is closed"),
        (IncomingMessage::SpeedMask(beside), "does not lie on the map"),
    ] {
        let is_keepout = matches!(unusable, IncomingMessage::KeepoutMask(_));
        let mut robot = Robot::ready();
        let speed = info(msg::CostmapFilterInfo::SPEED_PERCENT, "speed_filter_mask", 100.0, -1.0);
        robot.receive(&speed);
        robot.until(50, |robot| robot.speed() > 0.5);
        robot.receive(&unusable);
        robot.until(20, Robot::stands);
        for _ in 0..20 {
            assert_eq!(robot.step(), Some(Twist::STOP));
        }
        assert!(robot.has_notice(words), "{words}: {:?}", robot.notices);
        assert!(robot.status("inbye: inputs").1.contains(words));
        robot.receive(&if is_keepout {
            IncomingMessage::KeepoutMask(mask(28..32, 15..20, 100))
        } else {
            IncomingMessage::SpeedMask(mask(28..32, 15..20, 70))
        });
        let lowest_m = lowest_y_m(&mut robot, 5.6..6.4);
        assert_eq!(lowest_m > 4.0 + 0.2, is_keepout, "{lowest_m}");
    }
}

/// A fleet manager sends them to end a closure.
#[test]
fn masks_that_are_free_everywhere_lift_the_zones() {
    let mut robot = Robot::ready();
    robot.receive(&info(msg::CostmapFilterInfo::SPEED_PERCENT, "speed_filter_mask", 100.0, -1.0));
    robot.receive(&IncomingMessage::KeepoutMask(mask(28..32, 15..20, 100)));
    robot.receive(&IncomingMessage::SpeedMask(mask(10..14, 15..20, 70)));
    robot.step();
    robot.receive(&IncomingMessage::KeepoutMask(mask(0..0, 0..0, 0)));
    robot.receive(&IncomingMessage::SpeedMask(mask(0..0, 0..0, 0)));
    let lowest_m = lowest_y_m(&mut robot, 5.6..6.4);
    assert!(lowest_m < 4.0 + 0.2, "{lowest_m}");
    let is_refused = robot.notices.iter().any(|notice| notice.contains("cannot be used"));
    assert!(!is_refused, "{:?}", robot.notices);
}

#[test]
fn unusable_masks_and_infos_are_rejected_or_stop_the_robot() {
    let mut robot = Robot::ready();
    robot.receive(&info(3, "binary_filter_mask", 0.0, 1.0));
    robot.receive(&info(msg::CostmapFilterInfo::KEEPOUT, "/other_mask", 0.0, 1.0));
    robot.receive(&info(msg::CostmapFilterInfo::SPEED_PERCENT, "speed_filter_mask", f32::NAN, 1.0));
    assert_eq!(robot.core.stats().rejected["costmap_filter_info"], 3);
    let mut elsewhere = mask(28..32, 15..20, 100);
    elsewhere.header.frame_id = "floor_2".to_owned();
    robot.receive(&IncomingMessage::KeepoutMask(elsewhere));
    assert_eq!(robot.step(), Some(Twist::STOP));
    for words in
        ["its type is 3", "`/other_mask`", "base or multiplier", "the mask on keepout_filter_mask"]
    {
        assert!(robot.has_notice(words), "{words}: {:?}", robot.notices);
    }
}
