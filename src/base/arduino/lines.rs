//! What a line of answer says.

/// Longest line of answer that is of use: two integers of 32 bits with their signs.
pub(super) const LONGEST: usize = 24;

/// An answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// `OK`.
    Done,
    /// Two integers: the counts of the first and the second channel, modulo 2^32.
    Counts([u32; 2]),
}

/// The answer in a line without its end, or none in any other line.
///
/// Two integers of 32 bits with a single space between them and nothing else: no plus sign, no second space, no zero in
/// front. The firmware writes them so, and every other spelling is a damaged line.
#[must_use]
pub fn read_answer(line: &[u8]) -> Option<Answer> {
    if line == b"OK" {
        return Some(Answer::Done);
    }
    let text = core::str::from_utf8(line).ok()?;
    let (first, second) = text.split_once(' ')?;
    Some(Answer::Counts([count(first)?, count(second)?]))
}

fn count(text: &str) -> Option<u32> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let plain =
        digits == "0" && text == "0" || digits.starts_with(|first| matches!(first, '1'..='9'));
    if !plain {
        return None;
    }
    text.parse::<i32>().ok().map(|count| count as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_firmwares_own_spelling_is_an_answer() {
        let counts = |first: i32, second: i32| Some(Answer::Counts([first as u32, second as u32]));
        for (line, answer) in [
            ("OK", Some(Answer::Done)),
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
            assert_eq!(read_answer(line.as_bytes()), answer, "{line:?}");
        }
        assert_eq!(read_answer(&[0xFF, 0x20, 0x31]), None);
    }
}
