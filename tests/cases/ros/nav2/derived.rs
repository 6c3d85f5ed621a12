//! Settings that are computed: the discs of a polygon, and the grid of samples of a batch.

use core::f64::consts::TAU;

use inbye::robot::Disc;
use inbye::ros::nav2::import;
use inbye::runtime::Config;

fn config(text: &str) -> Config {
    let imported = import(text, None).expect("a valid file");
    toml::from_str(&imported.config).expect("valid settings")
}

/// The discs of a polygon without padding.
fn cover(corners: &[[f64; 2]]) -> Vec<Disc> {
    let config = config(&format!(
        "local_costmap:\n  local_costmap:\n    ros__parameters:\n      footprint: \"{corners:?}\"\n      footprint_padding: 0.0\n"
    ));
    config.robot.footprint.discs().to_vec()
}

/// Whether every corner and every inner point is in a disc.
fn covers(discs: &[Disc], corners: &[[f64; 2]], inside: &[[f64; 2]]) -> bool {
    corners.iter().chain(inside).all(|point| {
        discs
            .iter()
            .any(|disc| libm::hypot(point[0] - disc.x, point[1] - disc.y) <= disc.radius + 1e-12)
    })
}

#[test]
fn discs_cover_rectangles() {
    for (length, width) in
        [(0.7, 0.5), (0.5, 0.7), (1.0, 1.0), (3.0, 0.2), (0.01, 2.0), (40.0, 0.1)]
    {
        let (x, y) = (0.1, -0.05);
        let at = |share_x: f64, share_y: f64| [x + share_x * length, y + share_y * width];
        let corners = [at(0.5, 0.5), at(0.5, -0.5), at(-0.5, -0.5), at(-0.5, 0.5)];
        let mut inside = Vec::new();
        for i in 0..=100 {
            for j in 0..=20 {
                inside.push(at(f64::from(i) / 100.0 - 0.5, f64::from(j) / 20.0 - 0.5));
            }
        }
        let discs = cover(&corners);
        assert!(covers(&discs, &corners, &inside), "{length} x {width}");
        assert!(discs.len() <= 8);
    }
}

#[test]
fn round_polygon_is_one_disc() {
    let corner = |index: u32| {
        let angle = TAU * f64::from(index) / 16.0;
        [0.22 * libm::cos(angle), 0.22 * libm::sin(angle)]
    };
    let discs = cover(&(0..16).map(corner).collect::<Vec<_>>());
    assert_eq!(discs.len(), 1);
    assert!((discs[0].radius - 0.22).abs() < 1e-12 && discs[0].x.abs() < 1e-12);
}

/// The overhang of the discs of the default robot is less than a fifth of its width.
#[test]
fn cover_of_default_robot_is_tight() {
    let discs = cover(&[[0.35, 0.25], [0.35, -0.25], [-0.35, -0.25], [-0.35, 0.25]]);
    assert_eq!(discs, Config::default().robot.footprint.discs());
    assert!(discs.iter().all(|disc| disc.radius < 0.25 + 0.1), "{discs:?}");
}

#[test]
fn sample_grid_is_largest_within_batch_size() {
    let grid = |samples: u32| {
        let config = config(&format!(
            "controller_server:\n  ros__parameters:\n    FollowPath:\n      \
             plugin: nav2_mppi_controller::MPPIController\n      batch_size: {samples}\n"
        ));
        (config.local.vx_samples, config.local.vtheta_samples)
    };
    assert_eq!([1, 2, 800, 1000, 2000].map(grid), [(1, 1), (1, 2), (20, 40), (22, 45), (31, 64)]);
    for samples in (1..5000).step_by(13) {
        let (speeds, rates) = grid(samples);
        assert!(speeds * rates <= samples && speeds * (rates + 1) > samples);
    }
}
