//! The BMP and Netpbm decoders, compared with those of the `image` crate on random images.

use image::DynamicImage;
use inbye::map::{OccupancyGrid, UNKNOWN};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const YAML: &str = "image: map.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n\
                    occupied_thresh: 1.0\nfree_thresh: 0.0\nmode: scale\n";

/// Occupancy of an image decoded by the `image` crate, in the order of the grid; none if it does not decode.
fn reference(bytes: &[u8]) -> Option<Vec<i8>> {
    let image = image::load_from_memory(bytes).ok()?;
    let occupancy = |grey: u8, alpha: u8| match alpha {
        u8::MAX => ((1.0 - f64::from(grey) / 255.0) * 100.0).round() as i8,
        _ => UNKNOWN,
    };
    let (width, cells): (u32, Vec<i8>) = match image {
        DynamicImage::ImageLuma8(image) => {
            let cells = image.pixels().map(|pixel| occupancy(pixel.0[0], u8::MAX));
            (image.width(), cells.collect())
        }
        image => {
            let image = image.into_rgba8();
            let cells = image.pixels().map(|pixel| {
                let [red, green, blue, alpha] = pixel.0.map(u32::from);
                let luma = (19_595 * red + 38_470 * green + 7_471 * blue + 0x8000) >> 16;
                occupancy(luma as u8, alpha as u8)
            });
            (image.width(), cells.collect())
        }
    };
    let rows = cells.chunks_exact(width as usize).rev();
    Some(rows.flatten().copied().collect())
}

/// Compares valid images, and damaged copies that still decode.
fn compare(mut make: impl FnMut(&mut Pcg64Mcg) -> Vec<u8>) {
    let cells = |bytes: &[u8]| {
        let grid = OccupancyGrid::from_map_server(YAML, bytes).ok()?;
        Some(grid.cells().to_vec())
    };
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let mut decoded = 0;
    for _ in 0..600 {
        let mut bytes = make(&mut random);
        assert_eq!(cells(&bytes), reference(&bytes), "{bytes:02x?}");
        decoded += u32::from(cells(&bytes).is_some());
        let place = random.random_range(0..bytes.len());
        bytes[place] = random.random();
        if let Some(cells) = cells(&bytes) {
            assert_eq!(Some(cells), reference(&bytes), "{bytes:02x?}");
        }
    }
    assert!(decoded > 400, "{decoded} of 600 images were decoded");
}

fn bytes(random: &mut Pcg64Mcg, count: usize) -> Vec<u8> {
    (0..count).map(|_| random.random()).collect()
}

#[test]
fn bmp_images_equal_the_reference_decoder() {
    const KINDS: [(u32, u16); 11] = [
        (0, 1),
        (0, 2),
        (0, 4),
        (0, 8),
        (0, 16),
        (0, 24),
        (0, 32),
        (1, 8),
        (2, 4),
        (3, 16),
        (3, 32),
    ];
    compare(|random| {
        let (width, height) = (random.random_range(1..20_i32), random.random_range(1..8_i32));
        let (compression, bits) = KINDS[random.random_range(0..KINDS.len())];
        let size: u32 = [40, 56, 108, 124][random.random_range(0..4)];
        let is_run_length = matches!(compression, 1 | 2);
        let is_top_down = !is_run_length && random.random_bool(0.3);
        let palette = if bits <= 8 { 4 << bits } else { 0 };
        let pixels_at = 14 + size.max(56) + palette;
        let mut file = [&b"BM\0\0\0\0\0\0\0\0"[..], &pixels_at.to_le_bytes()].concat();
        let signed_height = if is_top_down { -height } else { height };
        file.extend(
            [size.to_le_bytes(), width.to_le_bytes(), signed_height.to_le_bytes()].concat(),
        );
        file.extend([1_u16.to_le_bytes(), bits.to_le_bytes()].concat());
        file.extend(compression.to_le_bytes());
        file.extend([0; 20]);
        let masks: [u32; 4] = match bits {
            16 => [0xf800, 0x07e0, 0x001f, 0],
            _ => [0x00ff_0000, 0x0000_ff00, 0x0000_00ff, 0xff00_0000],
        };
        file.extend(masks.map(u32::to_le_bytes).concat());
        file.resize(14 + size.max(56) as usize, 0);
        if bits <= 8 {
            file.truncate(14 + size as usize);
        }
        file.extend(bytes(random, pixels_at as usize - file.len()));
        let stride = (width as usize * usize::from(bits)).div_ceil(32) * 4;
        if is_run_length {
            for _ in 0..random.random_range(1..40) {
                file.extend([random.random_range(1..12), random.random()]);
                file.extend(random.random_bool(0.3).then_some([0, 0]).into_iter().flatten());
            }
            file.extend([0, 1]);
        } else {
            file.extend(bytes(random, stride * height as usize));
        }
        file
    });
}

#[test]
fn netpbm_images_equal_the_reference_decoder() {
    compare(|random| {
        let kind = random.random_range(1..=6);
        let (width, height) = (random.random_range(1..20_usize), random.random_range(1..6_usize));
        let max = [255, 65_535, random.random_range(1..65_536)][random.random_range(0..3)];
        let comment = ["\n", " ", "\r\n", "\n# 3 4\n"][random.random_range(0..4)];
        let mut file = format!("P{kind}{comment}{width} {height}\n").into_bytes();
        if kind != 1 && kind != 4 {
            file.extend(format!("{max}\n").bytes());
        }
        let samples = width * height * if kind % 3 == 0 { 3 } else { 1 };
        match kind {
            1 => file.extend((0..samples).map(|_| random.random_range(b'0'..=b'1'))),
            2 | 3 => {
                let text = (0..samples).map(|_| format!("{} ", random.random_range(0..=max)));
                file.extend(text.collect::<String>().bytes());
            }
            4 => file.extend(bytes(random, width.div_ceil(8) * height)),
            _ => file.extend(bytes(random, samples * if max > 255 { 2 } else { 1 })),
        }
        file
    });
}
