//! What serde says about a file, in words for people who do not write Rust.

use inbye::suggest::closest_name;

/// Names of Rust's types, and what to write.
const TYPES: [(&str, &str); 4] = [
    ("expected u32", "expected a whole number, at least 0"),
    ("expected usize", "expected a whole number, at least 0"),
    ("expected f64", "expected a number"),
    ("expected a sequence", "expected a list"),
];

/// A message of serde's in one line, without names of types; with the mend, where the message is about a key or word that does not
/// exist and there is one that is like it. `home` names the place where a key belongs that is right, but not here.
pub fn plain_words(message: &str, home: impl Fn(&str) -> Option<String>) -> String {
    // A key in quotes may hold line breaks, and is told as it is.
    let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
    let plain = TYPES.iter().fold(message.clone(), |text, (rust, plain)| {
        text.replace(rust, plain)
    });
    let plain = match plain.split_once("expected struct ") {
        Some((before, _name)) => format!("{before}expected a table of keys and values"),
        None => plain,
    };
    match mend(&message, home) {
        Some(mend) => format!("{plain}: {mend}"),
        None => plain,
    }
}

fn mend(message: &str, home: impl Fn(&str) -> Option<String>) -> Option<String> {
    if !message.starts_with("unknown ") {
        return None;
    }
    let mut quoted = message.split('`').skip(1).step_by(2);
    let given = quoted.next()?;
    if let Some(home) = home(given) {
        return Some(format!("`{given}` belongs in {home}"));
    }
    let known = closest_name(given, quoted)?;
    Some(format!("did you mean `{known}`?"))
}

#[cfg(test)]
mod tests {
    use super::{mend, plain_words};

    #[test]
    fn a_slip_is_named_and_a_stranger_is_not() {
        let message =
            |key| format!("unknown field `{key}`, expected one of `max_vel_x`, `min_vel_x`");
        let mended = |key| mend(&message(key), |_| None);
        assert_eq!(
            mended("max_vel").as_deref(),
            Some("did you mean `max_vel_x`?")
        );
        assert_eq!(
            mended("mxa_vel_x").as_deref(),
            Some("did you mean `max_vel_x`?")
        );
        assert_eq!(mended("colour"), None);
        let elsewhere = mend(&message("beams"), |_| Some("[lidar]".to_owned()));
        assert_eq!(elsewhere.as_deref(), Some("`beams` belongs in [lidar]"));
    }

    #[test]
    fn types_have_plain_names() {
        let said = plain_words("invalid type: string `u32`, expected u32", |_| None);
        assert_eq!(
            said,
            "invalid type: string `u32`, expected a whole number, at least 0"
        );
    }
}
