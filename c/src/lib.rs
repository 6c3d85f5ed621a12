//! The C interface of inbye. `include/inbye.h` is made of this crate and is its documentation for C.
//!
//! Pointers that a function returns belong to the caller, who frees them with the function of their type. A function that fails
//! returns null or false, and [`inbye_last_error`] says why. Objects may move between threads; only one thread at a time may use
//! one, but any number of threads a map or a configuration.

#![expect(
    unsafe_code,
    reason = "a C interface takes pointers; each function says what it needs of them"
)]
#![expect(clippy::doc_markdown, reason = "the header is read without markup")]

mod abi;
mod decision;
mod error;
mod map;
mod navigator;
mod values;

pub use abi::INBYE_ABI_VERSION;

/// Returns INBYE_ABI_VERSION of the loaded library.
#[unsafe(no_mangle)]
pub extern "C" fn inbye_abi_version() -> u32 {
    INBYE_ABI_VERSION
}
