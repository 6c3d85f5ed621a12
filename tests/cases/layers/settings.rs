//! Each setting is declared once: its documentation, its default, its range and the schema agree.

use inbye::base::BaseConfig;
use inbye::runtime::Config;
use inbye::settings::{KeyDescription, Range, line_in_json, line_in_toml};
use serde::Serialize;
use toml::{Table, Value};

/// Keys without a default.
const OPTIONAL: [&str; 3] =
    ["navigator.deadline_s", "simulation.lidar.scan_rate_hz", "base.min_battery_v"];

/// A kind of configuration.
struct Kind {
    text: String,
    keys: Vec<KeyDescription>,
    defaults: Table,
    schema: serde_json::Value,
    /// Reads and checks a text. Returns the settings as a table, or the error.
    read: fn(&str) -> Result<Table, String>,
}

fn kinds() -> [Kind; 2] {
    let run = Kind {
        text: Config::documented(),
        keys: Config::keys(),
        defaults: table(&Config::default()),
        schema: Config::schema(),
        read: |text| {
            let config: Config = toml::from_str(text).map_err(|error| error.to_string())?;
            config.validate().map_err(|error| error.to_string())?;
            Ok(table(&config))
        },
    };
    let base = Kind {
        text: BaseConfig::documented(),
        keys: BaseConfig::keys(),
        defaults: table(&BaseConfig::default()),
        schema: BaseConfig::schema(),
        read: |text| {
            let config: BaseConfig = toml::from_str(text).map_err(|error| error.to_string())?;
            config.validate().map_err(|error| error.to_string())?;
            Ok(table(&config))
        },
    };
    [run, base]
}

fn table(settings: &impl Serialize) -> Table {
    Table::try_from(settings).expect("settings are tables")
}

/// The value at a path.
fn at<'a>(root: &'a Table, path: &str) -> Option<&'a Value> {
    let (table, key) = match path.rsplit_once('.') {
        Some((parent, key)) => (at(root, parent)?.as_table()?, key),
        None => (root, path),
    };
    table.get(key)
}

/// The paths of all values that are no tables, or that `whole` knows as one.
fn leaves(root: &Table, path: &str, whole: &dyn Fn(&str) -> bool, found: &mut Vec<String>) {
    for (key, value) in root {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        match value.as_table() {
            Some(table) if !whole(&path) => leaves(table, &path, whole, found),
            _ => found.push(path),
        }
    }
}

/// The default of a key as a TOML value.
fn default_of(known: &KeyDescription) -> Option<Value> {
    let default = known.default.as_ref()?;
    Some(Value::try_from(default).expect("defaults are TOML values"))
}

#[test]
fn every_key_has_a_description_and_every_description_a_key() {
    for kind in kinds() {
        let described: Vec<&str> = kind.keys.iter().map(|known| known.key.as_str()).collect();
        let mut found = Vec::new();
        let whole = |path: &str| described.contains(&path);
        leaves(&kind.defaults, "", &whole, &mut found);
        let optional = described.iter().filter(|key| OPTIONAL.contains(key));
        found.extend(optional.map(ToString::to_string));
        found.sort_unstable();
        let mut described = described.clone();
        described.sort_unstable();
        assert_eq!(described, found);
        for known in &kind.keys {
            assert_eq!(default_of(known).as_ref(), at(&kind.defaults, &known.key));
            let text = &known.description;
            assert!(text.len() > 15, "{}: {text:?}", known.key);
            assert!(text.ends_with('.'), "{}: {text}", known.key);
            assert!(!text.contains("[`"), "{}: a link", known.key);
        }
    }
}

