//! Numbers as text: rounded for people, short coordinates for drawings.

/// The text of a number that is not finite or was not measured.
pub(super) const NONE: &str = "–";

/// A number with a fixed count of decimals, without negative zero; a dash if it is not finite.
pub(super) fn fixed(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|byte| matches!(byte, b'0' | b'.')) => digits.to_owned(),
        _ => text,
    }
}

/// A number with three significant digits, or all digits of a longer whole part; a dash if it is not finite.
pub(super) fn significant(value: f64) -> String {
    if !value.is_finite() || value == 0.0 {
        return fixed(value, 0);
    }
    let exponent = libm::floor(libm::log10(value.abs())) as i32;
    fixed(value, (2 - exponent).clamp(0, 9) as usize)
}

/// An optional number with a fixed count of decimals.
pub(super) fn optional(value: Option<f64>, decimals: usize) -> String {
    fixed(value.unwrap_or(f64::NAN), decimals)
}

/// A number with three significant digits and a suffix for thousands: 1.5k, 20M.
pub(super) fn shortened(value: f64) -> String {
    let (scale, suffix) = match value.abs() {
        1e9.. => (1e9, "G"),
        1e6.. => (1e6, "M"),
        1e3.. => (1e3, "k"),
        _ => (1.0, ""),
    };
    let digits = significant(value / scale);
    let short = if digits.contains('.') {
        digits.trim_end_matches('0').trim_end_matches('.')
    } else {
        &digits
    };
    format!("{short}{suffix}")
}

/// A coordinate or length of a drawing, to a tenth of a unit, which is less than a pixel.
pub(super) fn coordinate(value: f64) -> String {
    let text = fixed(value, 1);
    text.strip_suffix(".0").map_or_else(|| text.clone(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_keeps_three_digits() {
        for (value, text) in [
            (0.0, "0"),
            (0.012_345, "0.0123"),
            (1.0, "1.00"),
            (99.96, "100.0"),
            (-12.34, "-12.3"),
            (123_456.0, "123456"),
            (f64::NAN, "–"),
            (f64::NEG_INFINITY, "–"),
        ] {
            assert_eq!(significant(value), text);
        }
    }

    #[test]
    fn rounded_numbers_have_no_negative_zero() {
        assert_eq!(fixed(-0.004, 2), "0.00");
        assert_eq!(coordinate(-0.04), "0");
        assert_eq!(coordinate(-12.06), "-12.1");
    }

    #[test]
    fn shortened_has_a_suffix_for_thousands() {
        assert_eq!(shortened(20.0), "20");
        assert_eq!(shortened(1500.0), "1.5k");
        assert_eq!(shortened(2.0e7), "20M");
    }
}
