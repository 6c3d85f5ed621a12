//! Legal and illegal paths.

use core::f64::consts::SQRT_2;

use inbye::bench::movingai::{AnswerCheck, IllegalPath, TOLERANCE, check_answer, path_length};
use inbye::geometry::Pose;
use inbye::map::{Cell, ObstacleGrid, OccupancyGrid, Scenario, UnknownPolicy};

use super::Test;

pub const TESTS: [Test; 3] = [
    ("the length of a legal path is that of its moves", legal_paths_are_measured),
    ("every illegal path is rejected by its kind", illegal_paths_are_rejected_by_kind),
    (
        "lengths are compared within the precision of the file",
        lengths_are_compared_within_the_tolerance,
    ),
];

/// Rows from the top; the lowest is row 0 of the cells.
const ROWS: [&str; 4] = [
    "......", //
    "..##..", //
    "...#..", //
    "......", //
];

fn obstacles() -> ObstacleGrid {
    let map = OccupancyGrid::from_rows(&ROWS, 0.5, Pose::new(3.0, -2.0, 0.4)).expect("rows");
    map.obstacles(UnknownPolicy::Blocked)
}

fn path(cells: &[(i32, i32)]) -> Vec<Cell> {
    cells.iter().map(|&(column, row)| Cell::new(column, row)).collect()
}

fn legal_paths_are_measured() {
    for (cells, straight, diagonal) in [
        (&[(4, 1)][..], 0.0, 0.0),
        (&[(0, 0), (1, 1), (0, 2), (0, 3)], 1.0, 2.0),
        (&[(0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (5, 1)], 4.0, 1.0),
        // A path back and forth is long but legal.
        (&[(5, 3), (4, 3), (5, 3)], 2.0, 0.0),
    ] {
        let cells = path(cells);
        let (start, goal) = (cells[0], cells[cells.len() - 1]);
        let length = path_length(&obstacles(), start, goal, &cells);
        assert_eq!(length, Ok(straight + diagonal * SQRT_2), "{cells:?}");
    }
}

fn illegal_paths_are_rejected_by_kind() {
    let (start, goal) = (Cell::new(0, 0), Cell::new(2, 1));
    let checked = |cells: &[(i32, i32)]| path_length(&obstacles(), start, goal, &path(cells));
    assert!(checked(&[(0, 0), (1, 0), (2, 1)]).is_ok(), "sound before it is spoilt");
    let at = Cell::new;
    let jump = |from, to| IllegalPath::Jump { from, to };
    let cut = |from, to| IllegalPath::CutCorner { from, to };
    for (cells, expected) in [
        (&[][..], IllegalPath::Empty),
        (&[(1, 0), (2, 1)], IllegalPath::OtherStart { found: at(1, 0), expected: start }),
        (&[(0, 0), (1, 0)], IllegalPath::OtherGoal { found: at(1, 0), expected: goal }),
        (&[(0, 0), (2, 1)], jump(at(0, 0), at(2, 1))),
        (&[(0, 0), (2, 0), (2, 1)], jump(at(0, 0), at(2, 0))),
        (&[(0, 0), (0, 0), (1, 0), (2, 1)], jump(at(0, 0), at(0, 0))),
        // Through the wall, and over the map's edge.
        (&[(0, 0), (1, 1), (2, 2), (2, 1)], IllegalPath::Blocked { cell: at(2, 2) }),
        (&[(0, 0), (0, -1), (1, 0), (2, 1)], IllegalPath::Blocked { cell: at(0, -1) }),
        // Diagonal moves past one obstacle on either side, in both directions.
        (&[(0, 0), (1, 1), (1, 2), (2, 3), (1, 2), (2, 1)], cut(at(1, 2), at(2, 3))),
        (&[(0, 0), (1, 0), (2, 0), (3, 0), (2, 1)], cut(at(3, 0), at(2, 1))),
        (&[(0, 0), (1, 1), (1, 2), (2, 1)], cut(at(1, 2), at(2, 1))),
    ] {
        assert_eq!(checked(cells), Err(expected), "{cells:?}");
    }
    // A diagonal between two obstacles, which touches both.
    let map = OccupancyGrid::from_rows(&["#.", ".#"], 1.0, Pose::default()).expect("rows");
    let cells = path(&[(0, 0), (1, 1)]);
    let checked = path_length(&map.obstacles(UnknownPolicy::Blocked), at(0, 0), at(1, 1), &cells);
    assert_eq!(checked, Err(cut(at(0, 0), at(1, 1))));
}

fn lengths_are_compared_within_the_tolerance() {
    // Coordinates from the top left: the cells (0, 0) and (1, 1) from the lower left.
    let scenario = |off: f64, rounding| Scenario {
        line: 1,
        bucket: 0,
        map: "a.map".to_owned(),
        width: 6,
        height: 4,
        start: (0, 3),
        goal: (1, 2),
        optimal: SQRT_2 + off,
        rounding,
    };
    let cells = path(&[(0, 0), (1, 1)]);
    let length = SQRT_2;
    for rounding in [0.0, 5e-3] {
        let edge = TOLERANCE + rounding;
        for (off, expected) in [
            (0.0, AnswerCheck::Optimal),
            (edge - 1e-9, AnswerCheck::Optimal),
            (1e-9 - edge, AnswerCheck::Optimal),
            (edge + 1e-9, AnswerCheck::Shorter { length }),
            (-edge - 1e-9, AnswerCheck::Longer { length }),
            (0.01, AnswerCheck::Shorter { length }),
            (-0.01, AnswerCheck::Longer { length }),
        ] {
            let answer = check_answer(&obstacles(), &scenario(off, rounding), Some(&cells));
            assert_eq!(answer, expected, "{off} off, rounded by {rounding}");
        }
    }
    let scenario = scenario(0.0, 0.0);
    let none = check_answer(&obstacles(), &scenario, None);
    assert_eq!(none, AnswerCheck::NotFound);
    let elsewhere = check_answer(&obstacles(), &scenario, Some(&cells[..1]));
    assert!(matches!(elsewhere, AnswerCheck::Illegal(IllegalPath::OtherGoal { .. })));
}
