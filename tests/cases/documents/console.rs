//! Runs the `console` blocks of README and book in a copy of what the repository ships.

use std::env;
use std::fs;
use std::path::Path;

use trycmd::TestCases;

/// Files that the commands read, below the repository's root.
const SHIPPED: [&str; 1] = ["examples"];

/// One test for all pages: the commands read relative paths, and a process has one working directory.
#[test]
fn console_blocks_print_what_they_show() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let copy = tempfile::tempdir().expect("a temporary directory");
    for folder in SHIPPED {
        let target = copy.path().join(folder);
        fs::create_dir(&target).expect("a new directory");
        for entry in fs::read_dir(root.join(folder)).expect("a shipped directory") {
            let file = entry.expect("an entry of it").path();
            // The commands read no file of a folder below.
            if file.is_dir() {
                continue;
            }
            let name = file.file_name().expect("an entry has a name");
            fs::copy(&file, target.join(name)).expect("a shipped file is copied");
        }
    }
    env::set_current_dir(copy.path()).expect("the copy can be entered");
    // Colours and terminal widths of the machine do not matter.
    TestCases::new()
        .env("NO_COLOR", "1")
        // Mesa prints an error without it.
        .env("XDG_RUNTIME_DIR", copy.path().display().to_string())
        .env("COLUMNS", "100")
        .case(root.join("README.md"))
        .case(root.join("docs/src/*.md"));
}
