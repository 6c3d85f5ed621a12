//! Room: local.
