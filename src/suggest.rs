//! Texts of messages: suggestions for misspelled names, and texts without line breaks and Rust type names.

use strsim::normalized_damerau_levenshtein;

/// Smallest similarity of a misspelling, from 0 (nothing in common) to 1 (equal).
const MIN_SIMILARITY: f64 = 0.75;

/// Least length of the beginning of a name that suggests it.
const MIN_BEGINNING: usize = 4;

/// The known name most similar to a given one, if any is similar enough. The only name that begins with the given one comes first: a
/// unit is easily left out.
///
/// ```
/// use inbye::suggest::closest_name;
/// let known = ["max_vel_x", "min_vel_x"];
/// assert_eq!(closest_name("mxa_vel_x", known), Some("max_vel_x"));
/// assert_eq!(closest_name("colour", known), None);
/// assert_eq!(closest_name("mount_yaw", ["mount_y_m", "mount_yaw_rad"]), Some("mount_yaw_rad"));
/// ```
pub fn closest_name<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let known: Vec<&str> = known.into_iter().collect();
    let mut longer = known.iter().filter(|known| known.starts_with(given));
    if let (Some(known), None) = (longer.next(), longer.next())
        && given.len() >= MIN_BEGINNING
    {
        return Some(known);
    }
    let rated = |known: &'a str| (known, normalized_damerau_levenshtein(given, known));
    let (known, similarity) =
        known.into_iter().map(rated).max_by(|one, other| one.1.total_cmp(&other.1))?;
    (similarity >= MIN_SIMILARITY).then_some(known)
}

/// A count with its noun, such as "1 core" and "2 cores". The plural of the noun ends with an s.
///
/// ```
/// use inbye::suggest::counted;
/// assert_eq!([counted(1, "run"), counted(0, "run")], ["1 run", "0 runs"]);
/// ```
#[must_use]
pub fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// Rust type names in messages of serde, and their replacements.
#[cfg(feature = "sim")]
const TYPES: [(&str, &str); 10] = [
    // A number beyond 64 bits.
    (" as i128", ""),
    (" as u128", ""),
    ("expected an array of length 3", "expected a list of 3 numbers"),
    ("expected u8", "expected a whole number, 0 to 255"),
    ("expected u32", "expected a whole number, at least 0"),
    ("expected u64", "expected a whole number, at least 0"),
    ("expected usize", "expected a whole number, at least 0"),
    ("expected f64", "expected a number"),
    ("expected a sequence", "expected a list"),
    ("expected a boolean", "expected true or false"),
];

/// The name in older versions of Nav2 of the number of returns from which a zone acts, and its meaning there: it acts above its number.
#[cfg(feature = "sim")]
pub(crate) const MAX_POINTS: (&str, &str) =
    ("max_points", "`max_points = N` of older versions of Nav2 is `min_points = N + 1`");

/// A message of serde without the names of Rust types.
#[cfg(feature = "sim")]
pub(crate) fn without_rust_types(message: &str) -> String {
    let plain =
        TYPES.iter().fold(message.to_owned(), |text, (rust, plain)| text.replace(rust, plain));
    match plain.split_once("expected struct ") {
        Some((before, _name)) => format!("{before}expected a table of keys and values"),
        None => plain,
    }
}

/// A text with a space in place of line breaks and other white space.
pub(crate) fn in_one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
