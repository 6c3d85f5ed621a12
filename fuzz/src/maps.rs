//! Maps and scenarios.

use inbye::geometry::Pose;
use inbye::map::{
    MAX_GRID_CELLS, MAX_GRID_SIDE, MapError, OccupancyGrid, UNKNOWN, UnknownPolicy,
    cell_from_top_left, parse_scen,
};

use super::one_line;

/// A small image for any YAML file: several greys, and a comment.
const IMAGE: &[u8] = b"P5\n# greys\n4 2\n255\n\x00\x01\x40\x7f\x80\xcd\xfe\xff";

/// A valid YAML file for any image. Its mode distinguishes greys.
const YAML: &str = "image: map.png\nresolution: 0.05\norigin: [-1.5, 2, 0.5]\nnegate: 0\n\
    occupied_thresh: 0.65\nfree_thresh: 0.196\nmode: scale\n";

/// The YAML file of a `map_server` map.
pub fn map_yaml(data: &[u8]) {
    if let Ok(text) = str::from_utf8(data) {
        let map = OccupancyGrid::from_map_server(text, IMAGE);
        if let Some(map) = checked(map) {
            assert_eq!((map.frame().width, map.frame().height), (4, 2));
        }
    }
}

/// The image of a `map_server` map.
pub fn map_image(data: &[u8]) {
    checked(OccupancyGrid::from_map_server(YAML, data));
}

/// Both files, separated by a zero byte, which no YAML file has.
pub fn map_server(data: &[u8]) {
    let mut parts = data.splitn(2, |byte| *byte == 0);
    let (yaml, image) = (parts.next().unwrap_or_default(), parts.next());
    if let Ok(text) = str::from_utf8(yaml) {
        let image = image.unwrap_or(IMAGE);
        checked(OccupancyGrid::from_map_server(text, image));
    }
}

/// A `MovingAI` map. A map that is read is the same when it is written and read again.
pub fn movingai_map(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    if let Some(map) = checked(OccupancyGrid::from_movingai(text, 0.25)) {
        let frame = map.frame();
        let rows = drawn(&map, |cell| if cell == 0 { '.' } else { '@' });
        let (height, width) = (frame.height, frame.width);
        let text = format!("type octile\nheight {height}\nwidth {width}\nmap\n{rows}");
        assert_eq!(OccupancyGrid::from_movingai(&text, 0.25), Ok(map));
    }
}

/// A map of rows of text. A map that is read is the same when it is written and read again.
pub fn text_map(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    if let Some(map) = checked(OccupancyGrid::from_text(text, 0.25)) {
        let rows = drawn(&map, |cell| match cell {
            0 => '.',
            UNKNOWN => '?',
            _ => '#',
        });
        assert_eq!(OccupancyGrid::from_text(&rows, 0.25).as_ref(), Ok(&map), "{rows}");
        let rows: Vec<&str> = rows.lines().collect();
        let same = OccupancyGrid::from_rows(&rows, 0.25, Pose::default());
        assert_eq!(same, Ok(map));
    }
}

/// A file of scenarios. Each query is within its map; its length and the rounding of that length are finite.
pub fn scenarios(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    match parse_scen(text) {
        Err(error) => one_line(&error),
        Ok(queries) => {
            let lines = text.lines().count();
            for query in queries {
                assert!((1..=lines).contains(&query.line), "{query:?}");
                for (x, y) in [query.start, query.goal] {
                    let inside = (0..query.width).contains(&x) && (0..query.height).contains(&y);
                    assert!(inside, "{query:?}");
                }
                assert!(query.optimal.is_finite() && query.optimal >= 0.0, "{query:?}");
                assert!(query.rounding.is_finite() && query.rounding >= 0.0, "{query:?}");
            }
        }
    }
}

/// Checks a map; none for one that was rejected with a message of one line.
fn checked(map: Result<OccupancyGrid, MapError>) -> Option<OccupancyGrid> {
    let map = map.inspect_err(|error| {
        one_line(error);
        let letters = error.to_string().chars().count();
        assert!(letters < 1000, "{letters} letters: {error}");
    });
    let map = map.ok()?;
    let frame = map.frame();
    for side in [frame.width, frame.height] {
        assert!((1..=MAX_GRID_SIDE).contains(&side), "{frame:?}");
    }
    assert!(frame.len() <= MAX_GRID_CELLS, "{frame:?}");
    assert!(frame.resolution_m.is_finite() && frame.resolution_m > 0.0, "{frame:?}");
    assert!(frame.origin.is_finite(), "{frame:?}");
    assert_eq!(map.cells().len(), frame.len());
    let is_valid = |cell: &i8| *cell == UNKNOWN || (0..=100).contains(cell);
    assert!(map.cells().iter().all(is_valid), "{:?}", map.cells());
    let obstacles = map.obstacles(UnknownPolicy::default());
    assert_eq!(obstacles.cells().len(), frame.len());
    Some(map)
}

/// The rows of a map from the top, each with its line break.
fn drawn(map: &OccupancyGrid, letter: impl Fn(i8) -> char) -> String {
    let frame = map.frame();
    let mut rows = String::new();
    for y in 0..frame.height {
        let cell = |x| map.cells()[frame.index(cell_from_top_left(frame, (x, y)))];
        rows.extend((0..frame.width).map(|x| letter(cell(x))));
        rows.push('\n');
    }
    rows
}
