//! The commands in the shell blocks of README and book: the program understands each of them.
//!
//! Those that need no more than the repository are run, in a copy of its examples. The others need a robot, a network, hours or
//! data that the repository does not contain. The console blocks are run by another test.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use pulldown_cmark::{CodeBlockKind, Event, Parser, Tag, TagEnd};
use tempfile::TempDir;

/// The lines of all shell blocks of a Markdown text.
fn shell_lines(text: &str) -> Vec<String> {
    let mut in_block = false;
    let mut lines = Vec::new();
    for event in Parser::new(text) {
        match event {
            Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(kind))) => in_block = &*kind == "sh",
            Event::End(TagEnd::CodeBlock) => in_block = false,
            Event::Text(text) if in_block => lines.extend(text.lines().map(str::to_owned)),
            _ => {}
        }
    }
    lines
}

/// The arguments of a call of the program; `None` for another command. What is between two `"` is one word.
fn arguments(line: &str) -> Option<Vec<String>> {
    let is_end = |word: &&str| matches!(*word, "|" | ">" | "#" | "&" | "&&");
    let words = line.split('"').enumerate().flat_map(|(index, part)| match index % 2 {
        0 => part.split_whitespace().collect(),
        _ => vec![part],
    });
    let mut words = words.take_while(|word| !is_end(word));
    (words.next() == Some("inbye")).then(|| words.map(str::to_owned).collect())
}

/// Whether the program accepts the arguments. `--help` at their end is reached only if all before it are valid.
fn is_understood(arguments: &[String]) -> Result<(), String> {
    let mut program = Command::cargo_bin("inbye").expect("cargo builds the program first");
    let output = program.args(arguments).arg("--help").output().expect("the program starts");
    let help = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() && help.contains("Usage: ") {
        Ok(())
    } else {
        Err(String::from_utf8_lossy(&output.stderr).into_owned())
    }
}

/// README and all pages of the book.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut pages = vec![root.join("README.md")];
    let entries = fs::read_dir(root.join("docs/src")).expect("the book's pages");
    pages.extend(entries.map(|entry| entry.expect("an entry of the book").path()));
    pages.retain(|page| page.extension().is_some_and(|extension| extension == "md"));
    pages.sort();
    pages
}

/// The begin of commands that need no more than the repository, and end soon.
const RUN: [&str; 4] =
    ["inbye config ", "inbye drive --scene ", "inbye evaluate ", "inbye plan --scene "];

/// A folder with a copy of the examples.
fn place_with_examples() -> TempDir {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let place = TempDir::new().expect("a temporary folder");
    fs::create_dir_all(place.path().join("examples")).expect("a folder");
    fs::create_dir_all(place.path().join("docs/src/pictures")).expect("a folder");
    for file in fs::read_dir(root.join("examples")).expect("the examples") {
        let file = file.expect("an entry of the examples");
        if file.path().is_file() {
            let copy = place.path().join("examples").join(file.file_name());
            fs::copy(file.path(), copy).expect("a copy of an example");
        }
    }
    place
}

#[test]
fn commands_that_need_only_the_repository_run_as_typed() {
    let programs = Path::new(env!("CARGO_BIN_EXE_inbye")).parent().expect("a folder");
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap_or_default());
    let mut run = 0;
    for page in pages() {
        let text = fs::read_to_string(&page).expect("a page is text");
        let place = place_with_examples();
        for line in shell_lines(&text) {
            if !RUN.iter().any(|begin| line.starts_with(begin)) {
                continue;
            }
            run += 1;
            let output = std::process::Command::new("sh")
                .args(["-c", &line])
                .current_dir(place.path())
                .env("PATH", &path)
                .output()
                .expect("a shell");
            let error = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.success(), "{}: {line}: {error}", page.display());
        }
    }
    assert!(run > 5, "{run} commands");
}

#[test]
fn commands_of_shell_blocks_are_understood() {
    let (mut tried, mut wrong) = (0, Vec::new());
    for page in pages() {
        let text = fs::read_to_string(&page).expect("a page is text");
        for line in shell_lines(&text) {
            if let Some(arguments) = arguments(&line) {
                tried += 1;
                if let Err(error) = is_understood(&arguments) {
                    wrong.push(format!("{}: {line}: {error}", page.display()));
                }
            }
        }
    }
    assert!(tried > 20, "{tried} commands");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn unknown_flag_and_wrong_value_are_noticed() {
    let words = |line: &str| arguments(line).expect("a call of the program");
    assert!(is_understood(&words("inbye plan --scene mine --svg a.svg")).is_ok());
    assert!(is_understood(&words("inbye plan --scene mine --no-such-flag")).is_err());
    assert!(is_understood(&words("inbye plan --scene moon")).is_err());
    assert_eq!(arguments("cargo install --path ."), None);
}
