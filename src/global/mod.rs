//! Room: global.
