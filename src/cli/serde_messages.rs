//! Translates serde's error messages for users who do not write Rust.

use inbye::runtime::renamed_keys;
use inbye::suggest::closest_name;

/// Rust type names in messages, and their replacements.
const TYPES: [(&str, &str); 4] = [
    ("expected u32", "expected a whole number, at least 0"),
    ("expected usize", "expected a whole number, at least 0"),
    ("expected f64", "expected a number"),
    ("expected a sequence", "expected a list"),
];

/// Returns a message on one line without Rust type names. For an unknown key or value it suggests the closest known one.
/// `table_of` names the table of a key that exists elsewhere.
pub fn plain_message(message: &str, table_of: impl Fn(&str) -> Option<String>) -> String {
    // A quoted key may contain line breaks.
    let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
    let plain = TYPES.iter().fold(message.clone(), |text, (rust, plain)| text.replace(rust, plain));
    let plain = match plain.split_once("expected struct ") {
        Some((before, _name)) => format!("{before}expected a table of keys and values"),
        None => plain,
    };
    match suggestion(&message, table_of) {
        Some(suggestion) => format!("{plain}: {suggestion}"),
        None => plain,
    }
}

fn suggestion(message: &str, table_of: impl Fn(&str) -> Option<String>) -> Option<String> {
    if !message.starts_with("unknown ") {
        return None;
    }
    let mut quoted = message.split('`').skip(1).step_by(2);
    let given = quoted.next()?;
    if let Some((_, now)) = renamed_keys().find(|(old, _)| *old == given) {
        return Some(format!("`{given}` is now `{now}`"));
    }
    if let Some(table) = table_of(given) {
        return Some(format!("`{given}` belongs in {table}"));
    }
    let known = closest_name(given, quoted)?;
    Some(format!("did you mean `{known}`?"))
}

#[cfg(test)]
mod tests {
    use super::{plain_message, suggestion};

    #[test]
    fn suggestion_names_similar_key_only() {
        let message =
            |key| format!("unknown field `{key}`, expected one of `max_vel_x`, `min_vel_x`");
        let suggested = |key| suggestion(&message(key), |_| None);
        assert_eq!(suggested("max_vel").as_deref(), Some("did you mean `max_vel_x`?"));
        assert_eq!(suggested("mxa_vel_x").as_deref(), Some("did you mean `max_vel_x`?"));
        assert_eq!(suggested("colour"), None);
        let elsewhere = suggestion(&message("beams"), |_| Some("[lidar]".to_owned()));
        assert_eq!(elsewhere.as_deref(), Some("`beams` belongs in [lidar]"));
    }

    #[test]
    fn plain_message_replaces_type_names() {
        let plain = plain_message("invalid type: string `u32`, expected u32", |_| None);
        assert_eq!(plain, "invalid type: string `u32`, expected a whole number, at least 0");
    }
}
