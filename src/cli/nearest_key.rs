//! The key that was meant by one that does not exist.

/// Less alike than this, two words are not the same one mistyped.
const ALIKE: f64 = 0.75;

/// What to append to serde's message about a key or word that it does not know; none for other messages, and where
/// nothing comes near. `home` names the place where a key belongs that is right, but not here.
pub fn mend(message: &str, home: impl Fn(&str) -> Option<String>) -> Option<String> {
    if !message.starts_with("unknown ") {
        return None;
    }
    let mut quoted = message.split('`').skip(1).step_by(2);
    let given = quoted.next()?;
    if let Some(home) = home(given) {
        return Some(format!(": `{given}` belongs in {home}"));
    }
    let likeness = |known: &str| strsim::normalized_damerau_levenshtein(given, known);
    let (known, alike) = quoted
        .map(|known| (known, likeness(known)))
        .max_by(|one, other| one.1.total_cmp(&other.1))?;
    (alike >= ALIKE).then(|| format!(": did you mean `{known}`?"))
}

#[cfg(test)]
mod tests {
    use super::mend;

    #[test]
    fn a_slip_is_named_and_a_stranger_is_not() {
        let message = |key| format!("unknown field `{key}`, expected one of `max_vel_x`, `min_vel_x`");
        let mended = |key| mend(&message(key), |_| None);
        assert_eq!(mended("max_vel").as_deref(), Some(": did you mean `max_vel_x`?"));
        assert_eq!(mended("mxa_vel_x").as_deref(), Some(": did you mean `max_vel_x`?"));
        assert_eq!(mended("colour"), None);
        assert_eq!(mend("invalid type: `a`", |_| None), None);
        let elsewhere = mend(&message("beams"), |_| Some("[lidar]".to_owned()));
        assert_eq!(elsewhere.as_deref(), Some(": `beams` belongs in [lidar]"));
    }
}
