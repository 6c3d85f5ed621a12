//! Valid map files with bytes altered, removed or duplicated: each is read or rejected in one line, without a panic.

use crate::support::hand_png::png;
use crate::support::map_folder::Folder;
use image::GrayImage;
use inbye::map::{LoadOptions, MapError, OccupancyGrid, load, read_scen};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const CASES: usize = 1_500;

/// Applies one to four changes at random places, half of them in the first 64 bytes, where headers are.
fn damaged(valid: &[u8], random: &mut Pcg64Mcg) -> Vec<u8> {
    let mut bytes = valid.to_vec();
    for _ in 0..random.random_range(1..=4) {
        if bytes.is_empty() {
            break;
        }
        let reach = if random.random() { 64 } else { bytes.len() };
        let place = random.random_range(0..reach.min(bytes.len()));
        match random.random_range(0..5) {
            0 => bytes.truncate(place),
            1 => bytes[place] = random.random(),
            2 => bytes[place] = b'9',
            3 => drop(bytes.remove(place)),
            _ => bytes.insert(place, bytes[place]),
        }
    }
    bytes
}

/// Reads damaged copies of a file and checks the message of each rejection; at least some copies must be rejected.
fn read_damaged<T>(valid: &[u8], mut read: impl FnMut(&[u8]) -> Result<T, MapError>) {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    assert!(read(valid).is_ok());
    let mut refused = 0;
    for _ in 0..CASES {
        let bytes = damaged(valid, &mut random);
        if let Err(problem) = read(&bytes) {
            let message = problem.to_string();
            assert_eq!(message.lines().count(), 1, "{message}");
            refused += 1;
        }
    }
    assert!(refused > CASES / 10, "{refused} of {CASES} refused");
}

#[test]
fn damaged_yaml_never_panics() {
    let folder = Folder::new();
    folder.write_image("map.pgm", GrayImage::new(3, 3));
    let valid = b"image: map.pgm\nresolution: 0.05\norigin: [0.0, -1.0, 0.5]\nnegate: 0\n\
                  occupied_thresh: 0.65\nfree_thresh: 0.196\nmode: scale\n# end\n";
    read_damaged(valid, |bytes| load(&folder.write("map.yaml", bytes), &LoadOptions::default()));
}

#[test]
fn damaged_text_and_movingai_maps_never_panic() {
    let folder = Folder::new();
    let octile = b"type octile\nheight 3\nwidth 4\nmap\n.@.T\n....\nSW.G\n";
    for (name, valid) in [("map.txt", &b"####\n#.?#\n# .#\n"[..]), ("map.map", octile)] {
        read_damaged(valid, |bytes| load(&folder.write(name, bytes), &LoadOptions::default()));
    }
    let scen = b"version 1\n0\ta.map\t9\t9\t1\t2\t3\t4\t2.828\n1 a.map 9 9 0 0 8 8 11.3\n";
    read_damaged(scen, |bytes| read_scen(&folder.write("map.scen", bytes)));
}

#[test]
fn damaged_images_never_panic() {
    let folder = Folder::new();
    let load_image = |name: &str, bytes: &[u8]| -> Result<OccupancyGrid, MapError> {
        folder.write(name, bytes);
        folder.load_yaml(name, "")
    };
    let greys: Vec<u8> = (0..=255).collect();
    let rows: Vec<Vec<u8>> = greys.chunks(16).map(<[u8]>::to_vec).collect();
    let digits: Vec<String> = greys.iter().map(u8::to_string).collect();
    folder.write_image("valid.bmp", GrayImage::new(16, 16));
    let bmp = std::fs::read(folder.path("valid.bmp")).unwrap();
    let palette: [(&[u8; 4], &[u8]); 1] = [(b"PLTE", &greys[..255])];
    let images = [
        ("map.pgm", [b"P5 16 16 255\n", &greys[..]].concat()),
        ("digits.pgm", format!("P2 16 16 255\n{}", digits.join(" ")).into()),
        ("map.bmp", bmp),
        ("map.png", png((16, 16), 8, 0, &[], &rows)),
        ("palette.png", png((32, 16), 4, 3, &palette, &rows)),
    ];
    for (name, valid) in images {
        read_damaged(&valid, |bytes| load_image(name, bytes));
    }
}
