//! Maps of random pixels in every image format, with all modes and thresholds.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::hand_png::png;

/// An image format, or the text map.
pub struct Kind {
    /// Name of the format.
    pub name: &'static str,
    extension: &'static str,
    encode: fn(&mut Pcg64Mcg) -> Vec<u8>,
}

const WIDTH: usize = 61;
const HEIGHT: usize = 47;
const SIZE: (u32, u32) = (WIDTH as u32, HEIGHT as u32);

/// All formats; the first is the simplest.
pub const KINDS: [Kind; 12] = [
    kind("grey pgm", "pgm", |random| {
        [b"P5\n# random\n61 47\n255\n".to_vec(), bytes(random, WIDTH * HEIGHT)].concat()
    }),
    kind("grey pgm in digits", "pgm", |random| {
        let digits: Vec<String> = bytes(random, WIDTH * HEIGHT).iter().map(u8::to_string).collect();
        format!("P2 61 47 255\n{}\n", digits.join("\n")).into()
    }),
    kind("grey pgm of 16 bits", "pgm", |random| {
        [b"P5 61 47 65535\n".to_vec(), bytes(random, 2 * WIDTH * HEIGHT)].concat()
    }),
    // An odd maximum, since the two readers round a half of an even one to different sides.
    kind("grey pgm up to 101", "pgm", |random| {
        let greys = (0..WIDTH * HEIGHT).map(|_| random.random_range(0..=101));
        b"P5 61 47 101\n".iter().copied().chain(greys).collect()
    }),
    kind("grey png", "png", |random| png(SIZE, 8, 0, &[], &rows(random, WIDTH))),
    kind("grey png of 16 bits", "png", |random| png(SIZE, 16, 0, &[], &rows(random, 2 * WIDTH))),
    kind("grey png with alpha", "png", |random| {
        png(SIZE, 8, 4, &[], &opaque_for_half(rows(random, 2 * WIDTH), 2))
    }),
    kind("color png", "png", |random| png(SIZE, 8, 2, &[], &rows(random, 3 * WIDTH))),
    kind("color png with alpha", "png", |random| {
        png(SIZE, 8, 6, &[], &opaque_for_half(rows(random, 4 * WIDTH), 4))
    }),
    kind("palette png with alpha", "png", |random| {
        let colors = bytes(random, 3 * 256);
        let alphas = opaque_for_half(vec![bytes(random, 256)], 1).concat();
        let chunks: [(&[u8; 4], &[u8]); 2] = [(b"PLTE", &colors), (b"tRNS", &alphas)];
        png(SIZE, 8, 3, &chunks, &rows(random, WIDTH))
    }),
    kind("png of single bits", "png", |random| {
        png(SIZE, 1, 0, &[], &rows(random, WIDTH.div_ceil(8)))
    }),
    kind("movingai", "map", |random| {
        let characters = b".G@OTSW";
        let mut text = b"type octile\nheight 47\nwidth 61\nmap\n".to_vec();
        for _ in 0..HEIGHT {
            text.extend((0..WIDTH).map(|_| characters[random.random_range(0..7)]));
            text.push(b'\n');
        }
        text
    }),
];

const fn kind(
    name: &'static str,
    extension: &'static str,
    encode: fn(&mut Pcg64Mcg) -> Vec<u8>,
) -> Kind {
    Kind { name, extension, encode }
}

impl Kind {
    /// Writes an image to a folder, with a YAML file for each combination of settings. Returns the maps to load, in order.
    pub fn write(&self, folder: &Path) -> io::Result<Vec<PathBuf>> {
        let mut random = Pcg64Mcg::seed_from_u64(2_026);
        let image = folder.join(format!("random.{}", self.extension));
        fs::write(&image, (self.encode)(&mut random))?;
        if self.extension == "map" {
            return Ok(vec![image]);
        }
        let thresholds = [(0.65, 0.196), (0.65, 0.25), (0.8, 0.2), (1.0, 0.0)];
        let mut maps = Vec::new();
        for mode in ["", "mode: trinary", "mode: scale", "mode: raw"] {
            for negate in ["0", "1", "true", "false"] {
                for (occupied, free) in thresholds {
                    let [x, y, yaw] = [(); 3].map(|()| random.random_range(-30.0..30.0));
                    let resolution: f64 = random.random_range(1e-5..1.0);
                    let text = format!(
                        "# made by a test\nimage: random.{}\n{mode}\nresolution: {resolution:e} # metres\n\
                         origin: [{x}, {y}, {yaw:e}]\nnegate: {negate}\noccupied_thresh: {occupied}\n\
                         free_thresh: {free}\n",
                        self.extension
                    );
                    let map = folder.join(format!("{}.yaml", maps.len()));
                    fs::write(&map, text)?;
                    maps.push(map);
                }
            }
        }
        Ok(maps)
    }
}

fn bytes(random: &mut Pcg64Mcg, count: usize) -> Vec<u8> {
    let mut bytes = vec![0; count];
    random.fill_bytes(&mut bytes);
    bytes
}

fn rows(random: &mut Pcg64Mcg, count: usize) -> Vec<Vec<u8>> {
    (0..HEIGHT).map(|_| bytes(random, count)).collect()
}

/// Makes every second pixel opaque; alpha is the last byte of a pixel.
fn opaque_for_half(mut rows: Vec<Vec<u8>>, pixel_bytes: usize) -> Vec<Vec<u8>> {
    for row in &mut rows {
        for pixel in row.chunks_exact_mut(pixel_bytes).step_by(2) {
            pixel[pixel_bytes - 1] = 255;
        }
    }
    rows
}
