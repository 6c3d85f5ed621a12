//! Drives of a simulated base through the layer: whatever is commanded, it touches no obstacle that stands.

use core::f64::consts::PI;

use inbye::base::{CollisionMonitorSettings, ProtectiveLayer};
use inbye::geometry::{Pose, Twist};
use inbye::map::{GridFrame, ObstacleGrid, TimedScan};
use inbye::robot::{Limits, TrackedDrive};
use inbye::runtime::Robot;
use inbye::sim::{DriveDynamics, Lidar, OdometryNoise, SimBase, World};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::checks::{body, limits};

const PERIOD_S: f64 = 0.05;
const RESOLUTION_M: f64 = 0.1;
/// Cells of a side.
const SIDE: i32 = 100;

/// A room of 10 m with scattered blocks, none of them near its middle.
fn random_room(rng: &mut Pcg64Mcg) -> World {
    let frame = GridFrame::new(SIDE, SIDE, RESOLUTION_M, Pose::default()).expect("a frame");
    let density = rng.random_range(0.0..0.03);
    let blocked = (0..frame.len() as i32).map(|index| {
        let (x, y) = (index % SIDE, index / SIDE);
        let is_edge = x == 0 || y == 0 || x == SIDE - 1 || y == SIDE - 1;
        let is_middle = (x - SIDE / 2).abs() < 8 && (y - SIDE / 2).abs() < 8;
        is_edge || (!is_middle && rng.random_bool(density))
    });
    World::new(ObstacleGrid::new(frame, blocked.collect()))
}

/// A base and its sender.
struct Drive {
    world: World,
    lidar: Lidar,
    base: SimBase,
    layer: Option<ProtectiveLayer>,
    sent: Twist,
    rng: Pcg64Mcg,
    now_s: f64,
    least_gap_m: f64,
    travelled_m: f64,
}

impl Drive {
    fn new(
        world: World,
        start: Pose,
        dynamics: DriveDynamics,
        layer: Option<ProtectiveLayer>,
    ) -> Self {
        let drive = TrackedDrive { track_width_m: 0.45 };
        let noise = OdometryNoise::none();
        let base = SimBase::new(drive, limits(), dynamics, noise, start, 0).expect("a base");
        // Each obstacle has to be shown: a cell of 0.1 m within 1.5 m.
        let lidar = Lidar::default().beams(720).range_sigma_m(0.0).dropout(0.0);
        Self {
            world,
            lidar,
            base,
            layer,
            sent: Twist::STOP,
            rng: Pcg64Mcg::seed_from_u64(1),
            now_s: 0.0,
            least_gap_m: f64::INFINITY,
            travelled_m: 0.0,
        }
    }

    /// One period with a target.
    fn tick(&mut self, target: &Twist) {
        let measured = self.base.sense(self.now_s).odometry.twist;
        let scan = self.lidar.scan(&self.world, self.base.pose(), &mut self.rng).scan;
        if let Some(layer) = &mut self.layer {
            layer.update_motion(&measured, self.now_s);
            layer.update_scan(&TimedScan::from_scan(&scan, self.now_s, 0.0), self.now_s);
            let (command, _) = layer.limit(target, &self.sent, self.now_s);
            self.sent = layer.ramp(&command, &self.sent, PERIOD_S.into());
        } else {
            self.sent = *target;
        }
        self.base.send(&self.sent).expect("a finite command");
        for _ in 0..5 {
            let before = *self.base.pose();
            self.base.step(PERIOD_S / 5.0);
            let pose = self.base.pose();
            self.least_gap_m = self.least_gap_m.min(self.world.gap_m(&body(), pose));
            self.travelled_m += (pose.position() - before.position()).norm();
        }
        self.now_s += PERIOD_S;
    }
}

fn protected(delay_s: f64, limits: &Limits) -> ProtectiveLayer {
    let settings = CollisionMonitorSettings::default();
    let mut layer = ProtectiveLayer::new(settings, &body(), *limits, PERIOD_S).expect("a layer");
    layer.set_stopping(delay_s, -limits.decel_lim_x);
    layer.arm();
    layer
}

fn random_twist(rng: &mut Pcg64Mcg) -> Twist {
    Twist::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0))
}

fn middle(rng: &mut Pcg64Mcg) -> Pose {
    Pose::new(5.0, 5.0, rng.random_range(-PI..PI))
}

#[test]
fn no_constant_command_touches_a_standing_obstacle() {
    let mut contacts_without = 0;
    for seed in 0..120 {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let (world, start, command) =
            (random_room(&mut rng), middle(&mut rng), random_twist(&mut rng));
        let (delay_s, lag_s) = (rng.random_range(0.0..0.2), rng.random_range(0.0..0.15));
        let dynamics = DriveDynamics::ideal().command_delay_s(delay_s).motor_lag_s(lag_s);
        let run = |layer: Option<ProtectiveLayer>| {
            let mut drive = Drive::new(world.clone(), start, dynamics, layer);
            (0..160).for_each(|_| drive.tick(&command));
            drive.least_gap_m
        };
        let gap_m = run(Some(protected(delay_s + lag_s, &limits())));
        assert!(gap_m > 0.0, "seed {seed}: gap {gap_m} with {command:?}");
        contacts_without += u32::from(run(None) <= 0.0);
    }
    assert!(contacts_without > 60, "{contacts_without} contacts without the layer");
}

#[test]
fn no_changing_command_touches_a_standing_obstacle() {
    for seed in 0..60 {
        let mut rng = Pcg64Mcg::seed_from_u64(1000 + seed);
        let (world, start) = (random_room(&mut rng), middle(&mut rng));
        let dynamics = DriveDynamics::ideal().command_delay_s(0.1).motor_lag_s(0.05);
        let layer = protected(0.15, &limits());
        let mut drive = Drive::new(world, start, dynamics, Some(layer));
        let mut command = Twist::STOP;
        for tick in 0..300 {
            if tick % 13 == 0 {
                command = random_twist(&mut rng);
            }
            drive.tick(&command);
        }
        assert!(drive.least_gap_m > 0.0, "seed {seed}: gap {}", drive.least_gap_m);
    }
}

#[test]
fn corridor_of_one_metre_is_driven_and_its_end_is_not_touched() {
    let frame = GridFrame::new(200, 12, RESOLUTION_M, Pose::default()).expect("a frame");
    let blocked = (0..frame.len() as i32).map(|index| {
        let (x, y) = (index % 200, index / 200);
        x == 0 || x == 199 || y == 0 || y == 11
    });
    let world = World::new(ObstacleGrid::new(frame, blocked.collect()));
    let dynamics = DriveDynamics::ideal().command_delay_s(0.03).motor_lag_s(0.05);
    let layer = protected(0.08, &limits());
    let mut drive = Drive::new(world, Pose::new(1.0, 0.6, 0.0), dynamics, Some(layer));
    (0..480).for_each(|_| drive.tick(&Twist::new(1.0, 0.0)));
    assert!(drive.travelled_m > 15.0, "{} m", drive.travelled_m);
    assert!((0.0..0.15).contains(&drive.least_gap_m), "{} m", drive.least_gap_m);
    // At an angle to the walls it slides along neither of them into contact.
    let turned = Pose::new(1.0, 0.6, 0.1);
    let mut drive = Drive::new(drive.world, turned, dynamics, Some(protected(0.08, &limits())));
    (0..360).for_each(|_| drive.tick(&Twist::new(1.0, 0.0)));
    assert!(drive.least_gap_m > 0.0, "{} m", drive.least_gap_m);
}
