//! The cells of an occupancy grid as a PNG image inside a drawing.

use std::ops::Range;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use png_codec::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter};

use crate::map::{OCCUPIED_THRESHOLD, OccupancyGrid, UNKNOWN};

/// Grey of obstacles and of unknown cells. Free cells are transparent.
const OBSTACLE_GREY: u8 = 0x70;
const UNKNOWN_GREY: u8 = 0xb8;

/// Steps of opacity. An image of few values compresses well.
const OPACITY_STEPS: u32 = 15;

/// An image of a part of a grid, one pixel for each block of cells, lowest row first.
pub(crate) struct Raster {
    /// PNG as a data URI.
    pub(crate) data_uri: String,
    /// Pixels along the columns.
    pub(crate) width: i32,
    /// Pixels along the rows.
    pub(crate) height: i32,
    /// Cells along each side of a block.
    pub(crate) block: i32,
}

impl Raster {
    /// Draws the cells of some columns and rows. Both ranges are inside the grid and not empty. The opacity of a block is
    /// its share of cells that are not free. The longer side has at most `max_side` pixels.
    pub(crate) fn new(
        map: &OccupancyGrid,
        columns: Range<i32>,
        rows: Range<i32>,
        max_side: i32,
    ) -> Self {
        let longest = (columns.end - columns.start).max(rows.end - rows.start);
        let block = (longest + max_side - 1) / max_side;
        let blocks = |range: &Range<i32>| (range.end - range.start + block - 1) / block;
        let (width, height) = (blocks(&columns), blocks(&rows));
        let mut pixels = Vec::with_capacity(2 * width as usize * height as usize);
        for row in rows.clone().step_by(block as usize) {
            for column in columns.clone().step_by(block as usize) {
                let across = column..(column + block).min(columns.end);
                let up = row..(row + block).min(rows.end);
                pixels.extend(grey_and_opacity(map, across, up));
            }
        }
        Self { data_uri: data_uri(&pixels, width, height), width, height, block }
    }
}

fn grey_and_opacity(map: &OccupancyGrid, columns: Range<i32>, rows: Range<i32>) -> [u8; 2] {
    let stride = map.frame().width as usize;
    let (mut occupied, mut unknown, mut all) = (0_u32, 0_u32, 0_u32);
    for row in rows {
        let start = row as usize * stride;
        for &cell in &map.cells()[start + columns.start as usize..start + columns.end as usize] {
            occupied += u32::from(cell >= OCCUPIED_THRESHOLD);
            unknown += u32::from(cell == UNKNOWN);
            all += 1;
        }
    }
    let opacity = ((occupied + unknown) * OPACITY_STEPS + all / 2) / all * (255 / OPACITY_STEPS);
    let grey = if occupied >= unknown { OBSTACLE_GREY } else { UNKNOWN_GREY };
    [grey, opacity as u8]
}

fn data_uri(pixels: &[u8], width: i32, height: i32) -> String {
    let encoded = png(pixels, width as u32, height as u32);
    let png = encoded.expect("the number of pixels matches, and writing to memory never fails");
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

fn png(pixels: &[u8], width: u32, height: u32) -> Result<Vec<u8>, EncodingError> {
    let mut png = Vec::new();
    let mut encoder = Encoder::new(&mut png, width, height);
    encoder.set_color(ColorType::GrayscaleAlpha);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::High);
    encoder.set_filter(Filter::NoFilter);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(png)
}
