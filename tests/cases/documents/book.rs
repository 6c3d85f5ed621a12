//! The book builds without warnings, and each link of book and README leads to a file and a heading that exist.

use std::fs;
use std::path::{Path, PathBuf};

use mdbook_driver::MDBook;
use pulldown_cmark::{Event, Options, Parser, Tag};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The destinations of all links and images in a Markdown text.
fn destinations(text: &str) -> Vec<String> {
    let destination = |event| match event {
        Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
            Some(dest_url.to_string())
        }
        _ => None,
    };
    Parser::new_ext(text, Options::ENABLE_TABLES).filter_map(destination).collect()
}

fn is_external(destination: &str) -> bool {
    destination.starts_with("https://")
}

/// Splits a destination into its path and its anchor, which may be empty.
fn parts(destination: &str) -> (&str, &str) {
    destination.split_once('#').unwrap_or((destination, ""))
}

fn pages() -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join("docs/src")).expect("the book's pages");
    let mut pages: Vec<_> = entries
        .map(|entry| entry.expect("an entry of the book").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .collect();
    pages.sort();
    pages
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Builds the book into a directory.
fn build(target: &Path) {
    let mut book = MDBook::load(root().join("docs")).expect("the book is complete");
    target.clone_into(&mut book.config.build.build_dir);
    book.build().expect("the book builds");
}

/// The links of a page that lead nowhere, given the directory of the built book.
fn broken_links(page: &str, links: &[String], built: &Path) -> Vec<String> {
    let leads_nowhere = |link: &&String| {
        let (path, anchor) = parts(link);
        let target = if path.is_empty() { page } else { path };
        let file = built.join(target).with_extension("html");
        let Ok(html) = fs::read_to_string(file) else {
            return !built.join(target).exists();
        };
        !anchor.is_empty() && !html.contains(&format!("id=\"{anchor}\""))
    };
    let internal = links.iter().filter(|link| !is_external(link));
    internal.filter(leads_nowhere).map(|link| format!("{page}: {link}")).collect()
}

#[test]
fn book_builds_and_its_links_resolve() {
    let target = tempfile::tempdir().expect("a temporary directory");
    build(target.path());
    let mut broken = Vec::new();
    for page in pages() {
        let name = page.file_name().expect("a page has a name").to_string_lossy();
        let links = destinations(&text(&page));
        broken.extend(broken_links(&name, &links, target.path()));
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn broken_link_is_noticed() {
    let target = tempfile::tempdir().expect("a temporary directory");
    build(target.path());
    let links = destinations("[a](no-such-page.md) [b](cli.md#no-such-heading) [c](cli.md)");
    let broken = broken_links("cli.md", &links, target.path());
    assert_eq!(broken, ["cli.md: no-such-page.md", "cli.md: cli.md#no-such-heading"]);
}

#[test]
fn readme_links_to_files_that_exist() {
    for link in destinations(&text(&root().join("README.md"))) {
        let (path, _) = parts(&link);
        let leads_somewhere = is_external(&link) || root().join(path).exists();
        assert!(leads_somewhere, "README.md: {link}");
    }
}

#[test]
fn every_page_is_in_the_summary() {
    let summary = text(&root().join("docs/src/SUMMARY.md"));
    for page in pages() {
        let name = page.file_name().expect("a page has a name").to_string_lossy();
        let is_listed = name == "SUMMARY.md" || summary.contains(&format!("({name})"));
        assert!(is_listed, "{name} is not in docs/src/SUMMARY.md");
    }
}

#[test]
fn readme_is_short() {
    let lines = text(&root().join("README.md")).lines().count();
    assert!(lines <= 150, "README.md has {lines} lines, more than 150");
}

/// All Rust files below a folder of the repository, each with its text.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let entries = fs::read_dir(folder).expect("a source folder");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths
        .flat_map(|path| match path.extension() {
            _ if path.is_dir() => sources(&path),
            Some(extension) if extension == "rs" => vec![(path.clone(), text(&path))],
            _ => Vec::new(),
        })
        .collect()
}

/// Whether a name of a test is in the sources: `function`, `start_of_a_function_*`, `module::in_a_folder` or `module::*`.
fn names_a_test(name: &str, sources: &[(PathBuf, String)]) -> bool {
    if let Some((module, last)) = name.rsplit_once("::") {
        let module = if last == "*" { module } else { name };
        let file = format!("{}.rs", module.replace("::", "/"));
        return sources
            .iter()
            .any(|(path, text)| path.ends_with(&file) && text.contains("#[test]"));
    }
    let start = match name.strip_suffix('*') {
        Some(start) => format!("fn {start}"),
        None => format!("fn {name}("),
    };
    sources.iter().any(|(_, text)| text.contains(&start))
}

/// The names in the last column of a table below a heading.
fn last_column<'a>(page: &'a str, heading: &str) -> Vec<&'a str> {
    let section = page.split("\n## ").find(|section| section.starts_with(heading));
    let rows = section.expect("the section").lines().filter(|line| line.starts_with('|'));
    let cells = rows.skip(2).filter_map(|row| row.trim_end_matches('|').rsplit('|').next());
    cells.flat_map(|cell| cell.split('`').skip(1).step_by(2)).collect()
}

#[test]
fn tests_of_the_safety_page_exist() {
    let sources: Vec<_> =
        ["src", "tests"].iter().flat_map(|folder| sources(&root().join(folder))).collect();
    let hazards = text(&root().join("docs/src/safety.md"));
    let mutants = text(&root().join("docs/src/mutants.md"));
    let names = [last_column(&hazards, "Hazards"), last_column(&mutants, "Checks")].concat();
    assert!(names.len() > 50, "{names:?}");
    let missing: Vec<_> = names.iter().filter(|name| !names_a_test(name, &sources)).collect();
    assert!(missing.is_empty(), "{missing:?}");
    assert!(!names_a_test("no_such_test", &sources) && !names_a_test("no_module::*", &sources));
}
