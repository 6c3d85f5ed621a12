//! What the program tells of its settings is what the code has: every key, its default, and a range that is kept.

use inbye::base::BaseConfig;
use inbye::runtime::Config;
use inbye::settings::KeyDescription;
use serde::Serialize;
use toml::{Table, Value};

/// Keys without a default.
const OPTIONAL: [&str; 2] = ["navigator.deadline_s", "base.min_battery_v"];

/// A kind of configuration.
struct Kind {
    text: String,
    keys: Vec<KeyDescription>,
    defaults: Table,
    /// Reads a text and checks it; the settings written again, or what is wrong.
    read: fn(&str) -> Result<Table, String>,
}

fn kinds() -> [Kind; 2] {
    let run = Kind {
        text: Config::documented(),
        keys: Config::keys(),
        defaults: table(&Config::default()),
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
        let path = if path.is_empty() {
            key.clone()
        } else {
            format!("{path}.{key}")
        };
        match value.as_table() {
            Some(table) if !whole(&path) => leaves(table, &path, whole, found),
            _ => found.push(path),
        }
    }
}

#[test]
fn every_key_is_described_and_every_description_has_its_key() {
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
            assert_eq!(known.default.as_ref(), at(&kind.defaults, &known.key));
            assert!(known.says.len() > 15, "{}: {:?}", known.key, known.says);
            assert!(known.says.ends_with('.'), "{}: {}", known.key, known.says);
            assert!(!known.says.contains("[`"), "{}: a link", known.key);
        }
    }
}

#[test]
fn the_text_is_the_default_and_names_each_key_once() {
    for kind in kinds() {
        assert_eq!((kind.read)(&kind.text).as_ref(), Ok(&kind.defaults));
        // Not by what is left out: the text itself has each value.
        let written: Table = kind.text.parse().expect("the text is TOML");
        assert_eq!(written, kind.defaults);
        for known in &kind.keys {
            let name = known.key.rsplit('.').next().expect("a path has an end");
            let line = |line: &&str| {
                let line = line.strip_prefix("# ").unwrap_or(line);
                line.starts_with(&format!("{name} = "))
            };
            let of_that_name = |other: &&KeyDescription| other.key.rsplit('.').next() == Some(name);
            assert_eq!(
                kind.text.lines().filter(line).count(),
                kind.keys.iter().filter(of_that_name).count(),
                "{name}"
            );
        }
        assert!(kind.text.lines().all(|line| line.chars().count() <= 120));
    }
    let again = kinds().map(|kind| kind.text);
    assert_eq!(kinds().map(|kind| kind.text), again);
}

#[test]
fn what_has_no_default_is_commented_out_with_an_example_that_works() {
    for kind in kinds() {
        let optional: Vec<&str> = OPTIONAL
            .into_iter()
            .filter(|key| kind.keys.iter().any(|known| known.key == *key))
            .collect();
        assert_eq!(optional.len(), 1);
        let name = optional[0].rsplit('.').next().expect("a path has an end");
        let text = kind
            .text
            .replace(&format!("# {name} = "), &format!("{name} = "));
        assert_ne!(text, kind.text);
        let read = (kind.read)(&text).expect("the example is within its range");
        assert!(at(&read, optional[0]).is_some_and(Value::is_float));
    }
}

/// A number in words or figures, or the default of the key beside it.
fn figure(word: &str, beside: &Table) -> Option<f64> {
    let word = word.trim_matches(|letter: char| !letter.is_alphanumeric() && letter != '-');
    match word {
        "zero" => Some(0.0),
        "one" => Some(1.0),
        "pi" => Some(core::f64::consts::PI),
        word => match beside.get(word) {
            Some(value) => number(value),
            None => word.replace(',', "").parse().ok(),
        },
    }
}

