//! A robot in the user's own simulator, which runs in another process.

use core::ops::ControlFlow;

use super::protected_sender::ProtectedSender;
use super::{Lidar, SimError, Simulation, draw_plant};
use crate::base::ProtectiveAction;
use crate::external::Program;
use crate::external::protocol::{
    GridMessage, LidarMessage, PROTOCOL, Request, Robot as RobotMessage, Simulate, SimulatedState,
    Step,
};
use crate::geometry::{Point, Pose, Twist};
use crate::map::{MovingDisc, Scan};
use crate::robot::Footprint;
use crate::runtime::{Config, GroundTruth, LidarData, OdometryReading, Robot, SensorData};

use super::World;

/// Largest coordinate of a pose of a simulator, metres.
const FARTHEST_M: f64 = 1e6;

/// The robot of a simulator. The simulator judges contacts; gaps are measured here, at the true poses of the ticks.
pub(super) struct ProcessRobot {
    program: Program,
    sender: ProtectedSender,
    footprint: Footprint,
    world: World,
    /// Time of the last sensing, seconds; the moving obstacles of the world are those of that time.
    time_s: f64,
    state: State,
    radii_m: Vec<f64>,
    /// Number of steps so far.
    steps: u64,
    fault: Option<String>,
}

/// The last state that the simulator sent.
struct State {
    odometry: OdometryReading,
    scan: Scan,
    pose: Option<Pose>,
    true_pose: Pose,
    true_twist: Twist,
    touches: bool,
    moving: Vec<Point>,
}

impl ProcessRobot {
    /// Starts the simulator of the settings in a world.
    ///
    /// # Errors
    /// When it cannot be started, or its first answers are wrong.
    pub fn start(simulation: &Simulation, config: &Config) -> Result<Self, SimError> {
        let Simulation { mission, seed, .. } = simulation;
        let failed = |reason| SimError::Simulator { program: config.simulator.to_string(), reason };
        let own = simulation.moving_obstacles.len();
        if own > 0 {
            return Err(failed(format!(
                "it has its own moving obstacles, and the {own} of this mission are not in its world: leave them out"
            )));
        }
        // The scan of a step is in the robot's frame, and of that step.
        let Lidar { scan_rate_hz, .. } = config.simulation.lidar;
        if config.simulation.lidar.mount() != Pose::default() || scan_rate_hz.is_some() {
            return Err(failed(
                "it has its own lidar: leave mount_x_m, mount_y_m, mount_yaw_rad and scan_rate_hz of [simulation.lidar] out"
                    .to_owned(),
            ));
        }
        let obstacles = simulation.true_obstacles(config);
        let lidar = draw_plant(config, *seed).lidar;
        let first = Request::Simulate(Box::new(Simulate {
            protocol: PROTOCOL,
            period_s: config.local.control_period_s,
            seed: *seed,
            robot: RobotMessage::new(&config.robot.footprint, &config.robot.limits),
            track_width_m: config.robot.track_width_m,
            start: mission.start,
            goal: mission.goal,
            lidar: LidarMessage {
                beams: lidar.beams,
                field_of_view_rad: lidar.field_of_view_rad,
                range_max_m: lidar.range_max_m,
                range_sigma_m: lidar.range_sigma_m,
            },
            obstacles: GridMessage::of_grid(&obstacles),
        }));
        let mut program = Program::start(&config.simulator, &first).map_err(failed)?;
        let (state, radii_m) = step(&mut program, 0, &Twist::STOP, 0.0).map_err(failed)?;
        Ok(Self {
            program,
            sender: ProtectedSender::new(config)?,
            footprint: config.robot.footprint.clone(),
            world: World::new(obstacles),
            time_s: 0.0,
            state,
            radii_m,
            steps: 1,
            fault: None,
        })
    }
}

