//! What moves is found from scans alone, soon and well; what stands is never taken for moving.
//!
//! The simulator's lidar looks at a world that the tracker's map does not show, from poses that are a little off.

mod field;
mod people;
mod phantoms;
mod stage;
