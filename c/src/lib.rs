//! The C interface of inbye. `include/inbye.h` is made of this crate and is its documentation for C.
//!
//! Pointers that a function returns belong to the caller, who frees them with the function of their type. A function that fails
//! returns null or false, and [`inbye_last_error`] says why. Objects may move between threads; only one thread at a time may use
//! one.

#![expect(
    unsafe_code,
    reason = "a C interface takes pointers; each function says what it needs of them"
)]
#![expect(clippy::doc_markdown, reason = "the header is read without markup")]

mod decision;
mod error;
mod map;
mod navigator;
mod values;

/// Number of this interface. It changes when a program that was compiled for it must be compiled again.
pub const INBYE_ABI_VERSION: u32 = 1;

/// Returns INBYE_ABI_VERSION of the loaded library.
#[unsafe(no_mangle)]
pub extern "C" fn inbye_abi_version() -> u32 {
    INBYE_ABI_VERSION
}
