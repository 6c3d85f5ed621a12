//! Trials of plain tests, and of tests that need the development data, which are expected next to the repository.

use std::path::{Path, PathBuf};

use libtest_mimic::{Completion, Failed, Trial};

/// The folder of the development data.
pub const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data");

/// A test by its name.
pub type Test = (&'static str, fn());

/// The trials of tests that need nothing.
pub fn plain<'t>(tests: impl IntoIterator<Item = &'t [Test]>) -> Vec<Trial> {
    let trial = |&(name, test): &Test| {
        Trial::test(name, move || {
            test();
            Ok(())
        })
    };
    tests.into_iter().flatten().map(trial).collect()
}

/// The trial of a test with a file or folder of the data. Without it the test is ignored.
pub fn with_data(
    name: impl Into<String>,
    data: impl AsRef<Path>,
    test: impl FnOnce(&Path) -> Result<(), Failed> + Send + 'static,
) -> Trial {
    let data: PathBuf = Path::new(DATA).join(data);
    Trial::ignorable_test(name, move || {
        if !data.exists() {
            return Ok(Completion::ignored_with("the development data are missing"));
        }
        test(&data).map(|()| Completion::Completed)
    })
}
