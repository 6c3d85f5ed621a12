//! Reading map files: the meaning of each pixel, character and key.

use core::f64::consts::FRAC_PI_2;

use crate::support::hand_png::png;
use crate::support::map_folder::Folder;
use image::{DynamicImage, GrayAlphaImage, GrayImage, ImageBuffer, Luma, RgbImage, RgbaImage};
use inbye::geometry::{Point, Pose};
use inbye::map::{
    Cell, GridFrame, LoadOptions, OccupancyGrid, Scenario, UNKNOWN, UnknownPolicy,
    cell_from_top_left, load, read_scen,
};

/// The cells of an image of one row.
fn cells_of_row(image: impl Into<DynamicImage>, lines: &str) -> Vec<i8> {
    let folder = Folder::new();
    folder.write_image("row.png", image);
    let grid = folder.load_yaml("row.png", lines).expect("a valid map");
    grid.cells().to_vec()
}

fn grey_row(greys: &[u8]) -> GrayImage {
    GrayImage::from_raw(greys.len() as u32, 1, greys.to_vec()).expect("one row")
}

#[test]
fn trinary_mode_reads_the_greys_of_map_saver() {
    let cells = cells_of_row(grey_row(&[254, 0, 205]), "mode: trinary");
    assert_eq!(cells, [0, 100, UNKNOWN]);
}

#[test]
fn trinary_mode_applies_the_free_threshold_to_grey_205() {
    assert_eq!(cells_of_row(grey_row(&[205, 206]), ""), [UNKNOWN, 0]);
    assert_eq!(cells_of_row(grey_row(&[205, 204]), "free_thresh: 0.2"), [0, 0]);
    assert_eq!(cells_of_row(grey_row(&[203]), "free_thresh: 0.2"), [UNKNOWN]);
}

#[test]
fn thresholds_are_inclusive() {
    // Grey 255 and 0 are exactly occupancy 0 and 1.
    let lines = "free_thresh: 0.0\noccupied_thresh: 1.0";
    assert_eq!(cells_of_row(grey_row(&[255, 254, 1, 0]), lines), [0, UNKNOWN, UNKNOWN, 100]);
}

#[test]
fn negate_makes_white_the_obstacle() {
    for negate in ["1", "true", "yes"] {
        let lines = format!("negate: {negate}");
        assert_eq!(cells_of_row(grey_row(&[254, 0, 128]), &lines), [100, 0, UNKNOWN], "{lines}");
    }
    for negate in ["0", "false", "off"] {
        let lines = format!("negate: {negate}");
        assert_eq!(cells_of_row(grey_row(&[254, 0]), &lines), [0, 100], "{lines}");
    }
}

#[test]
fn scale_mode_interpolates_between_the_thresholds() {
    let lines = "mode: scale\nfree_thresh: 0.2\noccupied_thresh: 0.6";
    // p is 0, 0.2, 0.2039, 0.4, 0.5961, 0.6 and 1.
    let greys = grey_row(&[255, 204, 203, 153, 103, 102, 0]);
    assert_eq!(cells_of_row(greys, lines), [0, 0, 1, 50, 99, 100, 100]);
}

#[test]
fn raw_mode_reads_percentages() {
    let greys = [0, 1, 99, 100, 101, 128, 255];
    let cells = cells_of_row(grey_row(&greys), "mode: raw\nnegate: 1");
    assert_eq!(cells, [0, 1, 99, 100, UNKNOWN, UNKNOWN, UNKNOWN]);
}

#[test]
fn mode_is_case_insensitive() {
    assert_eq!(cells_of_row(grey_row(&[77]), "mode: RAW"), [77]);
}

#[test]
fn transparent_pixels_are_unknown_except_in_raw_mode() {
    let image = GrayAlphaImage::from_raw(4, 1, vec![0, 255, 0, 254, 255, 255, 50, 0]).unwrap();
    for mode in ["trinary", "scale"] {
        let cells = cells_of_row(image.clone(), &format!("mode: {mode}"));
        assert_eq!(cells, [100, UNKNOWN, 0, UNKNOWN], "{mode}");
    }
    assert_eq!(cells_of_row(image, "mode: raw"), [0, 0, UNKNOWN, 50]);
    let colored = RgbaImage::from_raw(2, 1, vec![0, 0, 0, 255, 0, 0, 0, 0]).unwrap();
    assert_eq!(cells_of_row(colored, ""), [100, UNKNOWN]);
}

#[test]
fn colors_are_converted_to_luma() {
    // Luma of pure red, green and blue: 76, 150, 29. An average would make all three 85.
    let image = RgbImage::from_raw(3, 1, vec![255, 0, 0, 0, 255, 0, 0, 0, 255]).unwrap();
    assert_eq!(cells_of_row(image, "mode: raw"), [76, UNKNOWN, 29]);
    let greys = RgbImage::from_fn(101, 1, |x, _| image::Rgb([x as u8; 3]));
    let percent: Vec<i8> = (0..=100).collect();
    assert_eq!(cells_of_row(greys, "mode: raw"), percent);
}

