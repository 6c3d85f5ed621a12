//! The configuration.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::conversion::{from_json, raise};

/// All settings of a robot, its navigation and its simulation.
#[pyclass(frozen, eq, module = "inbye")]
#[derive(Clone, PartialEq)]
pub struct Config {
    pub inner: inbye::runtime::Config,
}

#[pymethods]
impl Config {
    /// The defaults with changes: a dictionary with the keys of a configuration file, or the text of such a file.
    #[new]
    #[pyo3(signature = (changes=None))]
    fn new(changes: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        Ok(Self { inner: changed(&inbye::runtime::Config::default(), changes)? })
    }

    /// The settings as a dictionary.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        from_json(py, &self.inner)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("Config({})", self.to_dict(py)?.repr()?))
    }
}

/// Settings with changes: a [`Config`], which replaces them, a dictionary, or a TOML text.
pub fn changed(
    base: &inbye::runtime::Config,
    changes: Option<&Bound<'_, PyAny>>,
) -> PyResult<inbye::runtime::Config> {
    let Some(changes) = changes else { return Ok(base.clone()) };
    if let Ok(config) = changes.cast::<Config>() {
        return Ok(config.get().inner.clone());
    }
    base.with_changes(&toml_text(changes)?).map_err(raise)
}

/// The TOML text of a dictionary; a text as it is.
pub fn toml_text(changes: &Bound<'_, PyAny>) -> PyResult<String> {
    if let Ok(text) = changes.extract::<String>() {
        return Ok(text);
    }
    let changes = changes.cast::<PyDict>().map_err(|_| {
        raise("settings are a Config, a dictionary such as {\"local\": {\"vx_samples\": 32}}, or TOML text")
    })?;
    let json = changes.py().import("json")?.call_method1("dumps", (changes,))?;
    let table: toml::Table = serde_json::from_str(&json.extract::<String>()?).map_err(raise)?;
    Ok(table.to_string())
}
