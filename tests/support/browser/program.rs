//! Which Chromium there is, and what becomes of a test where there is none.
//!
//! Without Chromium the trials are ignored, with the reason; `INBYE_REQUIRE` with the word `chromium` makes that a
//! failure, and `INBYE_CHROMIUM` names the program where it has another name.

use std::env;
use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use libtest_mimic::{Completion, Failed, Trial};

use super::super::requirements::required;

/// Names a Chromium other than those below.
const VARIABLE: &str = "INBYE_CHROMIUM";
const NAMES: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// No window, nothing that asks the network, and no sandbox, for with one Chromium refuses to run as root, as it does in a
/// container.
const FLAGS: [&str; 7] = [
    "--headless",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
];

/// A test in a browser.
pub type BrowserTest = fn(&Program) -> Result<(), Failed>;

/// A Chromium that can be started.
#[derive(Clone)]
pub struct Program {
    path: String,
    /// As it names itself.
    pub version: String,
}

impl Program {
    /// The one that `INBYE_CHROMIUM` names, or else the first of the usual names that answers; or why there is none.
    fn find() -> Result<Self, String> {
        let candidates = match env::var(VARIABLE) {
            Ok(path) => vec![path],
            Err(_) => NAMES.map(str::to_owned).to_vec(),
        };
        let answers = |path: &String| {
            let asked = Command::new(path).arg("--version").output().ok()?;
            let version = String::from_utf8_lossy(&asked.stdout);
            let version = version.split(" built on").next().unwrap_or_default().trim();
            (asked.status.success() && !version.is_empty())
                .then(|| Self { path: path.clone(), version: version.to_owned() })
        };
        let found = candidates.iter().find_map(answers);
        found.ok_or_else(|| {
            let tried = candidates.join(", ");
            format!("no Chromium was found (tried {tried}); {VARIABLE} names one")
        })
    }

    /// Starts it on a page. Its profile is the folder, so it reads no setting of the user's; what it says goes into the file
    /// `stderr` there.
    pub fn start(&self, profile: &Path, flags: &[&str], page: &str) -> Result<Child, Failed> {
        // Chromium writes more than its profile: all of it goes where the profile goes.
        let homes = ["HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME"];
        let child = Command::new(&self.path)
            .args(FLAGS)
            .args(flags)
            .envs(homes.map(|name| (name, profile)))
            .arg(format!("--user-data-dir={}", profile.display()))
            .arg(page)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(File::create(profile.join("stderr"))?)
            .spawn()?;
        Ok(child)
    }
}

/// A trial for each test.
pub fn trials(tests: &[(&'static str, BrowserTest)]) -> Vec<Trial> {
    let found = Program::find();
    let trial = |&(name, test): &(&'static str, BrowserTest)| match found.clone() {
        Ok(program) => {
            let version = program.version.clone();
            Trial::test(name, move || test(&program)).with_kind(version)
        }
        Err(why) => {
            let missing = move || {
                if required().iter().any(|word| word == "chromium") {
                    Err(why.into())
                } else {
                    Ok(Completion::ignored_with(why))
                }
            };
            Trial::ignorable_test(name, missing).with_kind("no Chromium")
        }
    };
    tests.iter().map(trial).collect()
}
