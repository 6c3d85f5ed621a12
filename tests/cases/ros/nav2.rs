//! The import of Nav2 parameter files: mapped parameters, unmapped parameters, and errors.

mod completeness;
mod derived;
mod errors;
mod files;
mod forward_only;
mod mapping;
