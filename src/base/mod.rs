//! Room: base.
