//! Renders SVG pictures as PNG, with the same pixels on every machine: the font is part of the program.

use std::sync::{Arc, LazyLock};

use png_codec::{BitDepth, ColorType, Encoder, EncodingError};
use resvg::render;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::fontdb::Database;
use resvg::usvg::{Options, Tree};
use thiserror::Error;

/// The font family in the program.
const FAMILY: &str = "DejaVu Sans";

/// An SVG picture that cannot be rendered.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("the picture cannot be rendered: {0}")]
pub struct PngError(String);

impl PngError {
    pub(super) fn too_large(width_px: u32, height_px: u32) -> Self {
        Self(format!("an image of {width_px} x {height_px} pixels is not possible"))
    }
}

/// Returns an SVG picture as a PNG file of a width. Its height follows from the aspect of the picture. The text chunk `Software`
/// names this program.
///
/// # Errors
/// Fails if the text is no SVG picture, or the image does not fit into the memory.
pub fn png(svg: &str, width_px: u32) -> Result<Vec<u8>, PngError> {
    let tree = Tree::from_str(svg, &options()).map_err(|error| PngError(error.to_string()))?;
    let scale = width_px as f32 / tree.size().width();
    let height_px = (tree.size().height() * scale).ceil() as u32;
    let mut pixels =
        Pixmap::new(width_px, height_px).ok_or_else(|| PngError::too_large(width_px, height_px))?;
    render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    encode(pixels).map_err(|error| PngError(error.to_string()))
}

/// Draws an SVG picture over an image, at its own size.
pub(super) fn draw_svg(svg: &str, pixels: &mut Pixmap) -> Result<(), PngError> {
    let tree = Tree::from_str(svg, &options()).map_err(|error| PngError(error.to_string()))?;
    render(&tree, Transform::identity(), &mut pixels.as_mut());
    Ok(())
}

fn encode(pixels: Pixmap) -> Result<Vec<u8>, EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, pixels.width(), pixels.height());
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(BitDepth::Eight);
    encoder.add_text_chunk("Software".to_owned(), "inbye".to_owned())?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels.take_demultiplied())?;
    writer.finish()?;
    Ok(bytes)
}

/// Options with the program's own font and no others.
fn options() -> Options<'static> {
    static FONTS: LazyLock<Arc<Database>> = LazyLock::new(|| {
        let mut fonts = Database::new();
        fonts.load_font_data(dejavu::sans::regular().to_vec());
        fonts.load_font_data(dejavu::sans::bold().to_vec());
        fonts.set_sans_serif_family(FAMILY);
        Arc::new(fonts)
    });
    Options { font_family: FAMILY.to_owned(), fontdb: Arc::clone(&FONTS), ..Options::default() }
}
