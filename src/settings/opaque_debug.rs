//! `Debug` for types whose content does not help a reader of messages.

/// Implements `Debug` with the name alone: a struct that holds the type can derive it, and `unwrap_err` of a result can be called.
macro_rules! opaque_debug {
    ($($name:ident $(<$parameter:ident>)?),+) => {$(
        impl$(<$parameter>)? core::fmt::Debug for $name$(<$parameter>)? {
            fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                formatter.debug_struct(stringify!($name)).finish_non_exhaustive()
            }
        }
    )+};
}
pub(crate) use opaque_debug;