#[test]
fn commented_toml_is_the_default_configuration() {
    for kind in kinds() {
        assert_eq!((kind.read)(&kind.text).as_ref(), Ok(&kind.defaults));
        // The text itself has each value.
        let written: Table = kind.text.parse().expect("the text is TOML");
        assert_eq!(written, kind.defaults);
        for known in &kind.keys {
            let name = known.key.rsplit('.').next().expect("a path has an end");
            let line = |line: &&str| {
                let line = line.strip_prefix("# ").unwrap_or(line);
                line.starts_with(&format!("{name} = "))
            };
            let has_name = |other: &&KeyDescription| other.key.rsplit('.').next() == Some(name);
            assert_eq!(
                kind.text.lines().filter(line).count(),
                kind.keys.iter().filter(has_name).count(),
                "{name}"
            );
        }
        assert!(kind.text.lines().all(|line| line.chars().count() <= 120));
    }
}

#[test]
fn key_without_default_is_commented_out_with_a_valid_example() {
    for kind in kinds() {
        let optional: Vec<&str> = OPTIONAL
            .into_iter()
            .filter(|key| kind.keys.iter().any(|known| known.key == *key))
            .collect();
        assert!(!optional.is_empty());
        for key in optional {
            let name = key.rsplit('.').next().expect("a path has an end");
            let text = kind.text.replace(&format!("# {name} = "), &format!("{name} = "));
            assert_ne!(text, kind.text);
            let read = (kind.read)(&text).expect("the example is within its range");
            assert!(at(&read, key).is_some_and(Value::is_float), "{key}");
        }
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// The numbers next to a range's bounds, outside it.
fn outside(range: &Range, is_whole: bool) -> Vec<f64> {
    let mut found = Vec::new();
    if range.min.is_finite() {
        found.push(match (range.is_min_open, is_whole) {
            (true, _) => range.min,
            (false, true) => range.min - 1.0,
            (false, false) => range.min.next_down(),
        });
    }
    if range.max.is_finite() {
        found.push(match (range.is_max_open, is_whole) {
            (true, _) => range.max,
            (false, true) => range.max + 1.0,
            (false, false) => range.max.next_up(),
        });
    }
    found
}

#[test]
fn every_number_has_a_range_and_is_rejected_outside_it() {
    let mut tried = 0;
    for kind in kinds() {
        for known in &kind.keys {
            let least = known.range.map_or(1.0, |range| range.min.max(1.0));
            let default = default_of(known).unwrap_or(Value::Float(least));
            // Pairs of numbers, one of each track, are tried by their left one.
            let (suffix, default) = match default.get("left") {
                Some(left) => (".left", left.clone()),
                None => ("", default),
            };
            let Some(number) = number(&default) else {
                continue;
            };
            let range = known.range.expect("a number has a range");
            assert!(range.contains(number), "{}", known.key);
            assert!(known.description.contains(range.text), "{}", known.key);
            let is_whole = default.is_integer();
            let mut wrong = outside(&range, is_whole);
            if !is_whole {
                wrong.extend([f64::NAN, f64::INFINITY]);
            }
            for wrong in wrong {
                let value =
                    if is_whole { Value::Integer(wrong as i64) } else { Value::Float(wrong) };
                let mut changed = kind.defaults.clone();
                set(&mut changed, &format!("{}{suffix}", known.key), value);
                let text = toml::to_string(&changed).expect("settings are TOML");
                let read = (kind.read)(&text);
                assert!(read.is_err(), "{} = {wrong} is accepted", known.key);
                tried += 1;
            }
        }
    }
    assert!(tried > 200, "{tried}");
}

/// Sets the value at a path whose tables exist.
fn set(root: &mut Table, path: &str, value: Value) {
    let (parent, key) = path.rsplit_once('.').unwrap_or(("", path));
    let mut table = root;
    for name in parent.split('.').filter(|name| !name.is_empty()) {
        table = table[name].as_table_mut().expect("a table of that path");
    }
    table.insert(key.to_owned(), value);
}

/// The schema of a key.
fn schema_of<'a>(kind: &'a Kind, key: &str) -> &'a serde_json::Value {
    key.split('.').fold(&kind.schema, |schema, name| &schema["properties"][name])
}

