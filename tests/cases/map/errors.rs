//! Error messages for invalid map files: one line with the file, the place and the cause. Never a panic.

use std::path::Path;

use crate::support::hand_png::png;
use crate::support::map_folder::Folder;
use image::GrayImage;
use inbye::geometry::Pose;
use inbye::map::{
    GridFrame, LoadOptions, MAX_GRID_SIDE, MAX_RESOLUTION_M, MapError, OccupancyGrid, load,
    read_scen,
};

/// Asserts a one-line message that starts with the file and contains all fragments, separated by `; `.
#[track_caller]
fn assert_message(refused: &MapError, path: &Path, words: &str) {
    let message = refused.to_string();
    assert_eq!(message.lines().count(), 1, "{message}");
    let place = format!("{}: ", path.display());
    assert!(message.starts_with(&place), "{message}");
    for word in words.split("; ") {
        assert!(message.contains(word), "no {word:?} in: {message}");
    }
}

#[test]
fn grid_frame_rejects_bad_size_resolution_and_origin() {
    let origin = Pose::default();
    assert!(GridFrame::new(1, MAX_GRID_SIDE, 1e-3, origin).is_ok());
    for (width, height) in [(0, 1), (1, 0), (-3, 4), (MAX_GRID_SIDE + 1, 1), (10_001, 10_000)] {
        let refused = GridFrame::new(width, height, 1.0, origin).unwrap_err();
        assert!(matches!(refused, MapError::BadGridSize { .. }), "{refused}");
    }
    assert!(GridFrame::new(1, 1, MAX_RESOLUTION_M, origin).is_ok());
    for resolution_m in [0.0, -0.0, -1.0, 100.1, f64::NAN, f64::INFINITY] {
        let refused = GridFrame::new(1, 1, resolution_m, origin).unwrap_err();
        assert!(matches!(refused, MapError::BadResolution { .. }), "{refused}");
    }
    for origin in [Pose::new(f64::NAN, 0.0, 0.0), Pose::new(0.0, 0.0, f64::INFINITY)] {
        let refused = GridFrame::new(1, 1, 1.0, origin).unwrap_err();
        assert!(matches!(refused, MapError::BadOrigin { .. }), "{refused}");
    }
}

