//! The localiser: laid on a map it finds its place, keeps it over a tour with tracks that slip, and says when it is lost.

mod lost;
mod room;
mod tours;
