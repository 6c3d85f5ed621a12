//! The distance field against brute force.

use inbye::geometry::Pose;
use inbye::map::{Cell, DistanceField, GridFrame, ObstacleGrid};
use rand::{RngExt, SeedableRng};

fn brute_force(obstacles: &ObstacleGrid) -> Vec<u32> {
    let frame = obstacles.frame();
    let sites: Vec<Cell> =
        (0..frame.len()).filter(|&i| obstacles.cells()[i]).map(|i| frame.cell_at(i)).collect();
    (0..frame.len())
        .map(|index| {
            let cell = frame.cell_at(index);
            sites
                .iter()
                .map(|site| {
                    let (dx, dy) = (site.column - cell.column, site.row - cell.row);
                    (dx * dx + dy * dy) as u32
                })
                .min()
                .unwrap_or(DistanceField::NO_OBSTACLE)
        })
        .collect()
}

fn check(width: i32, height: i32, blocked: Vec<bool>) {
    let frame = GridFrame { width, height, resolution_m: 0.1, origin: Pose::default() };
    let obstacles = ObstacleGrid::new(frame, blocked);
    let field = DistanceField::new(&obstacles);
    let expected = brute_force(&obstacles);
    let wrong = (0..frame.len()).find(|&i| field.squared_cells()[i] != expected[i]);
    assert_eq!(
        wrong.map(|i| (frame.cell_at(i), field.squared_cells()[i], expected[i])),
        None,
        "of {width} x {height}"
    );
}

#[test]
fn distance_field_equals_brute_force_on_random_grids() {
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(7);
    for case in 0..400 {
        let (width, height) = match case % 8 {
            0 => (1, rng.random_range(1..100)),
            1 => (rng.random_range(1..100), 1),
            _ => (rng.random_range(1..70), rng.random_range(1..40)),
        };
        let density = [0.0, 0.002, 0.05, 0.5, 1.0][case % 5];
        let cells = (width * height) as usize;
        let blocked = (0..cells).map(|_| rng.random_bool(density)).collect();
        check(width, height, blocked);
    }
}

/// A few obstacles in a large grid: rows near and far from them, so that both number types are used.
#[test]
fn distance_field_equals_brute_force_with_sparse_obstacles() {
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(8);
    for _ in 0..30 {
        let (width, height) = (rng.random_range(200..700), rng.random_range(150..400));
        let mut blocked = vec![false; (width * height) as usize];
        for _ in 0..rng.random_range(1..12) {
            let place = rng.random_range(0..blocked.len());
            blocked[place] = true;
        }
        check(width, height, blocked);
    }
}

#[test]
fn distance_field_equals_brute_force_on_the_longest_grids() {
    for long in [32_767, 40_000_i32] {
        let few = |i| [5, 300, 30_000].contains(&i);
        let many = |i| i % 100 == 7 || i == long - 1;
        let last = |i| i == long - 1;
        check(long, 1, (0..long).map(few).collect());
        check(1, long, (0..long).map(few).collect());
        check(long, 1, (0..long).map(many).collect());
        check(1, long, (0..long).map(many).collect());
        check(long, 1, (0..long).map(last).collect());
        check(long, 3, (0..3 * long).map(last).collect());
        check(long, 3, (0..3 * long).map(many).collect());
    }
}
