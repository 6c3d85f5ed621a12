//! Requirements of tests that are otherwise ignored with the reason: the words of `INBYE_REQUIRE`.

/// Name of the variable.
pub const VARIABLE: &str = "INBYE_REQUIRE";

/// Its words, in lower case.
pub fn required() -> Vec<String> {
    let required = std::env::var(VARIABLE).unwrap_or_default().to_lowercase();
    let words = required.split(',').map(str::trim);
    words.filter(|word| !word.is_empty()).map(str::to_owned).collect()
}