fn number(value: &Value) -> Option<f64> {
    value
        .as_float()
        .or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// Numbers just outside the range that a text states.
fn outside(says: &str, beside: &Table, whole: bool) -> Vec<f64> {
    let stated = says.split("Default").next().unwrap_or_default();
    let words: Vec<&str> = stated.split_whitespace().collect();
    let below = |number: f64| {
        if whole {
            number - 1.0
        } else {
            number.next_down()
        }
    };
    let above = |number: f64| {
        if whole {
            number + 1.0
        } else {
            number.next_up()
        }
    };
    let mut found = Vec::new();
    for at in 0..words.len().saturating_sub(1) {
        let after = |skip: usize| words.get(at + skip).and_then(|word| figure(word, beside));
        match (words[at], words[at + 1]) {
            ("above" | "below", _) => found.extend(after(1)),
            ("at", "least") => found.extend(after(2).map(below)),
            ("at", "most") => found.extend(after(2).map(above)),
            (_, "to" | "or") => {
                if let (Some(least), Some(most)) = (after(0), after(2)) {
                    found.extend([below(least), above(most)]);
                }
            }
            _ => {}
        }
    }
    found
}

#[test]
fn every_number_says_its_range_and_is_kept_to_it() {
    let mut tried = 0;
    for kind in kinds() {
        for known in &kind.keys {
            let example = Value::Float(1.0);
            let default = known.default.as_ref().unwrap_or(&example);
            // Pairs of numbers, one of each track, are tried by their left one.
            let (suffix, default) = match default.get("left") {
                Some(left) => (".left", left),
                None => ("", default),
            };
            if number(default).is_none() {
                continue;
            }
            let whole = default.is_integer();
            let (parent, _) = known.key.rsplit_once('.').expect("numbers are in tables");
            let beside = at(&kind.defaults, parent).and_then(Value::as_table);
            let mut wrong = outside(&known.says, beside.expect("its table"), whole);
            assert!(
                !wrong.is_empty(),
                "{} says no range: {}",
                known.key,
                known.says
            );
            if !whole {
                wrong.extend([f64::NAN, f64::INFINITY]);
            }
            for wrong in wrong {
                let value = if whole {
                    Value::Integer(wrong as i64)
                } else {
                    Value::Float(wrong)
                };
                let mut spoilt = kind.defaults.clone();
                set(&mut spoilt, &format!("{}{suffix}", known.key), value);
                let text = toml::to_string(&spoilt).expect("settings are TOML");
                let read = (kind.read)(&text);
                assert!(read.is_err(), "{} = {wrong} is not refused", known.key);
                tried += 1;
            }
        }
    }
    assert!(tried > 200, "{tried}");
}

/// Puts a value at a path, the tables of which are there, but for the key itself.
fn set(root: &mut Table, path: &str, value: Value) {
    let (parent, key) = path.rsplit_once('.').unwrap_or(("", path));
    let mut table = root;
    for name in parent.split('.').filter(|name| !name.is_empty()) {
        table = table[name].as_table_mut().expect("a table of that path");
    }
    table.insert(key.to_owned(), value);
}

#[test]
fn every_word_that_may_be_chosen_is_named() {
    let mut tried = 0;
    for kind in kinds() {
        for known in &kind.keys {
            let Some(Value::String(_)) = &known.default else {
                continue;
            };
            let mut spoilt = kind.defaults.clone();
            let word = Value::String("?".to_owned());
            set(&mut spoilt, &known.key, word);
            let text = toml::to_string(&spoilt).expect("settings are TOML");
            let refusal = (kind.read)(&text).expect_err("a question mark is no choice");
            let (_, choices) = refusal.split_once("expected ").expect("what is expected");
            for choice in choices.split('`').skip(1).step_by(2) {
                let quoted = format!("`{choice}`");
                assert!(known.says.contains(&quoted), "{}: no {quoted}", known.key);
                tried += 1;
            }
        }
    }
    assert!(tried >= 10, "{tried}");
}

/// A default that the text names in its reasons is the one in the code.
#[test]
fn defaults_in_words_are_those_of_the_code() {
    let mut compared = 0;
    for known in kinds().iter().flat_map(|kind| &kind.keys) {
        let (Some((_, after)), Some(default)) = (known.says.split_once("Default "), &known.default)
        else {
            continue;
        };
        let word = after.split([' ', ':', ';']).next().unwrap_or_default();
        let word = word.trim_end_matches(['.', ',']).replace(',', "");
        let default = default.get("left").unwrap_or(default);
        if let (Ok(said), Some(value)) = (word.parse::<f64>(), number(default)) {
            assert_eq!(said, value, "{}", known.key);
            compared += 1;
        }
    }
    assert!(compared > 40, "{compared}");
}
