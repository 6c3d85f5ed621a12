//! The program's own parsers, read from its source: they are of its command line and not of the library, whose rooms know
//! neither their words nor all of the defaults.

#![expect(dead_code, reason = "the parts that open files are the program's")]
#![cfg_attr(
    test,
    expect(unused_imports, reason = "their own tests run where the program's do")
)]

#[path = "../../src/cli/changes.rs"]
pub mod changes;
#[path = "../../src/cli/config.rs"]
pub mod config;
#[path = "../../src/cli/plain_words.rs"]
pub mod plain_words;
#[path = "../../src/cli/problem_file.rs"]
pub mod problem_file;
