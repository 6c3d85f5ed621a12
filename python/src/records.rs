//! Structured arrays: one record for each row, with named columns.

use pyo3::prelude::*;
use pyo3::types::PyByteArray;

/// Columns with their NumPy types, and the bytes of the records.
pub struct Records {
    columns: &'static [(&'static str, &'static str)],
    bytes: Vec<u8>,
}

impl Records {
    /// Columns of types such as `<f8`, `<u4` and `<U12`, to which each record is pushed value by value.
    pub const fn new(columns: &'static [(&'static str, &'static str)]) -> Self {
        Self { columns, bytes: Vec::new() }
    }

    pub fn real(&mut self, value: f64) {
        self.bytes.extend(value.to_le_bytes());
    }

    pub fn reals(&mut self, values: impl IntoIterator<Item = f64>) {
        values.into_iter().for_each(|value| self.real(value));
    }

    pub fn whole(&mut self, value: u32) {
        self.bytes.extend(value.to_le_bytes());
    }

    /// An ASCII text in a column of this many characters.
    pub fn text(&mut self, value: &str, characters: usize) {
        let padded = value.chars().map(u32::from).chain(core::iter::repeat(0));
        padded.take(characters).for_each(|letter| self.whole(letter));
    }

    /// The array.
    pub fn to_array<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let numpy = py.import("numpy")?;
        let kind = numpy.call_method1("dtype", (self.columns.to_vec(),))?;
        // A bytearray, so that the array is writeable.
        numpy.call_method1("frombuffer", (PyByteArray::new(py, &self.bytes), kind))
    }
}
