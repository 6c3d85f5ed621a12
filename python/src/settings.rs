//! The configuration, and plain values of Python as TOML.

use std::path::PathBuf;

use inbye::runtime;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyFloat, PyInt, PyList, PyMapping, PyRange, PyString, PyTuple, PyType};
use toml::{Table, Value};

use super::conversion::{from_json, raise};

/// Most levels of nested dictionaries and lists: one that contains itself has no end.
const MOST_LEVELS: usize = 32;

/// All settings of a robot, its navigation and its simulation: the defaults with changes.
#[pyclass(frozen, eq, module = "inbye")]
#[derive(PartialEq)]
pub struct Config {
    inner: runtime::Config,
    /// The changes. A world applies them to its own settings: a default that is one of them counts.
    changes: Table,
}

#[pymethods]
impl Config {
    /// The defaults with changes: a dictionary with the keys of a configuration file, or the text of such a file.
    #[new]
    #[pyo3(signature = (changes=None))]
    fn new(changes: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let changes = changes.map_or(Ok(String::new()), changes_text)?;
        let inner = runtime::Config::default().with_changes(&changes).map_err(raise)?;
        Ok(Self { inner, changes: changes.parse().map_err(raise)? })
    }

    /// The settings as a dictionary.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        from_json(py, &self.inner)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyType>, (String,)) {
        (slf.get_type(), (slf.get().changes.to_string(),))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("Config({})", self.to_dict(py)?.repr()?))
    }
}

/// The changes as TOML: those of a [`Config`], of a dictionary, or a TOML text as it is.
fn changes_text(changes: &Bound<'_, PyAny>) -> PyResult<String> {
    if let Ok(config) = changes.cast::<Config>() {
        return Ok(config.get().changes.to_string());
    }
    if let Ok(text) = changes.extract::<String>() {
        return Ok(text);
    }
    let changes = changes.cast::<PyMapping>().map_err(|_| {
        raise("settings are a Config, a dictionary such as {\"local\": {\"vx_samples\": 32}}, or TOML text")
    })?;
    toml_text(changes)
}

/// The default settings with changes.
pub fn settings(changes: Option<&Bound<'_, PyAny>>) -> PyResult<runtime::Config> {
    // Its changes are applied already.
    if let Some(Ok(config)) = changes.map(|changes| changes.cast::<Config>()) {
        return Ok(config.get().inner.clone());
    }
    changed(&runtime::Config::default(), changes)
}

/// Settings, such as those of a world, with changes.
pub fn changed(
    base: &runtime::Config,
    changes: Option<&Bound<'_, PyAny>>,
) -> PyResult<runtime::Config> {
    let Some(changes) = changes else { return Ok(base.clone()) };
    base.with_changes(&changes_text(changes)?).map_err(raise)
}

/// The TOML text of a dictionary.
pub fn toml_text(table: &Bound<'_, PyMapping>) -> PyResult<String> {
    Ok(table_of(table, "", 0)?.to_string())
}

/// The table of a dictionary. A key with the value None is left out, as `Config.to_dict` has those without a value.
fn table_of(mapping: &Bound<'_, PyMapping>, place: &str, level: usize) -> PyResult<Table> {
    let mut table = Table::new();
    for item in mapping.items()? {
        let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
        if value.is_none() {
            continue;
        }
        let inside = if place.is_empty() { String::new() } else { format!("{place}: ") };
        let key: String = key
            .extract()
            .map_err(|_| raise(format!("{inside}the key {key} is no text: keys are names")))?;
        let place = if place.is_empty() { key.clone() } else { format!("{place}.{key}") };
        table.insert(key, toml_value(&value, &place, level + 1)?);
    }
    Ok(table)
}

/// A value of a dictionary: texts, numbers, truth values, paths, settings, and what contains them; NumPy's scalars and arrays count
/// as those of Python.
fn toml_value(value: &Bound<'_, PyAny>, place: &str, level: usize) -> PyResult<Value> {
    if level > MOST_LEVELS {
        return Err(raise(format!("{place}: more than {MOST_LEVELS} levels")));
    }
    if value.is_instance_of::<PyBool>() {
        return Ok(Value::Boolean(value.extract()?));
    }
    if value.is_instance_of::<PyInt>() {
        let whole = value.extract();
        return whole
            .map(Value::Integer)
            .map_err(|_| raise(format!("{place}: {value} is too large")));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(value.extract()?));
    }
    if value.is_instance_of::<PyString>() {
        return Ok(Value::String(value.extract()?));
    }
    if let Ok(config) = value.cast::<Config>() {
        return Ok(Value::Table(config.get().changes.clone()));
    }
    if let Ok(mapping) = value.cast::<PyMapping>() {
        return Ok(Value::Table(table_of(mapping, place, level)?));
    }
    if value.is_instance_of::<PyList>()
        || value.is_instance_of::<PyTuple>()
        || value.is_instance_of::<PyRange>()
    {
        let value_at = |(index, item): (usize, PyResult<Bound<'_, PyAny>>)| {
            toml_value(&item?, &format!("{place}[{index}]"), level + 1)
        };
        return value
            .try_iter()?
            .enumerate()
            .map(value_at)
            .collect::<PyResult<_>>()
            .map(Value::Array);
    }
    if value.hasattr("__fspath__")? {
        let path: PathBuf = value.extract()?;
        return path
            .into_os_string()
            .into_string()
            .map(Value::String)
            .map_err(|path| raise(format!("{place}: {} is no UTF-8: rename it", path.display())));
    }
    // A scalar or an array of NumPy. A class has the method too, but no value.
    match value.getattr_opt("tolist")? {
        Some(tolist) if !value.is_instance_of::<PyType>() => {
            toml_value(&tolist.call0()?, place, level + 1)
        }
        _ => {
            let kind = value.get_type().name()?;
            Err(raise(format!(
                "{place}: a value of type {kind} cannot be used: give a number, text, truth value, list or dictionary"
            )))
        }
    }
}