/// Simulates the step of a number, a command for a time, seconds. Returns the state after it, and the radii of the moving obstacles.
fn step(
    program: &mut Program,
    number: u64,
    command: &Twist,
    period_s: f64,
) -> Result<(State, Vec<f64>), String> {
    let Twist { linear, angular } = *command;
    let request = Request::Step(Step { step: number, period_s, linear, angular });
    let answer = program.ask(&request, program.timeout);
    let state: SimulatedState = answer.map_err(|error| program.reason(error))?;
    let pose = |[x, y, yaw]: [f64; 3]| Pose::new(x, y, yaw);
    let twist = |[linear, angular]: [f64; 2]| Twist::new(linear, angular);
    let SimulatedState { odometry, scan, pose: own, truth, .. } = state;
    let radii_m = truth.moving.iter().map(|&[_, _, radius]| radius).collect();
    let state = State {
        odometry: OdometryReading { pose: pose(odometry.pose), twist: twist(odometry.twist) },
        scan: scan.into_scan(),
        pose: own.map(pose),
        true_pose: pose(truth.pose),
        true_twist: twist(truth.twist),
        touches: truth.contact,
        moving: truth.moving.iter().map(|&[x, y, _]| Point::new(x, y)).collect(),
    };
    let poses = [
        ("odometry.pose", Some(state.odometry.pose)),
        ("pose", state.pose),
        ("truth.pose", Some(state.true_pose)),
    ];
    for (name, pose) in poses {
        let far_m = pose.map_or(0.0, |pose| pose.x.abs().max(pose.y.abs()));
        if far_m.is_finite() && far_m > FARTHEST_M {
            return Err(format!(
                "`{name}` is {far_m:e} m from the origin; at most {FARTHEST_M:e} m are allowed"
            ));
        }
    }
    if !state.true_pose.is_finite() || !state.true_twist.is_finite() {
        return Err("the true pose is not finite".to_owned());
    }
    if !state.scan.is_valid() {
        return Err(
            "`scan`: origin and angle_min must be finite, angle_increment and range_max above zero"
                .to_owned(),
        );
    }
    Ok((state, radii_m))
}

impl Robot for ProcessRobot {
    fn sense(&mut self, time_s: f64) -> SensorData {
        self.time_s = time_s;
        let disc = |(center, &radius): (&Point, &f64)| MovingDisc {
            x: center.x,
            y: center.y,
            radius,
            vx: 0.0,
            vy: 0.0,
        };
        self.world.moving = self.state.moving.iter().zip(&self.radii_m).map(disc).collect();
        let State { odometry, scan, pose, .. } = &self.state;
        let lidar = LidarData::Scan(scan.clone());
        self.sender.update(time_s, (&odometry.twist, time_s), &lidar);
        SensorData {
            odometry: *odometry,
            odometry_s: time_s,
            lidar: Some(lidar),
            pose: *pose,
            pose_s: None,
            sent: Some(self.sender.sent),
        }
    }

    fn ground_truth(&self) -> Option<GroundTruth> {
        let State { true_pose, true_twist, touches, ref moving, .. } = self.state;
        let world = &self.world;
        let gap_m = world.gap_m(&self.footprint, &true_pose);
        let contact = || world.contact(&self.footprint, self.time_s, &true_pose, &[true_twist]);
        Some(GroundTruth {
            pose: true_pose,
            twist: true_twist,
            gap_m: Some(if touches { gap_m.min(0.0) } else { gap_m }),
            contact: (touches || gap_m <= 0.0).then(contact),
            moving: moving.iter().copied().map(Some).collect(),
        })
    }

    fn moving_radii_m(&self) -> Vec<f64> {
        self.radii_m.clone()
    }

    fn drive(&mut self, command: &Twist, period_s: f64) -> ControlFlow<()> {
        let command = self.sender.protected(command, self.time_s);
        let number = self.steps;
        self.steps += 1;
        match step(&mut self.program, number, &command, period_s) {
            Ok((state, radii_m)) if radii_m.len() == self.radii_m.len() => {
                self.state = state;
                ControlFlow::Continue(())
            }
            Ok(_) => self.stop("the number of moving obstacles has changed"),
            Err(reason) => self.stop(&reason),
        }
    }

    fn protective_action(&self) -> ProtectiveAction {
        self.sender.action()
    }

    fn fault(&self) -> Option<String> {
        self.fault.clone()
    }

    fn finish(&mut self) -> ControlFlow<()> {
        if self.fault.is_some() {
            return ControlFlow::Break(());
        }
        match self.program.finish::<SimulatedState>() {
            Ok(()) => ControlFlow::Continue(()),
            Err(reason) => self.stop(&reason),
        }
    }
}

impl ProcessRobot {
    fn stop(&mut self, reason: &str) -> ControlFlow<()> {
        self.fault = Some(format!("the simulator failed: {reason}"));
        ControlFlow::Break(())
    }
}
