//! What a ROS 2 network can send. Messages in CDR are read or rejected, and the same when written and read again. A node that gets
//! arbitrary messages commands within the robot's limits, and its notices are few, short and printable.

use core::fmt::Debug;
use std::io::ErrorKind;

use inbye::local::CpuEngine;
use inbye::ros::msg::{self, Message};
use inbye::ros::node::network::{FromNetwork, ToNetwork, read_frame, write_frame};
use inbye::ros::node::{NodeCore, NodeSettings};

/// Time of the first message, seconds.
const START_S: f64 = 1000.0;
/// Time between two messages, seconds.
const STEP_S: f64 = 0.02;
/// Most ticks of a run.
const MOST_TICKS: usize = 200;
/// Most notices of a run, and the longest one, bytes. A goal has three.
const MOST_NOTICES: usize = 60;
const LONGEST_NOTICE: usize = 2000;

/// A message of every type.
pub fn messages(data: &[u8]) {
    let Some((kind, bytes)) = data.split_first() else {
        return;
    };
    match kind % 11 {
        0 => message::<msg::OccupancyGrid>(bytes),
        1 => message::<msg::LaserScan>(bytes),
        2 => message::<msg::Odometry>(bytes),
        3 => message::<msg::PoseStamped>(bytes),
        4 => message::<msg::TFMessage>(bytes),
        5 => message::<msg::Path>(bytes),
        6 => message::<msg::MarkerArray>(bytes),
        7 => message::<msg::TwistStamped>(bytes),
        8 => to_network(bytes),
        9 => message::<msg::Bool>(bytes),
        _ => message::<msg::DiagnosticArray>(bytes),
    }
}

fn message<M: Message + Debug>(bytes: &[u8]) {
    if let Some(message) = M::from_cdr(bytes) {
        let written = message.to_cdr();
        let again = M::from_cdr(&written).expect("a written message is read");
        assert_eq!(again.to_cdr(), written);
    }
}

/// The frames that the network process reads.
fn to_network(mut bytes: &[u8]) {
    while let Ok((frame, length)) = read_frame::<ToNetwork>(&mut bytes) {
        assert!(length <= 8 << 20);
        let mut written = Vec::new();
        write_frame(&mut written, &frame).expect("a vector takes all");
    }
}

/// A conversation of frames as the control process reads them, with ticks between them.
pub fn conversation(data: &[u8]) {
    let Some((flags, mut rest)) = data.split_first() else {
        return;
    };
    let mut settings = NodeSettings::default();
    settings.odom_is_map = flags & 1 != 0;
    settings.config.local.vx_samples = 3;
    settings.config.local.vtheta_samples = 5;
    let limits = settings.config.robot.limits;
    let engine = Box::new(CpuEngine::single_threaded());
    let mut core = NodeCore::new(settings, engine).expect("valid settings");
    core.operator().arm();
    let (mut now_s, mut ticks, mut notices) = (START_S, 0, 0);
    while ticks < MOST_TICKS {
        let mut ahead = rest;
        let pause_s = match read_frame::<FromNetwork>(&mut ahead) {
            Ok((FromNetwork::Message(message), _)) => {
                core.receive(now_s, &message);
                STEP_S
            }
            // Signs of life stand for time.
            Ok((FromNetwork::Alive { unsent }, _)) => STEP_S * (unsent % 100) as f64,
            Ok(_) => STEP_S,
            Err(error) if error.kind() == ErrorKind::InvalidData => 0.0,
            Err(_) => return,
        };
        // What is no frame is skipped byte by byte.
        rest = if pause_s == 0.0 { &rest[1..] } else { ahead };
        if pause_s == 0.0 {
            continue;
        }
        now_s += pause_s;
        ticks += 1;
        let outgoing = core.tick(now_s, &mut || 0.0);
        if let Some(command) = outgoing.command {
            let is_within = (limits.min_vel_x..=limits.max_vel_x).contains(&command.linear)
                && command.angular.abs() <= limits.max_vel_theta;
            assert!(is_within, "{command:?}");
        }
        for notice in outgoing.notices {
            notices += 1;
            assert!(notice.len() <= LONGEST_NOTICE, "{} bytes: {notice}", notice.len());
            assert!(!notice.chars().any(char::is_control), "{notice:?}");
        }
        assert!(notices <= MOST_NOTICES + 3 * core.stats().goals as usize, "{notices} notices");
    }
}