#[test]
fn every_choice_is_in_the_description_and_in_the_schema() {
    let mut tried = 0;
    for kind in kinds() {
        for known in &kind.keys {
            let Some(Value::String(_)) = default_of(known) else {
                continue;
            };
            let mut changed = kind.defaults.clone();
            set(&mut changed, &known.key, Value::String("?".to_owned()));
            let text = toml::to_string(&changed).expect("settings are TOML");
            let error = (kind.read)(&text).expect_err("a question mark is no choice");
            let (_, choices) = error.split_once("expected ").expect("what is expected");
            let in_schema = schema_of(&kind, &known.key)["enum"].as_array();
            for choice in choices.split('`').skip(1).step_by(2) {
                let quoted = format!("`{choice}`");
                assert!(known.description.contains(&quoted), "{}: {quoted}", known.key);
                if let Some(words) = in_schema {
                    assert!(words.contains(&choice.into()), "{}: {choice}", known.key);
                }
                tried += 1;
            }
        }
    }
    assert!(tried >= 10, "{tried}");
}

#[test]
fn schema_has_type_default_and_bounds_of_every_key() {
    for kind in kinds() {
        assert!(kind.schema["$schema"].as_str().is_some_and(|uri| uri.contains("2020-12")));
        for known in &kind.keys {
            let schema = schema_of(&kind, &known.key);
            assert_eq!(schema["description"], known.description.as_str());
            assert_eq!(schema.get("default"), known.default.as_ref(), "{}", known.key);
            // One of several forms, as that of a footprint, has a type each.
            let forms = schema.get("anyOf").and_then(serde_json::Value::as_array);
            let has_type =
                |form: &serde_json::Value| form.get("type").or(form.get("enum")).is_some();
            let is_typed =
                forms.map_or_else(|| has_type(schema), |forms| forms.iter().all(has_type));
            assert!(is_typed, "{}: {schema}", known.key);
            let Some(range) = known.range else { continue };
            let bound = |closed: &str, open: &str| {
                let value = schema.get(closed).or(schema.get(open));
                value.and_then(serde_json::Value::as_f64)
            };
            let finite = |bound: f64| bound.is_finite().then_some(bound);
            assert_eq!(bound("minimum", "exclusiveMinimum"), finite(range.min));
            assert_eq!(bound("maximum", "exclusiveMaximum"), finite(range.max));
        }
    }
}

/// A default in the text equals the one in the code.
#[test]
fn defaults_in_descriptions_are_those_of_the_code() {
    let mut compared = 0;
    for known in kinds().iter().flat_map(|kind| &kind.keys) {
        let (Some((_, after)), Some(default)) =
            (known.description.split_once("Default "), default_of(known))
        else {
            continue;
        };
        let word = after.split([' ', ':', ';']).next().unwrap_or_default();
        let word = word.trim_end_matches(['.', ',']).replace(',', "");
        let default = default.get("left").unwrap_or(&default);
        if let (Ok(stated), Some(value)) = (word.parse::<f64>(), number(default)) {
            assert_eq!(stated, value, "{}", known.key);
            compared += 1;
        }
    }
    assert!(compared > 40, "{compared}");
}

#[test]
fn line_is_that_of_the_key_or_its_table() {
    let toml = "top = 1\n[a.b]\nc = 2\n\n[[list]]\nx = 1\n[[list]]\nx = [\n 1,\n 2]\n[\"dot.ted\"]\ny = {z = 1}\n";
    for (path, line) in [
        ("top", Some(1)),
        ("a.b.c", Some(3)),
        ("a.b.missing", Some(2)),
        ("list.0.x", Some(6)),
        ("list.1.y", Some(7)),
        ("list.1.x.1", Some(10)),
        ("dot.ted.y.z", Some(12)),
        ("top.deeper", Some(1)),
        ("gone.x", None),
    ] {
        assert_eq!(line_in_toml(path, toml), line, "{path}");
    }
    let json = "[\n{\"x\": 1,\n\"y\":\n2},\n{\"x\": [\n3,\n4]}\n]";
    for (path, line) in
        [("0.x", Some(2)), ("0.y", Some(4)), ("1.", Some(5)), ("1.x.1", Some(7)), ("2", None)]
    {
        assert_eq!(line_in_json(path, json), line, "{path}");
    }
}
