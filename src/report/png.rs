//! An SVG picture as pixels, the same on every machine: its letters come with the program.

use std::sync::Arc;

use resvg::render;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::fontdb::Database;
use resvg::usvg::{Options, Tree};
use thiserror::Error;

/// The family whose letters come with the program.
const FAMILY: &str = "DejaVu Sans";

/// A picture that cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("the picture cannot be drawn: {0}")]
pub struct PngError(String);

/// The pixels of an SVG picture as a PNG file, so many wide and as high as its shape asks.
///
/// # Errors
/// When the text is no SVG picture, or its pixels are too many for the memory.
pub fn png(svg: &str, width_px: u32) -> Result<Vec<u8>, PngError> {
    let tree = Tree::from_str(svg, &options()).map_err(|error| PngError(error.to_string()))?;
    let scale = width_px as f32 / tree.size().width();
    let height_px = (tree.size().height() * scale).ceil() as u32;
    let mut pixels = Pixmap::new(width_px, height_px)
        .ok_or_else(|| PngError(format!("{width_px} x {height_px} pixels are no size")))?;
    render(
        &tree,
        Transform::from_scale(scale, scale),
        &mut pixels.as_mut(),
    );
    pixels
        .encode_png()
        .map_err(|error| PngError(error.to_string()))
}

/// The program's own letters and no others, whatever is installed.
fn options() -> Options<'static> {
    let mut letters = Database::new();
    letters.load_font_data(dejavu::sans::regular().to_vec());
    letters.load_font_data(dejavu::sans::bold().to_vec());
    letters.set_sans_serif_family(FAMILY);
    Options {
        font_family: FAMILY.to_owned(),
        fontdb: Arc::new(letters),
        ..Options::default()
    }
}
