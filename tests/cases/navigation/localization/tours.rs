//! Tours of 300 m through rough roadways, by wheel odometry that slips and a noisy lidar alone.

use std::sync::Arc;

use inbye::experiment::{LocalizationCase, LocalizationPlan, LocalizationRow};
use inbye::runtime::Config;
use inbye::sim::{Lidar, Scene, crossing, roadway};

/// 5 % slip, and a lidar as small ones are. Who is lost gives up soon.
fn config() -> Config {
    let mut config = Config {
        lidar: Lidar::turning(),
        ..Config::default()
    };
    config.dynamics.slip.mean = 0.05;
    config.navigator.localization_patience_s = 5.0;
    config
}

/// Drives in a built-in scene.
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
    // What is kept would not be kept without the scans.
    assert!(row.odometry_worst_m > 0.5, "{row:#?}");
}

#[test]
fn over_300_m_the_pose_stays_within_5_cm_and_20_mrad() {
    let rows = (0..3).map(|seed| plan(roadway()).drive(LocalizationCase::Tour, seed));
    let rows: Vec<LocalizationRow> = rows.map(|row| row.expect("a way to and fro")).collect();
    rows.iter().for_each(assert_kept);
    // Each seed is another drive, and the same each time.
    assert_ne!(rows[0].trace_digest, rows[1].trace_digest);
    let again = plan(roadway()).drive(LocalizationCase::Tour, 0);
    assert_eq!(again.expect("the same way"), rows[0]);
}

#[test]
fn and_among_rooms_and_pillars_and_people() {
    let row = plan(crossing()).drive(LocalizationCase::People, 1);
    assert_kept(&row.expect("a way to and fro"));
}

/// The walls that the map has are up to half a cell from those that are there.
#[test]
fn and_with_a_map_coarser_than_the_world() {
    let row = plan(roadway()).drive(LocalizationCase::CoarseMap, 1);
    assert_kept(&row.expect("a way to and fro"));
}
