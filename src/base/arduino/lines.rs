//! Parsing of answer lines.

/// Longest valid answer line, bytes: two signed 32-bit integers.
pub(super) const MAX_LINE: usize = 24;

/// An answer of the firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// `OK`.
    Ok,
    /// Two integers: the encoder counts of the first and the second channel, modulo 2^32.
    Counts([u32; 2]),
}

/// Parses a line without its line end; returns none for any other line.
///
/// Counts are two 32-bit integers separated by one space, without plus sign, extra spaces or leading zeros. The firmware writes
/// them so; any other spelling is a damaged line.
#[must_use]
pub fn parse_answer(line: &[u8]) -> Option<Answer> {
    if line == b"OK" {
        return Some(Answer::Ok);
    }
    let text = core::str::from_utf8(line).ok()?;
    let (first, second) = text.split_once(' ')?;
    Some(Answer::Counts([count(first)?, count(second)?]))
}

fn count(text: &str) -> Option<u32> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let is_canonical =
        digits == "0" && text == "0" || digits.starts_with(|first| matches!(first, '1'..='9'));
    if !is_canonical {
        return None;
    }
    text.parse::<i32>().ok().map(|count| count as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parse_answer_accepts_firmware_spelling_only() {
        let counts = |first: i32, second: i32| Some(Answer::Counts([first as u32, second as u32]));
        for (line, answer) in [
            ("OK", Some(Answer::Ok)),
            ("0 0", counts(0, 0)),
            ("1234 -567", counts(1234, -567)),
            ("-2147483648 2147483647", counts(i32::MIN, i32::MAX)),
            ("2147483648 0", None),
            ("12", None),
            ("1 2 3", None),
            ("1  2", None),
            (" 1 2", None),
            ("1 2 ", None),
            ("+1 2", None),
            ("-0 2", None),
            ("01 2", None),
            ("1x 2", None),
            ("ok", None),
            ("OKOK", None),
            ("Invalid Command", None),
            ("", None),
            (" ", None),
        ] {
            assert_eq!(parse_answer(line.as_bytes()), answer, "{line:?}");
        }
        assert_eq!(parse_answer(&[0xFF, 0x20, 0x31]), None);
    }
}
