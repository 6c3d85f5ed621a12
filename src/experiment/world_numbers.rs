//! Selection of numbered worlds.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// A requested world that does not exist.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("world {world} is not among the {count} of {}: it has {some} and others", place.display())]
pub struct UnknownWorld {
    /// The file or folder of worlds.
    pub place: PathBuf,
    /// The requested number.
    pub world: u32,
    /// Number of worlds that exist.
    pub count: usize,
    /// The first of them.
    pub some: String,
}

/// Number of worlds that an error names.
const NAMED: usize = 5;

/// Returns the worlds with these numbers; all, if no number is given.
///
/// # Errors
/// Fails when one of them does not exist.
pub(super) fn select_worlds<W>(
    worlds: &mut Vec<W>,
    number: impl Fn(&W) -> u32,
    only: Option<&[u32]>,
    place: &Path,
) -> Result<(), UnknownWorld> {
    let Some(only) = only else {
        return Ok(());
    };
    let absent = |asked: &&u32| worlds.iter().all(|world| number(world) != **asked);
    if let Some(&world) = only.iter().find(absent) {
        let numbers = worlds.iter().map(|world| number(world).to_string());
        return Err(UnknownWorld {
            place: place.to_owned(),
            world,
            count: worlds.len(),
            some: numbers.take(NAMED).collect::<Vec<_>>().join(", "),
        });
    }
    worlds.retain(|world| only.contains(&number(world)));
    Ok(())
}
