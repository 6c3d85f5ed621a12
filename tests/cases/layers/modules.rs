//! Rules of the source: the order of modules, the length of files, no `unwrap`.

use std::fs;
use std::path::{Path, PathBuf};

/// The modules in the order in which data flows. A module may use those before it; the first six use no other.
const MODULES: [&str; 28] = [
    "digest",
    "geometry",
    "input_file",
    "numeric",
    "settings",
    "suggest",
    "map",
    "robot",
    "lidar_log",
    "trajectory",
    "localization",
    "mapping",
    "global",
    "local",
    "navigator",
    "external",
    "base",
    "runtime",
    "sim",
    "ros",
    "recording",
    "bench",
    "experiment",
    "report",
    "server",
    "live",
    "playground",
    "cli",
];
/// Number of modules that all others build on.
const FOUNDATIONS: usize = 6;
/// Longest source file, lines.
const MOST_LINES: usize = 500;

/// A source file without its test module.
struct Source {
    /// Path from `src/`, with `/` between the parts.
    path: String,
    lines: usize,
    code: String,
}

impl Source {
    /// The module of the file; none for `lib.rs` and `main.rs`.
    fn module(&self) -> Option<usize> {
        let first = self.path.split('/').next().unwrap_or_default();
        let name = first.strip_suffix(".rs").unwrap_or(first);
        MODULES.iter().position(|module| *module == name)
    }
}

fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    collect(&root, &mut files);
    files.sort();
    assert!(files.len() > 20, "the sources were not found");
    let source = |file: &PathBuf| {
        let text = fs::read_to_string(file).expect("a source file is text");
        let path = file.strip_prefix(&root).expect("found below the root");
        let parts: Vec<_> = path.iter().map(|part| part.to_string_lossy()).collect();
        Source { path: parts.join("/"), lines: text.lines().count(), code: code(&text) }
    };
    files.iter().map(source).collect()
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a source directory") {
        let path = entry.expect("an entry of the directory").path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

/// The text without comments and without the test module, which is last in a file.
fn code(text: &str) -> String {
    let before_tests = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    let mut code = String::new();
    for line in before_tests.lines() {
        let comment = line.trim_start().starts_with("//");
        code.push_str(if comment { "" } else { line });
        code.push('\n');
    }
    code
}

/// Modules named after `crate::`, alone or in a group, and after `super::` where that is the crate itself.
fn modules_named(source: &Source) -> Vec<usize> {
    let depth = source.path.matches('/').count() + usize::from(!source.path.ends_with("mod.rs"));
    let up = "super::".repeat(depth);
    let mut named = Vec::new();
    for prefix in ["crate::", "inbye::", up.as_str()] {
        if prefix.is_empty() {
            continue;
        }
        for (at, _) in source.code.match_indices(prefix) {
            named.extend(first_names(&source.code[at + prefix.len()..]));
        }
    }
    let module = |name: String| MODULES.iter().position(|module| *module == name);
    named.into_iter().filter_map(module).collect()
}

/// The first name of a path, or of each path of a group `{a::b, c}`.
fn first_names(path: &str) -> Vec<String> {
    let name = |path: &str| -> String {
        let is_name = |c: &char| c.is_alphanumeric() || *c == '_';
        path.trim_start().chars().take_while(is_name).collect()
    };
    let Some(group) = path.strip_prefix('{') else {
        return vec![name(path)];
    };
    let mut names = vec![name(group)];
    let mut depth = 0;
    for (at, letter) in group.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => names.push(name(&group[at + 1..])),
            _ => {}
        }
    }
    names
}

#[test]
fn modules_use_only_earlier_modules() {
    let mut wrong = Vec::new();
    for source in sources() {
        let Some(own) = source.module() else { continue };
        for named in modules_named(&source) {
            // The foundations do not use one another.
            if named > own || (named != own && own < FOUNDATIONS) {
                wrong.push(format!("src/{} names {}", source.path, MODULES[named]));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_source_file_is_in_a_listed_module() {
    for source in sources() {
        let top = matches!(source.path.as_str(), "lib.rs" | "main.rs");
        assert!(top || source.module().is_some(), "src/{} is in no listed module", source.path);
    }
}

#[test]
fn source_files_have_at_most_500_lines() {
    let long = |source: &Source| source.lines > MOST_LINES;
    let all = sources();
    let long: Vec<String> = all
        .iter()
        .filter(|source| long(source))
        .map(|source| format!("src/{}: {} lines", source.path, source.lines))
        .collect();
    assert!(long.is_empty(), "above {MOST_LINES} lines: {}", long.join(", "));
}

#[test]
fn source_outside_tests_does_not_unwrap() {
    let mut wrong = Vec::new();
    for source in sources() {
        for (index, line) in source.code.lines().enumerate() {
            if line.contains(".unwrap()") {
                wrong.push(format!("src/{}:{}", source.path, index + 1));
            }
        }
    }
    assert!(wrong.is_empty(), "unwrap() in {}", wrong.join(", "));
}

/// A breach of each rule is found.
#[test]
fn breach_of_each_rule_is_found() {
    let source = |path: &str, text: &str| Source {
        path: path.to_owned(),
        lines: text.lines().count(),
        code: code(text),
    };
    let named = |path: &str, text: &str| -> Vec<&str> {
        modules_named(&source(path, text)).into_iter().map(|module| MODULES[module]).collect()
    };
    assert_eq!(named("map/grid.rs", "use crate::local::Engine;"), ["local"]);
    assert_eq!(
        named("map/grid.rs", "use crate::{geometry::{Pose, Point}, sim};"),
        ["geometry", "sim"]
    );
    assert_eq!(named("map/grid.rs", "fn f() { super::super::bench::run() }"), ["bench"]);
    assert_eq!(named("map/mod.rs", "use super::navigator::Mode;"), ["navigator"]);
    assert_eq!(named("map/grid.rs", "use super::local; // a submodule"), [""; 0]);
    assert_eq!(named("map/grid.rs", "/// As crate::local has it.\n"), [""; 0]);
    let tests = "fn f() {}\n#[cfg(test)]\nmod tests { use crate::sim; fn g() { x.unwrap() } }";
    assert_eq!(named("map/grid.rs", tests), [""; 0]);
    assert!(!source("map/grid.rs", tests).code.contains("unwrap"));
    assert!(source("map/grid.rs", "x.unwrap()").code.contains("unwrap"));
    assert_eq!(source("numeric.rs", "").module(), Some(3));
    assert_eq!(source("helpers.rs", "").module(), None);
}
