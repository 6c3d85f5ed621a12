//! Styles for programs that know CSS, but no variables: most that turn an SVG file into pixels.

const COLOURS: &str = include_str!("colours.css");

/// The same style with the light theme's values in place of the variables that `colours.css` names. A variable that it
/// does not name stays.
pub(super) fn plain(style: &str) -> String {
    let mut parts = style.split("var(");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let used = part
            .split_once(')')
            .and_then(|(name, rest)| Some((value(name)?, rest)));
        if let Some((value, rest)) = used {
            text.push_str(value);
            text.push_str(rest);
        } else {
            text.push_str("var(");
            text.push_str(part);
        }
    }
    text
}

/// The first value that the colours give a variable: that of the light theme.
fn value(name: &str) -> Option<&'static str> {
    COLOURS.split([';', '{']).find_map(|declaration| {
        let (declared, value) = declaration.split_once(':')?;
        (declared.trim() == name).then(|| value.trim())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_become_the_light_theme() {
        assert_eq!(
            plain(
                "a { fill: var(--ink); stroke: var(--panel); } b { opacity: var(--rock-strength) }"
            ),
            "a { fill: #1a1e24; stroke: #ffffff; } b { opacity: .75 }"
        );
        assert_eq!(plain("a { fill: var(--none) }"), "a { fill: var(--none) }");
        assert_eq!(plain(""), "");
    }
}