#[test]
fn bottom_image_row_is_row_zero() {
    let folder = Folder::new();
    let image = GrayImage::from_raw(2, 3, vec![10, 11, 20, 21, 30, 31]).unwrap();
    folder.write_image("map.pgm", image);
    let grid = folder.load_yaml("map.pgm", "mode: raw").unwrap();
    assert_eq!(grid.cells(), [30, 31, 20, 21, 10, 11]);
    assert_eq!((grid.frame().width, grid.frame().height), (2, 3));
}

#[test]
fn resolution_and_origin_define_the_frame() {
    let folder = Folder::new();
    folder.write_image("map.pgm", GrayImage::new(4, 2));
    let lines = format!("resolution: 5e-1\norigin: [1, -2.5, {FRAC_PI_2}] # a comment");
    let grid = folder.load_yaml("map.pgm", &lines).unwrap();
    let frame = grid.frame();
    let origin = Pose::new(1.0, -2.5, FRAC_PI_2);
    assert_eq!(frame, &GridFrame::new(4, 2, 0.5, origin).unwrap());
    // The grid is turned to the left: its x axis points along the map's y.
    let center = frame.center_of(Cell::new(3, 0));
    assert!((center - Point::new(0.75, -0.75)).norm() < 1e-12);
}

#[test]
fn map_yaml_ignores_unknown_keys() {
    let extra = "map_version: 3\nlayers: {a: [1, 2]}\nwidth: 1";
    assert_eq!(cells_of_row(grey_row(&[0]), extra), [100]);
}

/// Grey values 0, 51 and 102 in every supported image format.
#[test]
fn all_supported_image_formats_are_read() {
    let binary = |header: &str, data: &[u8]| [header.as_bytes(), data].concat();
    let palette: &[u8] = &[0, 0, 0, 51, 51, 51, 102, 102, 102];
    let files = [
        ("p2.pgm", b"P2\n# by hand\n3 1\n255\n0 51\n102\n".to_vec()),
        ("p5.pgm", binary("P5 3 1 255\n", &[0, 51, 102])),
        ("of_100.pgm", b"P2 3 1 100 0 20 40".to_vec()),
        ("p2_16.pgm", b"P2 3 1 65535 0 13107 26214".to_vec()),
        ("p5_16.pgm", binary("P5 3 1 65535\n", &[0, 0, 0x33, 0x33, 0x66, 0x66])),
        ("p6.ppm", binary("P6 3 1 255\n", &[0, 0, 0, 51, 51, 51, 102, 102, 102])),
        ("grey.png", png((3, 1), 8, 0, &[], &[vec![0, 51, 102]])),
        ("grey_16.png", png((3, 1), 16, 0, &[], &[vec![0, 0, 0x33, 0x33, 0x66, 0x66]])),
        ("grey_4.png", png((3, 1), 4, 0, &[], &[vec![0x03, 0x60]])),
        ("palette.png", png((3, 1), 8, 3, &[(b"PLTE", palette)], &[vec![0, 1, 2]])),
        ("palette_2.png", png((3, 1), 2, 3, &[(b"PLTE", palette)], &[vec![0b0001_1000]])),
        ("a_png_named.pgm", png((3, 1), 8, 0, &[], &[vec![0, 51, 102]])),
    ];
    let folder = Folder::new();
    for (name, bytes) in files {
        folder.write(name, bytes);
        let grid = folder.load_yaml(name, "mode: raw").unwrap();
        assert_eq!(grid.cells(), [0, 51, UNKNOWN], "{name}");
        let grid =
            folder.load_yaml(name, "mode: scale\nfree_thresh: 0.0\noccupied_thresh: 1.0").unwrap();
        assert_eq!(grid.cells(), [100, 80, 60], "{name}");
    }
}

#[test]
fn one_bit_images_are_read() {
    let folder = Folder::new();
    folder.write("one_bit.png", png((3, 2), 1, 0, &[], &[vec![0b0100_0000], vec![0b1010_0000]]));
    let image = GrayImage::from_raw(3, 2, vec![0, 255, 0, 255, 0, 255]).unwrap();
    folder.write_image("of_8_bits.bmp", image);
    folder.write("one_bit.pbm", b"P1 3 2\n1 0 1\n0 1 0\n");
    for name in ["one_bit.png", "of_8_bits.bmp", "one_bit.pbm"] {
        let grid = folder.load_yaml(name, "").unwrap();
        assert_eq!(grid.cells(), [0, 100, 0, 100, 0, 100], "{name}");
    }
}

