//! Drives of 300 m through rough roadways with slipping tracks and a noisy lidar.

use std::sync::Arc;

use inbye::experiment::{LocalizationCase, LocalizationPlan, LocalizationRow};
use inbye::runtime::Config;
use inbye::sim::{Lidar, Scene, crossing, roadway};

/// 5 % slip, a small lidar, and a short patience of a lost robot.
fn config() -> Config {
    let mut config = Config::default();
    config.simulation.lidar = Lidar::turning();
    config.simulation.dynamics.slip.mean = 0.05;
    config.navigator.localization_patience_s = 5.0;
    config
}

/// A plan of drives in a built-in scene.
pub fn plan(scene: Scene) -> LocalizationPlan {
    LocalizationPlan {
        name: scene.name.to_owned(),
        map: Arc::new(scene.map),
        start: scene.start,
        goal: scene.goal,
        config: config(),
        tour_m: 300.0,
    }
}

fn assert_kept(row: &LocalizationRow) {
    assert!(row.reached && !row.collided, "{row:#?}");
    assert!(row.travelled_m >= 300.0, "{row:#?}");
    assert!(row.worst_m <= 0.05 && row.worst_rad <= 0.02, "{row:#?}");
    assert_eq!(row.lost_ticks, 0, "{row:#?}");
    // Odometry alone would exceed the limits.
    assert!(row.odometry_worst_m > 0.5, "{row:#?}");
}

#[test]
fn pose_error_over_300_m_stays_below_5_cm_and_20_mrad() {
    let rows = (0..3).map(|seed| plan(roadway()).drive(LocalizationCase::Tour, seed));
    let rows: Vec<LocalizationRow> =
        rows.map(|row| row.expect("a path in both directions")).collect();
    rows.iter().for_each(assert_kept);
    // Each seed gives another drive, and the same seed the same one.
    assert_ne!(rows[0].trace_digest, rows[1].trace_digest);
    let again = plan(roadway()).drive(LocalizationCase::Tour, 0);
    assert_eq!(again.expect("the same path"), rows[0]);
}

#[test]
fn pose_error_stays_small_among_rooms_pillars_and_people() {
    let row = plan(crossing()).drive(LocalizationCase::People, 1);
    assert_kept(&row.expect("a path in both directions"));
}

/// The mapped surfaces are up to half a cell away from the real ones.
#[test]
fn pose_error_stays_small_with_a_coarse_map() {
    let row = plan(roadway()).drive(LocalizationCase::CoarseMap, 1);
    assert_kept(&row.expect("a path in both directions"));
}
