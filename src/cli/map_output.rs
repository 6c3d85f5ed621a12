//! A map that a command writes: a `.yaml` of ROS's `map_server` and its image.

use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use inbye::map::OccupancyGrid;

use super::files::{has_extension, open_file};
use super::own_file::OutputFile;

/// The files of a map. They are opened before the work: a wrong name must not cost it.
pub struct MapOutput<'a> {
    flag: &'static str,
    name: &'a Path,
    yaml: OutputFile,
    image_name: PathBuf,
    image: OutputFile,
}

impl<'a> MapOutput<'a> {
    /// Opens the files, which stay as they are until [`Self::write`]. `flag` is the argument with the name.
    pub fn create(flag: &'static str, name: &'a Path) -> anyhow::Result<Self> {
        ensure!(
            has_extension(name, "yaml") || has_extension(name, "yml"),
            "{flag} {}: the name must end in .yaml or .yml",
            name.display()
        );
        let image_name = name.with_extension("pgm");
        let (yaml, image) = (open_file(flag, name)?, open_file(flag, &image_name)?);
        Ok(Self { flag, name, yaml, image_name, image })
    }

    /// Writes a map; returns the name of its image.
    pub fn write(self, map: &OccupancyGrid) -> anyhow::Result<PathBuf> {
        let image = self.image_name.file_name().unwrap_or_default().to_string_lossy();
        let (yaml, pgm) = map.to_map_server(&image);
        let place = || format!("{} {}", self.flag, self.name.display());
        self.yaml.write(yaml.as_bytes()).with_context(place)?;
        self.image.write(&pgm).with_context(place)?;
        Ok(self.image_name)
    }
}
