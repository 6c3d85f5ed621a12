//! The program's parsers, included from its source: they belong to its command line, not to the library.

#![expect(dead_code, reason = "the functions that open files are used by the program only")]

#[path = "../../src/cli/problem_file.rs"]
pub mod problem_file;
