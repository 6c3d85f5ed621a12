//! A Python that has the packages that a test needs.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use libtest_mimic::{Completion, Failed};

use super::requirements::required;

/// What a test needs of a Python, and the one that was found.
pub struct Python {
    packages: &'static str,
    /// The variable that names one.
    variable: &'static str,
    /// Where one is looked for without the variable.
    places: &'static [&'static str],
    /// The word of `INBYE_REQUIRE` with which a test fails without one.
    word: &'static str,
    found: OnceLock<Option<PathBuf>>,
}

impl Python {
    /// A Python that imports these packages.
    pub const fn with(
        packages: &'static str,
        variable: &'static str,
        places: &'static [&'static str],
        word: &'static str,
    ) -> Self {
        Self { packages, variable, places, word, found: OnceLock::new() }
    }

    /// Runs a test with it. Without one the test is ignored, or fails where one is required.
    pub fn run(
        &self,
        test: impl FnOnce(&Path) -> Result<(), Failed>,
    ) -> Result<Completion, Failed> {
        let Self { packages, variable, word, .. } = self;
        let missing = || format!("no Python with {packages} was found; {variable} names one");
        match self.found.get_or_init(|| self.find()) {
            Some(python) => test(python).map(|()| Completion::Completed),
            None if required().iter().any(|required| required == word) => Err(missing().into()),
            None => Ok(Completion::ignored_with(missing())),
        }
    }

    fn find(&self) -> Option<PathBuf> {
        let named = env::var_os(self.variable).map(|python| vec![python.into()]);
        let places = || self.places.iter().map(PathBuf::from).collect();
        let candidates: Vec<PathBuf> = named.unwrap_or_else(places);
        candidates.into_iter().find(|python| {
            let imports = format!("import {}", self.packages);
            let asked = Command::new(python).args(["-c", &imports]).output();
            asked.is_ok_and(|output| output.status.success())
        })
    }
}
