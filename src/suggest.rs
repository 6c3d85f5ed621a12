//! Texts of messages: suggestions for misspelled names, and texts without line breaks.

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

/// A text with a space in place of line breaks and other white space.
pub(crate) fn in_one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
