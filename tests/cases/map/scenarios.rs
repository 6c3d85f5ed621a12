//! Rounding errors of the lengths in `.scen` files.

use inbye::map::parse_scen;

/// The rounding errors for a file with these lengths.
fn roundings(lengths: &[&str]) -> Vec<f64> {
    let lines: Vec<String> =
        lengths.iter().map(|length| format!("0 m.map 9 9 1 1 2 2 {length}")).collect();
    let scenarios = parse_scen(&lines.join("\n")).expect("lines of nine fields");
    scenarios.iter().map(|query| query.rounding).collect()
}

fn assert_near(found: &[f64], expected: &[f64]) {
    let near = |(found, expected): (&f64, &f64)| (found - expected).abs() <= 1e-9 * expected;
    assert!(found.len() == expected.len() && found.iter().zip(expected).all(near), "{found:?}");
}

#[test]
fn scen_rounding_is_half_a_unit_of_the_last_digit() {
    // The same number of decimals throughout: two in bg512, eight in the city maps.
    assert_near(&roundings(&["3.41", "449.00"]), &[5e-3, 5e-3]);
    assert_near(&roundings(&["2.00000000", "371.62950897"]), &[5e-9, 5e-9]);
    // Six significant digits without trailing zeros, as in most files.
    assert_near(
        &roundings(&["2.41421", "2", "0", "193.5", "2835.85"]),
        &[5e-6, 5e-6, 0.0, 5e-4, 5e-3],
    );
    // Whole numbers only: the default of six digits.
    assert_near(&roundings(&["2", "34"]), &[5e-6, 5e-5]);
    // The full precision of an f64.
    assert_near(&roundings(&["4.828427124746190", "2"]), &[5e-16, 5e-16]);
}
