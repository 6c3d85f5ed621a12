//! Some worlds of all that there are.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// A world asked for that is not there.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("world {world} is not among the {count} of {}: it has {some} and others", place.display())]
pub struct NotAmong {
    /// The file or folder of worlds.
    pub place: PathBuf,
    /// The world.
    pub world: u32,
    /// How many are there.
    pub count: usize,
    /// The first of them.
    pub some: String,
}

/// Numbers that an error names.
const SOME: usize = 5;

/// Keeps the worlds asked for, by their numbers; all, where none is named.
///
/// # Errors
/// When one of them is not there.
pub(in crate::experiment) fn keep_asked<W>(
    worlds: &mut Vec<W>,
    number: impl Fn(&W) -> u32,
    only: Option<&[u32]>,
    place: &Path,
) -> Result<(), NotAmong> {
    let Some(only) = only else {
        return Ok(());
    };
    let absent = |asked: &&u32| worlds.iter().all(|world| number(world) != **asked);
    if let Some(&world) = only.iter().find(absent) {
        let numbers = worlds.iter().map(|world| number(world).to_string());
        return Err(NotAmong {
            place: place.to_owned(),
            world,
            count: worlds.len(),
            some: numbers.take(SOME).collect::<Vec<_>>().join(", "),
        });
    }
    worlds.retain(|world| only.contains(&number(world)));
    Ok(())
}
