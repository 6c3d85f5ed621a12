//! Maps of ROS `map_server`: an image and a YAML file that describes it.
//!
//! The interpretation follows Nav2's `map_io.cpp` (2026). A grey value g of 0..=255 has the occupancy p = 1 - g/255, or
//! g/255 with `negate`. Cells with p at or above `occupied_thresh` are 100; cells with p at or below `free_thresh` are 0.
//! Between the thresholds, a cell is unknown in mode `trinary` and round(100 (p - free) / (occupied - free)) in mode
//! `scale`; a pixel with any transparency is unknown in both. In mode `raw` the grey value is the percentage itself, and
//! unknown above 100; `negate`, thresholds and transparency are ignored. The bottom row of the image is row 0 of the
//! grid.
//!
//! Colours are converted to luma, as in current Nav2; older releases averaged the three channels. Nav2 computes p in
//! single precision, this module in double. The two may differ where p equals a threshold up to rounding.

use std::env;
use std::path::{Path, PathBuf};

use super::image::{GreyImage, Pixel};
use super::map_yaml::{MapYaml, Mode};
use super::{GridFrame, MapError, MapWarning, OccupancyGrid, UNKNOWN};

/// Reads a map from the text of its YAML file and the image that the text names.
pub(super) fn read(
    yaml_path: &Path,
    text: &str,
    warn: &mut dyn FnMut(MapWarning),
) -> Result<OccupancyGrid, MapError> {
    let mut yaml = MapYaml::parse(text)?;
    yaml.warnings.drain(..).for_each(warn);
    let image_path = image_path(yaml_path, &yaml.image, env::home_dir().as_deref());
    let image = GreyImage::read(&image_path).map_err(|problem| MapError::InImage {
        line: yaml.image_line,
        image: image_path,
        problem: Box::new(problem),
    })?;
    grid(&yaml, &image)
}

impl OccupancyGrid {
    /// Reads a ROS `map_server` map from memory: the text of the YAML file and the bytes of its PGM, PNG or BMP image.
    /// The image path in the YAML text is required but not opened.
    ///
    /// # Errors
    /// Returns an error if the text or the image is invalid; the message names the place.
    pub fn from_map_server(yaml: &str, image: &[u8]) -> Result<Self, MapError> {
        grid(&MapYaml::parse(yaml)?, &GreyImage::decode(image)?)
    }
}

fn grid(yaml: &MapYaml, image: &GreyImage) -> Result<OccupancyGrid, MapError> {
    let frame = GridFrame::new(image.width, image.height, yaml.resolution_m, yaml.origin)?;
    let cells: Vec<i8> = occupancies(yaml, &image.pixels);
    Ok(OccupancyGrid::from_top_down(frame, &cells))
}

/// The path of an image: relative to the YAML file, unless it is absolute or in the home directory (`~/`).
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
    let occupancy = f64::from(grey) / 255.0;
    let occupancy = if yaml.negate { occupancy } else { 1.0 - occupancy };
    let (free, occupied) = (yaml.free_thresh, yaml.occupied_thresh);
    match yaml.mode {
        Mode::Raw => i8::try_from(grey).ok().filter(|&percent| percent <= 100).unwrap_or(UNKNOWN),
        _ if occupancy >= occupied => 100,
        _ if occupancy <= free => 0,
        Mode::Trinary => UNKNOWN,
        Mode::Scale => ((occupancy - free) / (occupied - free) * 100.0).round() as i8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn image_path_is_relative_to_the_yaml_file_or_the_home_directory() {
        let resolved =
            |image| image_path(Path::new("maps/mine.yaml"), image, Some(Path::new("/home/me")));
        assert_eq!(resolved("mine.png"), Path::new("maps/mine.png"));
        assert_eq!(resolved("scans/mine.png"), Path::new("maps/scans/mine.png"));
        assert_eq!(resolved("/data/mine.png"), Path::new("/data/mine.png"));
        assert_eq!(resolved("~/mine.png"), Path::new("/home/me/mine.png"));
        let without_home = image_path(Path::new("maps/mine.yaml"), "~/mine.png", None);
        assert_eq!(without_home, Path::new("maps/~/mine.png"));
    }
}