#[test]
fn transparent_palette_entries_are_unknown() {
    let folder = Folder::new();
    let chunks: [(&[u8; 4], &[u8]); 2] = [(b"PLTE", &[0, 0, 0, 255, 255, 255]), (b"tRNS", &[128])];
    folder.write("map.png", png((2, 1), 8, 3, &chunks, &[vec![0, 1]]));
    let grid = folder.load_yaml("map.png", "").unwrap();
    assert_eq!(grid.cells(), [UNKNOWN, 0]);
}

#[test]
fn sixteen_bit_images_are_rounded_to_eight() {
    let image: ImageBuffer<Luma<u16>, _> =
        ImageBuffer::from_raw(4, 1, vec![257 * 7 - 129, 257 * 7 - 128, 257 * 7 + 128, 65_535])
            .unwrap();
    assert_eq!(cells_of_row(image, "mode: raw"), [6, 7, 7, UNKNOWN]);
}

#[test]
fn from_rows_reads_from_the_largest_y_down() {
    let origin = Pose::new(-1.0, 2.0, 0.0);
    let grid = OccupancyGrid::from_rows(&["#.?", ".. "], 0.5, origin).unwrap();
    assert_eq!(grid.cells(), [0, 0, 0, 100, 0, UNKNOWN]);
    assert_eq!(grid.frame(), &GridFrame::new(3, 2, 0.5, origin).unwrap());
    assert!(!grid.obstacles(UnknownPolicy::Free).is_blocked(Cell::new(2, 1)));
    assert!(grid.obstacles(UnknownPolicy::Blocked).is_blocked(Cell::new(2, 1)));
}

#[test]
fn text_maps_accept_any_line_end_and_a_byte_order_mark() {
    let folder = Folder::new();
    let options = LoadOptions { resolution_m: 0.25 };
    for text in ["##\n.#", "##\n.#\n", "##\r\n.#\r\n\r\n", "\u{feff}##\n.#\n\n\n"] {
        let grid = load(&folder.write("map.txt", text), &options).unwrap();
        assert_eq!(grid.cells(), [0, 100, 100, 100], "{text:?}");
        let frame = GridFrame::new(2, 2, 0.25, Pose::default()).unwrap();
        assert_eq!(grid.frame(), &frame);
    }
}

const OCTILE: &str = "type octile\nheight 2\nwidth 7\nmap\n.G@OTSW\n@@@@@@.\n";

#[test]
fn movingai_map_rows_are_read_top_down() {
    let folder = Folder::new();
    let options = LoadOptions { resolution_m: 2.0 };
    for (name, text) in [
        ("arena.map", OCTILE.to_owned()),
        ("ARENA.MAP", OCTILE.replace('\n', "\r\n")),
        ("arena.octile", OCTILE.to_owned()),
        ("swapped.map", OCTILE.replace("height 2\nwidth 7", "width 7\nheight 2") + "\n\n"),
    ] {
        let grid = load(&folder.write(name, text), &options).unwrap();
        let low = [100, 100, 100, 100, 100, 100, 0];
        let high = [0, 0, 100, 100, 100, 0, 100];
        assert_eq!(grid.cells(), [low, high].concat(), "{name}");
        let frame = GridFrame::new(7, 2, 2.0, Pose::default()).unwrap();
        assert_eq!(grid.frame(), &frame);
        let top_left = cell_from_top_left(grid.frame(), (0, 0));
        assert_eq!(top_left, Cell::new(0, 1));
        assert_eq!(cell_from_top_left(grid.frame(), (6, 1)), Cell::new(6, 0));
        let outside = cell_from_top_left(grid.frame(), (0, i32::MIN));
        assert!(!grid.frame().contains(outside));
    }
}

#[test]
fn scen_fields_are_separated_by_tabs_or_spaces() {
    let folder = Folder::new();
    let tabs = "version 1\n0\tdao/my map.map\t49\t48\t1\t11\t48\t47\t7.41421\n\n";
    let path = folder.write("tabs.map.scen", tabs);
    let expected = Scenario {
        line: 2,
        bucket: 0,
        map: "dao/my map.map".into(),
        width: 49,
        height: 48,
        start: (1, 11),
        goal: (48, 47),
        optimal: 7.41421,
        rounding: 5e-6,
    };
    assert_eq!(read_scen(&path).unwrap(), vec![expected.clone()]);
    let spaces = "3 AR.map 49 48 1 11 48 47 7.41421\n\n9 AR.map 49 48 0 0 0 0 0\n\n\n";
    let path = folder.write("spaces.scen", spaces);
    let scenarios = read_scen(&path).unwrap();
    let named = Scenario { line: 1, bucket: 3, map: "AR.map".into(), ..expected };
    assert_eq!(scenarios[0], named);
    assert_eq!((scenarios[1].bucket, scenarios[1].optimal), (9, 0.0));
}
