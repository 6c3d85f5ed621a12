//! The `inbye` program.
fn main() {}
