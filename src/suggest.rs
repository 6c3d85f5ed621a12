//! Which word somebody meant who mistyped it.

use strsim::normalized_damerau_levenshtein;

/// Less alike than this, two words are not the same one mistyped: 1 is the same word, 0 one that shares nothing with it.
const ALIKE: f64 = 0.75;

/// The word that is most like the one given, if any is like it at all.
///
/// ```
/// use inbye::suggest::closest_name;
/// let known = ["max_vel_x", "min_vel_x"];
/// assert_eq!(closest_name("mxa_vel_x", known), Some("max_vel_x"));
/// assert_eq!(closest_name("colour", known), None);
/// ```
pub fn closest_name<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let likeness = |known: &'a str| (known, normalized_damerau_levenshtein(given, known));
    let (known, alike) = known
        .into_iter()
        .map(likeness)
        .max_by(|one, other| one.1.total_cmp(&other.1))?;
    (alike >= ALIKE).then_some(known)
}
