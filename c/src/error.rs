//! The message of the last failure of each thread.

use core::cell::RefCell;
use core::ffi::{CStr, c_char};
use core::fmt::Display;
use core::mem::MaybeUninit;
use std::ffi::CString;
use std::panic::{UnwindSafe, catch_unwind};

thread_local! {
    static MESSAGE: RefCell<CString> = RefCell::default();
}

/// Returns the message of the last failure in this thread, UTF-8; empty if there was none. It stays valid until the next
/// failure in this thread.
#[unsafe(no_mangle)]
pub extern "C" fn inbye_last_error() -> *const c_char {
    MESSAGE.with(|message| message.borrow().as_ptr())
}

pub fn fail(error: impl Display) {
    let text = error.to_string().replace('\0', " ");
    MESSAGE.set(CString::new(text).unwrap_or_default());
}

/// Runs the body of a function. A failure, and a panic, which must not reach C, are noted; the answer is then none.
pub fn guarded<T>(body: impl FnOnce() -> Result<T, String> + UnwindSafe) -> Option<T> {
    match catch_unwind(body) {
        Ok(Ok(value)) => Some(value),
        Ok(Err(error)) => {
            fail(error);
            None
        }
        Err(_) => {
            fail("inbye panicked: this is a bug");
            None
        }
    }
}

/// As [`guarded`], for a function that returns a new object, or null.
pub fn boxed<T>(body: impl FnOnce() -> Result<T, String> + UnwindSafe) -> *mut T {
    guarded(body).map_or(core::ptr::null_mut(), |object| Box::into_raw(Box::new(object)))
}

/// The text of a pointer.
///
/// # Safety
/// It is null or points to a text that ends with zero.
pub unsafe fn text<'a>(pointer: *const c_char, name: &str) -> Result<&'a str, String> {
    if pointer.is_null() {
        return Err(format!("{name} is null"));
    }
    // SAFETY: it is not null, and the caller vouches for the text.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| format!("{name} is not UTF-8"))
}

/// The values of an array.
///
/// # Safety
/// The pointer is null or points to this many values.
pub unsafe fn array<'a, T>(pointer: *const T, count: usize, name: &str) -> Result<&'a [T], String> {
    if count == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() {
        return Err(format!("{name} is null"));
    }
    if count > isize::MAX as usize / size_of::<T>().max(1) {
        return Err(format!("{name}: {count} values do not fit into memory"));
    }
    // SAFETY: it is not null, and the caller vouches for the values.
    Ok(unsafe { core::slice::from_raw_parts(pointer, count) })
}

/// The object behind a pointer.
///
/// # Safety
/// The pointer is null or points to an object of this interface that is alive.
pub unsafe fn object<'a, T>(pointer: *const T, name: &str) -> Result<&'a T, String> {
    // SAFETY: the caller vouches for the object.
    unsafe { pointer.as_ref() }.ok_or_else(|| format!("{name} is null"))
}

/// As [`object`], to change it.
///
/// # Safety
/// As for [`object`], and nothing else uses it meanwhile.
pub unsafe fn object_mut<'a, T>(pointer: *mut T, name: &str) -> Result<&'a mut T, String> {
    // SAFETY: the caller vouches for the object.
    unsafe { pointer.as_mut() }.ok_or_else(|| format!("{name} is null"))
}

/// The place behind a pointer for a value. A C program may not have initialised it.
///
/// # Safety
/// The pointer is null or can be written, and nothing else uses the place meanwhile.
pub unsafe fn place<'a, T>(pointer: *mut T, name: &str) -> Result<&'a mut MaybeUninit<T>, String> {
    // SAFETY: the caller vouches for the place; it needs no value.
    unsafe { object_mut(pointer.cast(), name) }
}

/// Frees an object; does nothing with null.
///
/// # Safety
/// The pointer is null, or came from a function of this interface and was not freed.
pub unsafe fn free<T>(pointer: *mut T) {
    if !pointer.is_null() {
        // SAFETY: it came from `Box::into_raw`, once.
        drop(unsafe { Box::from_raw(pointer) });
    }
}
