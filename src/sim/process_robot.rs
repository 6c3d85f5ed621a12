//! A robot in the user's own simulator, which runs in another process.

use core::ops::ControlFlow;

use super::protected_sender::ProtectedSender;
use super::{FaultInjection, Lidar, SimError, Simulation, draw_plant};
use crate::base::ProtectiveAction;
use crate::external::Program;
use crate::external::protocol::{
    GridMessage, LidarMessage, PROTOCOL, Request, Robot as RobotMessage, Simulate, SimulatedState,
    Step,
};
use crate::geometry::{Point, Pose, Twist, wrap_angle};
use crate::map::{MovingDisc, Scan};
use crate::robot::Footprint;
use crate::runtime::{Config, GroundTruth, LidarData, OdometryReading, Robot, SensorData};

use super::World;

/// Largest coordinate of a pose or a moving obstacle of a simulator, and largest radius, metres.
const FARTHEST_M: f64 = 1e6;
/// At the start, odometry and truth may differ by this, metres and radians.
const START_TOLERANCE: f64 = 0.1;

/// The robot of a simulator. The simulator judges contacts; gaps are measured here, at the true poses of the ticks.
pub(super) struct ProcessRobot {
    program: Program,
    sender: ProtectedSender,
    /// All of them are wrong planners.
    faults: Vec<FaultInjection>,
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
        let Lidar { scan_rate_hz, blind_time_s, .. } = config.simulation.lidar;
        let is_mounted = config.simulation.lidar.mount() != Pose::default();
        if is_mounted || scan_rate_hz.is_some() || blind_time_s > 0.0 {
            return Err(failed(
                "it has its own lidar: leave mount_x_m, mount_y_m, mount_yaw_rad, scan_rate_hz and blind_time_s of [simulation.lidar] out"
                    .to_owned(),
            ));
        }
        simulation.check_faults()?;
        let is_of_sender = |fault: &&FaultInjection| fault.is_of_sender();
        if let Some(fault) = simulation.faults.iter().find(|fault| !is_of_sender(fault)) {
            return Err(failed(format!(
                "it has its own robot and sensors, and the fault {fault:?} is of inbye's: leave the fault out, or the simulator"
            )));
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
        check_start(&state).map_err(failed)?;
        Ok(Self {
            program,
            sender: ProtectedSender::new(config, *seed)?,
            faults: simulation.faults.clone(),
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

/// Rejects odometry that does not begin at the true pose: without positioning it is the pose of the robot on its map.
fn check_start(state: &State) -> Result<(), String> {
    let (odometry, truth) = (&state.odometry.pose, &state.true_pose);
    let apart_m = (odometry.position() - truth.position()).norm();
    let apart_rad = wrap_angle(odometry.yaw - truth.yaw).abs();
    if apart_m.max(apart_rad) <= START_TOLERANCE {
        return Ok(());
    }
    let text = |Pose { x, y, yaw }: &Pose| format!("[{x:.3}, {y:.3}, {yaw:.3}]");
    let (odometry, truth) = (text(odometry), text(truth));
    Err(format!(
        "`odometry.pose` is {odometry} at step 0, and `truth.pose` {truth}: odometry must begin at the true pose. Odometry that begins at zero is relative to `start`"
    ))
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
    for (index, &[x, y, radius]) in truth.moving.iter().enumerate() {
        let has_place = x.abs() <= FARTHEST_M && y.abs() <= FARTHEST_M;
        let has_size = radius > 0.0 && radius <= FARTHEST_M;
        if !has_place || !has_size {
            return Err(format!(
                "`truth.moving` {index} is [{x:e}, {y:e}, {radius:e}]: x and y must be within {FARTHEST_M:e} m of the origin, the radius above zero and at most that"
            ));
        }
    }
    if !state.true_pose.is_finite() || !state.true_twist.is_finite() {
        return Err("the true pose is not finite".to_owned());
    }
    state.scan.validate().map_err(|error| format!("`scan`: {error}"))?;
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
        let truth = (&self.state.true_pose, &self.world.moving[..]);
        let command = self.sender.protected(command, &self.faults, self.time_s, truth);
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

#[cfg(all(test, unix))]
mod tests {
    use std::fs;
    use std::sync::Arc;

    use super::*;
    use crate::external::ProgramSettings;
    use crate::map::{GridFrame, OccupancyGrid};
    use crate::navigator::Goal;
    use crate::runtime::Mission;
    use crate::sim::{LidarChange, WrongPlanner};

    const STATE: &str = r#"{"odometry": {"pose": [1, 1, 0], "twist": [0, 0]}, "scan": {"angle_min": -3, "angle_increment": 0.1, "range_max": 9, "ranges": [9]}, "truth": {"pose": [1, 1, 0], "twist": [0, 0], "contact": false, "moving": []}}"#;

    /// A simulator whose robot stands, and which keeps the messages in a file of its folder.
    fn simulator(state: &str) -> (tempfile::TempDir, Config) {
        let folder = tempfile::tempdir().expect("a folder");
        let file = |name: &str| folder.path().join(name).display().to_string();
        fs::write(file("state"), format!("{state}\n")).expect("written");
        let answers = format!(
            "read -r first\necho '{{\"protocol\": 1, \"name\": \"it\", \"wants\": []}}'\n\
             while read -r step; do echo \"$step\" >> {}; cat {}; done\n",
            file("steps"),
            file("state")
        );
        fs::write(file("simulator.sh"), answers).expect("written");
        let mut config = Config::default();
        config.simulator = ProgramSettings {
            command: vec!["sh".to_owned(), file("simulator.sh")],
            ..config.simulator
        };
        (folder, config)
    }

    fn simulation() -> Simulation {
        let frame = GridFrame::new(40, 40, 0.1, Pose::default()).expect("a frame");
        let map = Arc::new(OccupancyGrid::filled(frame, 0));
        let start = Pose::new(1.0, 1.0, 0.0);
        Simulation::new(Mission::new(map, start, Goal::at(Point::new(3.0, 1.0))))
    }

    #[test]
    fn wrong_planner_commands_the_simulator() {
        let (folder, mut config) = simulator(STATE);
        config.collision_monitor.enabled = false;
        for (planner, is_driven) in [(WrongPlanner::Off, false), (WrongPlanner::Old, true)] {
            config.simulation.wrong_planner = planner;
            let mut robot = ProcessRobot::start(&simulation(), &config).expect("a simulator");
            robot.sense(0.0);
            assert!(robot.drive(&Twist::STOP, 0.1).is_continue());
            let steps = fs::read_to_string(folder.path().join("steps")).expect("steps");
            let last: serde_json::Value =
                serde_json::from_str(steps.lines().last().expect("a step")).expect("JSON");
            assert_eq!(last["linear"].as_f64().is_some_and(|linear| linear > 0.0), is_driven);
        }
    }

    #[test]
    fn faults_of_the_simulated_robot_are_refused() {
        let (_folder, config) = simulator(STATE);
        let mut simulation = simulation();
        let (from_s, to_s) = (0.0, 9.0);
        let planner = WrongPlanner::Random;
        simulation.faults = vec![FaultInjection::WrongPlanner { from_s, to_s, planner }];
        assert!(ProcessRobot::start(&simulation, &config).is_ok());
        simulation.faults.push(FaultInjection::LidarOccluded { from_s, to_s });
        let error = ProcessRobot::start(&simulation, &config).err().expect("refused").to_string();
        assert!(error.contains("the fault LidarOccluded"), "{error}");
        let change = LidarChange::EveryNth(0);
        simulation.faults = vec![FaultInjection::Lidar { from_s, to_s, change }];
        for result in [
            ProcessRobot::start(&simulation, &config).err(),
            simulation.robot(&Config::default()).err(),
        ] {
            let error = result.expect("refused").to_string();
            assert_eq!(error, "[faults.0] EveryNth is 0: it must be at least 1");
        }
    }

    #[test]
    fn impossible_moving_obstacles_are_errors_of_the_simulator() {
        for (moving, is_valid) in [
            ("[[1, 2, 0.3]]", true),
            ("[[1, 2, -0.3]]", false),
            ("[[1, 2, 0]]", false),
            ("[[1, 2, 1e9]]", false),
            ("[[1e300, 2, 0.3]]", false),
        ] {
            let (_folder, config) =
                simulator(&STATE.replace(r#""moving": []"#, &format!(r#""moving": {moving}"#)));
            let error = ProcessRobot::start(&simulation(), &config).err();
            let names_it = error
                .as_ref()
                .is_some_and(|error| error.to_string().contains("`truth.moving` 0 is ["));
            assert_eq!((error.is_none(), names_it), (is_valid, !is_valid), "{moving}: {error:?}");
        }
    }
}
