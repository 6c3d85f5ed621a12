//! A map that a command writes: a `.yaml` of ROS's `map_server` and its image.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use inbye::map::OccupancyGrid;

use super::files::create_file;

/// The files of a map. They are created before the work: a wrong name must not cost it.
pub struct MapOutput<'a> {
    flag: &'static str,
    name: &'a Path,
    yaml: File,
    image_name: PathBuf,
    image: File,
}

impl<'a> MapOutput<'a> {
    /// Creates the files. `flag` is the argument with the name.
    pub fn create(flag: &'static str, name: &'a Path) -> anyhow::Result<Self> {
        let extension = name.extension().unwrap_or_default();
        ensure!(
            extension == "yaml" || extension == "yml",
            "{flag} {}: the name must end in .yaml or .yml",
            name.display()
        );
        let image_name = name.with_extension("pgm");
        let (yaml, image) = (create_file(flag, name)?, create_file(flag, &image_name)?);
        Ok(Self { flag, name, yaml, image_name, image })
    }

    /// Writes a map; returns the name of its image.
    pub fn write(mut self, map: &OccupancyGrid) -> anyhow::Result<PathBuf> {
        let image = self.image_name.file_name().unwrap_or_default().to_string_lossy();
        let (yaml, pgm) = map.to_map_server(&image);
        let place = || format!("{} {}", self.flag, self.name.display());
        self.yaml.write_all(yaml.as_bytes()).with_context(place)?;
        self.image.write_all(&pgm).with_context(place)?;
        Ok(self.image_name)
    }
}