const VALID_YAML: &str = "\
image: map.pgm
resolution: 0.05
origin: [0, 0, 0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
mode: trinary
";

/// A line of the valid file, its replacement (nothing: the line is removed), and fragments of the message.
const BAD_YAML: &str = r#"
resolution: 0.05 -> resolution: 0 -> line 2; `resolution` is 0; above zero
resolution: 0.05 -> resolution: -0.05 -> line 2; `resolution` is -0.05
resolution: 0.05 -> resolution: 500 -> line 2; `resolution` is 500; at most 100
resolution: 0.05 -> resolution: .nan -> line 2; `resolution`; .nan; finite
resolution: 0.05 -> resolution: .inf -> line 2; `resolution`; .inf
resolution: 0.05 -> resolution: nan -> line 2; `resolution`; nan
resolution: 0.05 -> resolution: 1e999 -> line 2; `resolution`
resolution: 0.05 -> resolution: five -> line 2; `resolution`; five
resolution: 0.05 -> resolution: -> line 2; `resolution` is null
resolution: 0.05 -> resolution: [0.05] -> line 2; `resolution` is [0.05]
resolution: 0.05 -> resolutoin: 0.05 -> line 2: has `resolutoin`, needs `resolution`
resolution: 0.05 -> Resolution: 0.05 -> line 2: has `Resolution`, needs `resolution`
resolution: 0.05 -> metres: 0.05 -> needs the key `resolution`
resolution: 0.05 ->  -> needs the key `resolution`
image: map.pgm ->  -> needs the key `image`
origin: [0, 0, 0] ->  -> needs the key `origin`
negate: 0 -> negate: 7 -> line 4; `negate` is 7; 0, 1, true or false
negate: 0 -> negate: -2 -> line 4; `negate` is -2; 0, 1, true or false
negate: 0 ->  -> needs the key `negate`
free_thresh: 0.196 ->  -> needs the key `free_thresh`
occupied_thresh: 0.65 -> occ_thresh: 0.65 -> has `occ_thresh`, needs `occupied_thresh`
origin: [0, 0, 0] -> origin: [0, 0] -> line 3; `origin` is [0,0]; three finite numbers
origin: [0, 0, 0] -> origin: [0, 0, 0, 0] -> line 3; `origin`
origin: [0, 0, 0] -> origin: [0, .inf, 0] -> line 3; `origin`; .inf
origin: [0, 0, 0] -> origin: [0, 0, x] -> line 3; `origin`
origin: [0, 0, 0] -> origin: 0 -> line 3; `origin` is 0
negate: 0 -> negate: perhaps -> line 4; `negate`; perhaps; true or false
negate: 0 -> negate: 0.5 -> line 4; `negate` is 0.5
occupied_thresh: 0.65 -> occupied_thresh: 65 -> line 5; `occupied_thresh` is 65
occupied_thresh: 0.65 -> occupied_thresh: .nan -> line 5; `occupied_thresh`
free_thresh: 0.196 -> free_thresh: -0.1 -> line 6; `free_thresh` is -0.1
free_thresh: 0.196 -> free_thresh: 0.65 -> line 6; `free_thresh`; below `occupied_thresh`
free_thresh: 0.196 -> free_thresh: 0.7 -> line 6; `free_thresh` is 0.7
mode: trinary -> mode: trinery -> line 7; `mode`; trinery; trinary, scale or raw
mode: trinary -> mode: 3 -> line 7; `mode` is 3
mode: trinary -> resolution: 0.1 -> line 7; duplicate key `resolution`
mode: trinary -> mode: [trinary -> line 7
mode: trinary ->     mode: trinary -> line 7
mode: trinary -> a: *nobody -> line 7
image: map.pgm -> image: '' -> line 1; `image`
image: map.pgm -> image: {a: b} -> line 1; `image`
image: map.pgm -> image: elsewhere.pgm -> line 1; `image`; elsewhere.pgm; cannot be read
image: map.pgm -> image: . -> line 1; `image`
image: map.pgm -> image: "a\nb" -> line 1; `image`; a\nb
"#;

#[test]
fn map_yaml_rejects_bad_values_with_line_and_key() {
    let folder = Folder::new();
    folder.write_image("map.pgm", GrayImage::new(2, 2));
    let load_text = |text: &str| load(&folder.write("map.yaml", text), &LoadOptions::default());
    assert!(load_text(VALID_YAML).is_ok());
    for case in BAD_YAML.trim().lines() {
        let parts: Vec<&str> = case.split(" -> ").collect();
        let [line, replacement, words] = parts[..] else {
            panic!("a case has three parts: {case}");
        };
        let text = VALID_YAML.replace(line, replacement);
        assert_ne!(text, VALID_YAML, "{case}");
        assert_message(&load_text(&text).unwrap_err(), &folder.path("map.yaml"), words);
    }
}

#[test]
fn map_yaml_rejects_documents_that_are_no_mapping() {
    let folder = Folder::new();
    for (text, words) in [
        ("", "needs the key"),
        ("\n\n", "needs the key"),
        ("# nothing\n", "needs the key"),
        ("{}", "needs the key"),
        ("- a\n- b\n", "line 1; mapping"),
        ("just words", "line 1; mapping"),
        ("---\na: 1\n---\nb: 2\n", "line 4; a second document"),
    ] {
        let path = folder.write("map.yaml", text);
        assert_message(&load(&path, &LoadOptions::default()).unwrap_err(), &path, words);
    }
}

#[test]
fn map_yaml_stops_an_alias_bomb_at_its_node_budget() {
    let mut bomb = vec![String::from("a0: &a0 [x, x, x, x, x, x, x, x, x]")];
    for level in 1..10 {
        let aliases = vec![format!("*a{}", level - 1); 9].join(", ");
        bomb.push(format!("a{level}: &a{level} [{aliases}]"));
    }
    let folder = Folder::new();
    let path = folder.write("map.yaml", bomb.join("\n") + "\nimage: map.pgm\n");
    let refused = load(&path, &LoadOptions::default()).unwrap_err();
    assert_message(&refused, &path, "line 5; more than 10000 values");
}

const UNDECODABLE: &str = "not a PGM, PNG or BMP image";

/// Name, contents and fragments of the message.
type BadFile = (&'static str, &'static [u8], &'static str);

const BAD_IMAGES: &[BadFile] = &[
    ("empty.pgm", b"", UNDECODABLE),
    ("words.png", b"this is no picture", UNDECODABLE),
    ("photo.jpg", b"\xff\xd8\xff\xe0\0\x10JFIF\0", UNDECODABLE),
    ("short.pgm", b"P5 4 4 255\n0123", UNDECODABLE),
    ("short_digits.pgm", b"P2 4 4 255\n0 1 2 3", UNDECODABLE),
    ("header.pgm", b"P5 4", UNDECODABLE),
    ("deep.pgm", b"P5 1 1 70000\n0000", UNDECODABLE),
    ("letters.pgm", b"P2 2 1 255\n0 x", UNDECODABLE),
    ("none.pgm", b"P5 0 0 255\n", "0 x 0 cells"),
    ("wide.pgm", b"P5 60000 60000 255\n", "60000 x 60000 cells"),
    ("long.pgm", b"P5 32768 1 255\n", "32768 x 1 cells"),
    ("big.pgm", b"P5 30000 30000 255\n", "30000 x 30000 cells"),
    ("huge.pgm", b"P5 4294967295 4294967295 255\n", "4294967295 x 4294967295 cells"),
];

#[test]
fn map_image_rejects_bad_files_with_their_name() {
    let folder = Folder::new();
    let mut cases: Vec<(&str, Vec<u8>, &str)> =
        BAD_IMAGES.iter().map(|&(name, bytes, words)| (name, bytes.to_vec(), words)).collect();
    let whole = png((4, 4), 8, 0, &[], &vec![vec![0; 4]; 4]);
    let mut altered = whole.clone();
    altered[50] ^= 1;
    let headed = |side| png((side, side), 16, 6, &[], &[]);
    cases.extend([
        ("short.png", whole[..whole.len() - 30].to_vec(), UNDECODABLE),
        ("altered.png", altered, UNDECODABLE),
        ("none.png", headed(0), UNDECODABLE),
        ("wide.png", headed(60_000), "60000 x 60000 cells"),
        ("big.png", headed(30_000), "30000 x 30000 cells"),
    ]);
    folder.write("whole.png", whole);
    assert!(folder.load_yaml("whole.png", "").is_ok());
    for (name, bytes, words) in cases {
        folder.write(name, bytes);
        let refused = folder.load_yaml(name, "").unwrap_err();
        let words = format!("line 1; `image`; {name}; {words}");
        assert_message(&refused, &folder.path("map.yaml"), &words);
    }
}

const BAD_ROWS: &[BadFile] = &[
    ("empty.txt", b"", "no cell"),
    ("blank.txt", b"\n\n\n", "no cell"),
    ("ragged.txt", b"###\n#.\n###\n", "row 2 has 2 cells; 3"),
    ("strange.txt", b"###\n#x#\n###\n", "row 2, column 2; 'x'"),
    ("latin.txt", b"###\n#\xe9#\n", "line 2; UTF-8"),
    ("map.pgm", b"P5 1 1 255\n0", "YAML"),
    ("latin.yaml", b"image: caf\xe9.pgm\n", "line 1; UTF-8"),
    ("empty.map", b"", "line 1; the file ends; type octile"),
    ("text.map", b"###\n", "line 1; \"###\"; `type octile`"),
    ("tile.map", b"type tile\nheight 1\nwidth 1\nmap\n.\n", "line 1; tile"),
    ("wide.map", b"type octile\nheight 1\nwidth 60000\nmap\n.\n", "line 3; `width` is \"60000\""),
    ("none.map", b"type octile\nheight 0\nwidth 1\nmap\n", "line 2; `height` is \"0\""),
    ("words.map", b"type octile\nheight one\nwidth 1\nmap\n.\n", "line 2; one"),
    ("narrow.map", b"type octile\nheight 1\nmap\n.\n", "line 3; `width`"),
    ("deep.map", b"type octile\nheight 1\ndepth 1\nmap\n.\n", "line 3; depth"),
    ("twice.map", b"type octile\ntype octile\n", "line 2; `map`"),
    ("big.map", b"type octile\nheight 32767\nwidth 32767\nmap\n.\n", "32767 x 32767 cells"),
    ("short.map", b"type octile\nheight 2\nwidth 1\nmap\n.\n", "line 5; ends after 1 rows"),
    ("none_at_all.map", b"type octile\nheight 2\nwidth 1\nmap\n", "line 4; ends after 0 rows"),
    ("long.map", b"type octile\nheight 1\nwidth 1\nmap\n.\n@\n", "line 6; another row"),
    ("ragged.map", b"type octile\nheight 2\nwidth 2\nmap\n..\n.\n", "line 6; a row of 1 cells"),
    ("strange.map", b"type octile\nheight 1\nwidth 2\nmap\n.x\n", "line 5; column 2; 'x'"),
    ("header.map", b"type octile\nheight 1\n", "line 2; the file ends"),
    ("latin.map", b"type octile\nheight 1\nwidth 1\nmap\n\xff\n", "line 5; UTF-8"),
];

#[test]
fn text_and_movingai_maps_reject_bad_files_with_their_place() {
    let folder = Folder::new();
    for (name, bytes, words) in BAD_ROWS {
        let path = folder.write(name, bytes);
        assert_message(&load(&path, &LoadOptions::default()).unwrap_err(), &path, words);
    }
}

#[test]
fn load_rejects_a_missing_file_with_its_name() {
    let folder = Folder::new();
    for name in ["missing.txt", "missing.map", "missing.yaml"] {
        let path = folder.path(name);
        let refused = load(&path, &LoadOptions::default()).unwrap_err();
        assert_message(&refused, &path, "cannot be read");
    }
    let path = folder.path("missing.scen");
    assert_message(&read_scen(&path).unwrap_err(), &path, "cannot be read");
}

#[test]
fn load_rejects_a_bad_resolution_option() {
    let folder = Folder::new();
    let options = LoadOptions { resolution_m: f64::NAN };
    for (name, text) in
        [("valid.txt", "##\n"), ("valid.map", "type octile\nheight 1\nwidth 1\nmap\n.\n")]
    {
        let path = folder.write(name, text);
        assert!(load(&path, &LoadOptions::default()).is_ok());
        assert_message(&load(&path, &options).unwrap_err(), &path, "resolution is NaN");
    }
}

#[test]
fn from_rows_rejects_bad_cells_with_row_and_column() {
    let origin = Pose::default();
    for (rows, words) in [
        (vec!["...", "..o"], "row 2, column 3: 'o'"),
        (vec!["..", "..."], "row 2 has 3 cells where row 1 has 2"),
        (vec![], "holds no cell"),
        (vec!["", ""], "holds no cell"),
        (vec!["", "."], "row 2 has 1 cells where row 1 has 0"),
        (vec!["é."], "row 1, column 1: 'é'"),
    ] {
        let refused = OccupancyGrid::from_rows(&rows, 1.0, origin).unwrap_err();
        assert!(refused.to_string().starts_with(words), "{refused}");
    }
    let refused = OccupancyGrid::from_rows(&["."], -1.0, origin).unwrap_err();
    assert_eq!(refused, MapError::BadResolution { resolution_m: -1.0 });
}

#[test]
fn scen_rejects_bad_fields_with_line_and_name() {
    let folder = Folder::new();
    let good = "0\ta.map\t9\t9\t0\t0\t8\t8\t11.3";
    for (from, to, words) in [
        ("0\ta", "x\ta", "line 2; bucket is \"x\""),
        ("\t9\t9\t", "\t9\t-9\t", "line 2; height is \"-9\""),
        ("\t9\t9\t", "\t9.5\t9\t", "line 2; width is \"9.5\""),
        ("\t8\t8\t", "\t8\t9\t", "line 2; goal is (8, 9); 9 x 9"),
        ("\t0\t0\t", "\t-1\t0\t", "line 2; start is (-1, 0)"),
        ("11.3", "NaN", "line 2; optimal is \"NaN\""),
        ("11.3", "inf", "line 2; optimal"),
        ("11.3", "-1", "line 2; optimal"),
        ("\t11.3", "", "line 2; 8 fields"),
        ("11.3", "11.3\t1", "line 2; 10 fields"),
    ] {
        let text = format!("version 1.0\n{}\n", good.replace(from, to));
        let path = folder.write("bad.scen", text);
        assert_message(&read_scen(&path).unwrap_err(), &path, words);
    }
}
