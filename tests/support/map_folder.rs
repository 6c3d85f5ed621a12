//! A temporary folder of map files.

use std::fs;
use std::path::PathBuf;

use image::DynamicImage;
use inbye::map::{LoadOptions, MapError, OccupancyGrid, load};
use tempfile::TempDir;

/// The folder; it is removed when this is dropped.
pub struct Folder(TempDir);

impl Folder {
    /// Creates an empty folder.
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a place for temporary files"))
    }

    /// The path of a file in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file and returns its path.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, bytes).expect("the folder can be written to");
        path
    }

    /// Writes an image in the format of its extension.
    pub fn write_image(&self, name: &str, image: impl Into<DynamicImage>) {
        let saved = image.into().save(self.path(name));
        saved.expect("the format holds such pixels");
    }

    /// Writes `map.yaml` with these lines for an existing image, and loads it. Keys that the lines omit
    /// have common values.
    pub fn load_yaml(&self, image: &str, lines: &str) -> Result<OccupancyGrid, MapError> {
        let usual = [
            "resolution: 0.05",
            "origin: [0.0, 0.0, 0.0]",
            "negate: 0",
            "occupied_thresh: 0.65",
            "free_thresh: 0.196",
        ];
        let given = |line: &&&str| {
            let key = line.split(':').next().unwrap_or_default();
            !lines.contains(&format!("{key}:"))
        };
        let left_out: Vec<&str> = usual.iter().filter(given).copied().collect();
        let text = format!("image: {image}\n{lines}\n{}\n", left_out.join("\n"));
        load(&self.write("map.yaml", text), &LoadOptions::default())
    }
}
