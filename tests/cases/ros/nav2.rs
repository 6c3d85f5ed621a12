//! Nav2's parameter files as settings: what is taken over, what is listed, and what is refused.

mod files;
mod mapping;
mod places;
mod refusals;
