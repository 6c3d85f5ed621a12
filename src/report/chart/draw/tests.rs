//! Labels and values of rows.

use super::*;

/// The heights of the text of a label and of its value.
fn heights(label: &str, value: &str) -> (String, String) {
    let row =
        Row { group: 0, label: label.to_owned(), value: value.to_owned(), mark: RowMark::None };
    let drawn = draw_rows(&Axis::exact(0.0, 1.0), "s", &[row]).content.into_string();
    let height = |class: &str| {
        let text = drawn.split(&format!("<text class=\"{class}\" x=")).nth(1).expect("a text");
        text.split("y=\"").nth(1).and_then(|text| text.split('"').next()).expect("y").to_owned()
    };
    (height("halo"), height("halo end"))
}

#[test]
fn value_of_a_long_label_stands_below_it() {
    let (label, value) = heights("recovery", "31.4 s, shared 30.0 s");
    assert_eq!(label, value);
    let (label, value) =
        heights("passive safety, lidar checked by the map, speed by what is seen", "31.4 s");
    assert_ne!(label, value);
}
