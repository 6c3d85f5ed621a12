//! The number of the interface, for the library and for the host of controllers.

/// Number of this interface. It changes when a program or a controller that was compiled for it must be compiled again.
pub const INBYE_ABI_VERSION: u32 = 2;
