//! The tracker finds moving obstacles soon and accurately from scans alone, and never takes a static one for moving.
//!
//! The simulated lidar scans a world that the tracker's map does not show, from poses with small errors.

mod field;
mod people;
mod phantoms;
mod stage;
