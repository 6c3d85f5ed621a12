//! Settings whose documentation is also told by the program: one text for rustdoc and for `inbye config --print`.
//!
//! `documented!` takes a settings struct as it stands and gives it, beside the struct itself, a table of its keys and of
//! what their comments say. A room that has a whole configuration names the tables in it, and `commented_toml` writes
//! them with the default of each key, as it is in the code.

use toml::{Table, Value};

/// Keys of a table and what they do, in the order in which they stand in the code.
pub(crate) type Keys = &'static [(&'static str, &'static str)];

/// Longest line of a comment, characters.
const WIDTH: usize = 118;

/// What stands before the example of a key that has no default.
const EXAMPLE: &str = "such as ";

/// A struct of settings, each with a comment, that keeps its comments as `KEYS`.
macro_rules! documented {
    (
        $(#[$about:meta])*
        pub struct $name:ident {
            $($(#[doc = $says:literal])+ pub $key:ident: $kind:ty,)+
        }
    ) => {
        $(#[$about])*
        pub struct $name {
            $($(#[doc = $says])+ pub $key: $kind,)+
        }

        impl $name {
            /// Its keys and what they do.
            pub(crate) const KEYS: $crate::documented::Keys =
                &[$((stringify!($key), concat!($($says),+)),)+];
        }
    };
}
pub(crate) use documented;

/// The TOML of a configuration with all defaults and with what each key does. `tables` are the path of each table in it, the
/// root's empty, and its keys. A key without a default is commented out, with the example that its text has.
pub(crate) fn commented_toml(heading: &str, tables: &[(&str, Keys)], defaults: &Table) -> String {
    let mut text = comment(heading);
    for (path, keys) in tables {
        if !path.is_empty() {
            text += &["\n", &comment(about(tables, path)), "[", path, "]\n"].concat();
        }
        let table = at(defaults, path);
        let is_table = |key: &str| tables.iter().any(|(other, _)| *other == join(path, key));
        for (key, says) in keys.iter().filter(|(key, _)| !is_table(key)) {
            let line = match table.and_then(|table| table.get(*key)) {
                Some(value) => format!("{key} = {value}"),
                None => format!("# {key} = {}", example(says)),
            };
            text += &["\n", &comment(says), &line, "\n"].concat();
        }
    }
    text
}

/// Every key that a configuration has, by its path, with its default and with what it does.
pub(crate) fn described(tables: &[(&str, Keys)], defaults: &Table) -> Vec<Described> {
    let mut all = Vec::new();
    for (path, keys) in tables {
        for (key, says) in *keys {
            let key_path = join(path, key);
            if !tables.iter().any(|(other, _)| *other == key_path) {
                all.push(Described {
                    default: at(defaults, path)
                        .and_then(|table| table.get(*key))
                        .cloned(),
                    key: key_path,
                    says: says.trim().to_owned(),
                });
            }
        }
    }
    all
}

/// A key of a configuration.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Described {
    /// Its path from the root, such as `robot.limits.max_vel_x`.
    pub key: String,
    /// Its value when it is left out; none where that differs from every value.
    pub default: Option<Value>,
    /// What it does, in which unit, in which range.
    pub says: String,
}

/// What the table's own key says of it.
fn about(tables: &[(&str, Keys)], path: &str) -> &'static str {
    let (parent, name) = path.rsplit_once('.').unwrap_or(("", path));
    let keys = tables.iter().find(|(other, _)| *other == parent);
    let found = keys.and_then(|(_, keys)| keys.iter().find(|(key, _)| *key == name));
    found.map_or("", |(_, says)| says)
}

fn at<'a>(root: &'a Table, path: &str) -> Option<&'a Table> {
    let mut names = path.split('.').filter(|name| !name.is_empty());
    names.try_fold(root, |table, name| table.get(name)?.as_table())
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() {
        key.to_owned()
    } else {
        format!("{path}.{key}")
    }
}

fn example(says: &str) -> &str {
    let after = says.split_once(EXAMPLE).map_or("", |(_, after)| after);
    let word = after.split_whitespace().next().unwrap_or_default();
    word.trim_end_matches([',', ';', ':', '.'])
}

fn comment(says: &str) -> String {
    let mut text = String::new();
    let mut line = String::from("#");
    for word in says.split_whitespace() {
        if line.chars().count() + 1 + word.chars().count() > WIDTH {
            text += &line;
            text += "\n";
            line = String::from("#");
        }
        line += " ";
        line += word;
    }
    text + &line + "\n"
}
