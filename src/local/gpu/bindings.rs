//! What the shaders bind where and how, whoever drives them: the engine through wgpu, a test in a browser.

/// Number of bindings.
pub const BINDINGS: usize = 9;
/// Number of the binding that holds the fields. Those before it all show the input from its start.
pub const FIELD: usize = 4;
/// Number of the binding that holds a [`super::layout::Record`] for each sample of a batch.
pub const RECORDS: usize = 6;
/// Number of the binding that holds a [`super::layout::Answer`] for each problem of a batch.
pub const ANSWERS: usize = 8;

/// How the shaders reach a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// As a uniform.
    Uniform,
    /// As storage that is only read.
    Read,
    /// As storage that is read and written.
    ReadWrite,
}

/// The access of each binding of `shaders/layout.wgsl`, by its number.
pub const ACCESS: [Access; BINDINGS] = [
    Access::Uniform,
    Access::Read,
    Access::Read,
    Access::Read,
    Access::Read,
    Access::ReadWrite,
    Access::ReadWrite,
    Access::ReadWrite,
    Access::ReadWrite,
];
