//! Maps of ROS `map_server`: an image, and a YAML file that says what its pixels mean.
//!
//! The meaning is that of Nav2's `map_io.cpp` (2026): grey g of 0..=255 has the occupancy p = 1 - g/255, or g/255 with
//! `negate`. From `occupied_thresh` up a cell is 100, up to `free_thresh` it is 0. Between them it is unknown in mode
//! `trinary` and round(100 (p - free) / (occupied - free)) in mode `scale`; a pixel with any transparency is unknown
//! in both. In mode `raw` the grey is the percentage itself, and unknown above 100; `negate`, thresholds and
//! transparency mean nothing there. The bottom row of the image is row 0 of the grid.
//!
//! Colours are reduced to their luma, as Nav2 does now; older releases averaged the three channels. Nav2 computes
//! p in single precision and this file in double, so where p equals a threshold but for rounding the two may differ.

use std::env;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use super::grey_image::{GreyImage, Pixel};
use super::map_yaml::{MapYaml, Mode};
use super::{GridFrame, MapError, MapWarning, OccupancyGrid, UNKNOWN};

/// A map from the text of its YAML file and the image that it names.
pub(super) fn read(
    yaml_path: &Path,
    text: &str,
    note: &mut dyn FnMut(MapWarning),
) -> Result<OccupancyGrid, MapError> {
    let mut yaml = MapYaml::parse(text)?;
    yaml.notes.drain(..).for_each(note);
    let image_path = image_path(yaml_path, &yaml.image, env::home_dir().as_deref());
    let image = GreyImage::read(&image_path).map_err(|problem| MapError::InImage {
        line: yaml.image_line,
        image: image_path,
        problem: Box::new(problem),
    })?;
    grid(&yaml, &image)
}

impl OccupancyGrid {
    /// A map of ROS `map_server` that is in memory: the text of its YAML file, and the bytes of its PGM, PNG or BMP image.
    /// The path of the image that the YAML file must have is not looked at.
    ///
    /// # Errors
    /// When the text is not such a file, or the bytes are no such image; the message names the place.
    pub fn from_map_server(yaml: &str, image: &[u8]) -> Result<Self, MapError> {
        grid(
            &MapYaml::parse(yaml)?,
            &GreyImage::decode(Cursor::new(image))?,
        )
    }
}

fn grid(yaml: &MapYaml, image: &GreyImage) -> Result<OccupancyGrid, MapError> {
    let frame = GridFrame::new(image.width, image.height, yaml.resolution_m, yaml.origin)?;
    let cells: Vec<i8> = occupancies(yaml, &image.pixels);
    Ok(OccupancyGrid::from_top_down(frame, &cells))
}

/// The file of an image: relative to the YAML file, unless absolute or in the home directory (`~/`).
fn image_path(yaml_path: &Path, image: &str, home: Option<&Path>) -> PathBuf {
    match (image.strip_prefix("~/"), home) {
        (Some(rest), Some(home)) => home.join(rest),
        _ => yaml_path.with_file_name(image),
    }
}

fn occupancies(yaml: &MapYaml, pixels: &[Pixel]) -> Vec<i8> {
    let of_grey: [i8; 256] = core::array::from_fn(|grey| occupancy(yaml, grey as u8));
    let occupancy = |pixel: &Pixel| {
        if pixel.opaque || yaml.mode == Mode::Raw {
            of_grey[usize::from(pixel.grey)]
        } else {
            UNKNOWN
        }
    };
    pixels.iter().map(occupancy).collect()
}

/// The occupancy of an opaque pixel.
fn occupancy(yaml: &MapYaml, grey: u8) -> i8 {
    let share = f64::from(grey) / 255.0;
    let share = if yaml.negate { share } else { 1.0 - share };
    let (free, occupied) = (yaml.free_thresh, yaml.occupied_thresh);
    match yaml.mode {
        Mode::Raw => i8::try_from(grey)
            .ok()
            .filter(|&percent| percent <= 100)
            .unwrap_or(UNKNOWN),
        _ if share >= occupied => 100,
        _ if share <= free => 0,
        Mode::Trinary => UNKNOWN,
        Mode::Scale => ((share - free) / (occupied - free) * 100.0).round() as i8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_is_looked_for_beside_its_yaml_file_or_at_home() {
        let place = |image| {
            image_path(
                Path::new("maps/mine.yaml"),
                image,
                Some(Path::new("/home/me")),
            )
        };
        assert_eq!(place("mine.png"), Path::new("maps/mine.png"));
        assert_eq!(place("scans/mine.png"), Path::new("maps/scans/mine.png"));
        assert_eq!(place("/data/mine.png"), Path::new("/data/mine.png"));
        assert_eq!(place("~/mine.png"), Path::new("/home/me/mine.png"));
        let homeless = image_path(Path::new("maps/mine.yaml"), "~/mine.png", None);
        assert_eq!(homeless, Path::new("maps/~/mine.png"));
    }
}
