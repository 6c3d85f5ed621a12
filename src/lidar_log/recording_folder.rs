//! The folder of a recording of `rosbag2`: its `metadata.yaml` names the files.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::LogError;
use crate::input_file::read_text;
use crate::map::yaml::{self, BadYaml};

/// The file that names the others.
const METADATA: &str = "metadata.yaml";

/// Maximum number of values of the file after the expansion of aliases.
const MAX_VALUES: usize = 1_000_000;

#[derive(Deserialize)]
struct Metadata {
    rosbag2_bagfile_information: Information,
}

#[derive(Deserialize)]
struct Information {
    relative_file_paths: Vec<PathBuf>,
}

/// The files that `metadata.yaml` of a folder names, in its order; none if the folder has no such file.
///
/// # Errors
/// `metadata.yaml` cannot be read, or names a file that is missing.
pub fn recording_files(folder: &Path) -> Result<Option<Vec<PathBuf>>, LogError> {
    let path = folder.join(METADATA);
    if !path.exists() {
        return Ok(None);
    }
    let in_file = |problem| LogError::InFile { path: path.clone(), problem: Box::new(problem) };
    let text = read_text(&path).map_err(|error| in_file(error.into()))?;
    let metadata: Metadata = yaml::parse(&text, MAX_VALUES)
        .map_err(|BadYaml { line, reason }| in_file(LogError::BadMetadata { line, reason }))?;
    let names = metadata.rosbag2_bagfile_information.relative_file_paths;
    let files: Vec<PathBuf> = names.iter().map(|name| folder.join(name)).collect();
    match files.iter().find(|file| !file.exists()) {
        Some(file) => Err(in_file(LogError::MissingRecordingFile { path: file.clone() })),
        None => Ok(Some(files)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metadata_names_the_files_of_a_recording() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).expect("it is written");
        };
        assert_eq!(recording_files(folder.path()), Ok(None));
        let metadata = "rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths: [b_0.mcap, b_1.mcap]\n";
        write(METADATA, metadata);
        write("b_0.mcap", "");
        write("other.mcap", "");
        let missing = recording_files(folder.path()).expect_err("a missing file").to_string();
        assert!(missing.contains("metadata.yaml: ") && missing.contains("b_1.mcap"), "{missing}");
        write("b_1.mcap", "");
        let files = ["b_0.mcap", "b_1.mcap"].map(|name| folder.path().join(name)).to_vec();
        assert_eq!(recording_files(folder.path()), Ok(Some(files)));
        write(METADATA, "version: 5\n");
        assert!(recording_files(folder.path()).is_err());
    }
}
