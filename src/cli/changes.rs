//! Settings put in place of others, key by key: what a file does not name stays as it was.

use anyhow::anyhow;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Settings with the changes of a TOML text.
pub fn onto<T: Serialize + DeserializeOwned>(ours: &T, text: &str) -> anyhow::Result<T> {
    // The error's first line names the place, the others draw it.
    let plain = |error: toml::de::Error| anyhow!("{}", error.message().to_owned());
    let changes: toml::Table = toml::from_str(text).map_err(plain)?;
    let mut table = toml::Table::try_from(ours)?;
    change(&mut table, changes);
    table.try_into().map_err(plain)
}

/// Puts values in place of others, table by table.
fn change(table: &mut toml::Table, changes: toml::Table) {
    for (name, value) in changes {
        match (table.get_mut(&name), value) {
            (Some(toml::Value::Table(within)), toml::Value::Table(changes))
                if !is_other_choice(within, &changes) =>
            {
                change(within, changes);
            }
            (_, value) => {
                table.insert(name, value);
            }
        }
    }
}

/// Whether two tables are different choices of one setting, such as `{ theta = { degrees = 30 } }` in place of
/// `{ normalized = { k = 1 } }`: such a table has one key, and is exchanged as a whole.
pub fn is_other_choice(ours: &toml::Table, theirs: &toml::Table) -> bool {
    let only = |table: &toml::Table| {
        let name = table.keys().next().cloned();
        name.filter(|_| table.len() == 1)
    };
    only(ours).is_some_and(|ours| only(theirs).is_some_and(|theirs| theirs != ours))
}
