//! Parts of drawings: polylines with fewer points, legends, and styles without CSS variables.

use maud::{Markup, html};

use super::number::coordinate;

const COLOURS: &str = include_str!("colours.css");

/// Largest distance of a drawn line from its data, drawing units: about a third of a pixel.
pub(super) const TOLERANCE: f64 = 0.3;

/// Height of a line of a drawn legend.
const LEGEND_LINE: f64 = 18.0;

/// A legend entry: a mark in a box of 28 by 14 units, and its meaning.
#[derive(Clone)]
pub(super) struct LegendEntry {
    pub(super) mark: Markup,
    pub(super) text: String,
}

impl LegendEntry {
    /// An entry with its own mark.
    pub(super) fn new(mark: Markup, text: impl Into<String>) -> Self {
        let text = text.into();
        Self { mark, text }
    }

    /// The entry of a line of a class.
    pub(super) fn line(class: &str, text: impl Into<String>) -> Self {
        let mark = html! { line class=(class) x1="1" x2="27" y1="7" y2="7" {} };
        Self::new(mark, text)
    }

    /// The entry of an area of a class.
    pub(super) fn area(class: &str, text: impl Into<String>) -> Self {
        let mark = html! { rect class=(class) x="2" y="2" width="24" height="10" {} };
        Self::new(mark, text)
    }

    /// The entry of a circle of a class and a radius.
    pub(super) fn circle(class: &str, radius: f64, text: impl Into<String>) -> Self {
        let mark = html! { circle class=(class) cx="14" cy="7" r=(radius) {} };
        Self::new(mark, text)
    }
}

/// A legend as a list of a page; nothing without entries.
pub(super) fn legend_list(entries: &[LegendEntry]) -> Markup {
    html! {
        @if !entries.is_empty() {
            ul class="legend" {
                @for entry in entries { li { (legend_entry(entry)) } }
            }
        }
    }
}

/// An entry of a legend on a page.
pub(super) fn legend_entry(entry: &LegendEntry) -> Markup {
    html! {
        svg class="key" viewBox="0 0 28 14" role="presentation" aria-hidden="true" { (entry.mark) }
        span { (entry.text) }
    }
}

/// A legend inside a drawing, downwards from a position, in columns of equal width.
pub(super) fn drawn_legend(
    entries: &[LegendEntry],
    [left, top]: [f64; 2],
    width: f64,
    columns: usize,
) -> Markup {
    html! {
        @for (index, entry) in entries.iter().enumerate() {
            @let x = left + width / columns as f64 * (index % columns) as f64;
            @let y = top + LEGEND_LINE * (index / columns) as f64;
            g transform=(format!("translate({} {})", coordinate(x), coordinate(y))) {
                (entry.mark)
                text x="36" y="7" dy=".35em" { (entry.text) }
            }
        }
    }
}

/// The height of a drawn legend.
pub(super) fn legend_height(entries: usize, columns: usize) -> f64 {
    LEGEND_LINE * entries.div_ceil(columns) as f64
}

/// The `points` attribute of a polyline or polygon.
pub(super) fn points_attribute(points: &[[f64; 2]]) -> String {
    let pairs: Vec<String> =
        points.iter().map(|&[x, y]| format!("{},{}", coordinate(x), coordinate(y))).collect();
    pairs.join(" ")
}

/// A line with fewer points, see [`simplify`].
pub(super) fn polyline(class: &str, points: &[[f64; 2]], tolerance: f64) -> Markup {
    html! { polyline class=(class) points=(points_attribute(&simplify(points, tolerance))) {} }
}

/// Returns styles with the values of the variables in `colours.css`, light theme. Many programs that draw SVG files know
/// neither CSS variables nor media queries.
pub(super) fn light_style(styles: &[&str]) -> String {
    let (light, _) = COLOURS.split_once("@media").unwrap_or((COLOURS, ""));
    with_values(&styles.concat(), light)
}

/// Returns [`light_style`], and the dark theme as a media query.
pub(super) fn themed_style(styles: &[&str]) -> String {
    let (_, dark) = COLOURS.split_once("@media").unwrap_or_default();
    format!(
        "{} @media (prefers-color-scheme: dark) {{ {} }}",
        light_style(styles),
        with_values(&styles.concat(), dark)
    )
}

/// Replaces each `var(--name)` that the colours declare by its value.
fn with_values(style: &str, colours: &str) -> String {
    let declarations =
        colours.split([';', '{']).filter_map(|declaration| declaration.split_once(':'));
    declarations.fold(style.to_owned(), |style, (name, value)| {
        style.replace(&format!("var({})", name.trim()), value.trim())
    })
}

/// Removes points from a line; no removed point is farther than the tolerance from the new line (Ramer 1972; Douglas and
/// Peucker 1973). Both ends stay.
pub(super) fn simplify(points: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let Some(last) = points.len().checked_sub(1) else {
        return Vec::new();
    };
    let mut keep = vec![false; points.len()];
    keep[0] = true;
    keep[last] = true;
    let mut spans = vec![(0, last)];
    while let Some((from, to)) = spans.pop() {
        let distance = |index| squared_distance(points[index], points[from], points[to]);
        let farthest =
            (from + 1..to).map(|index| (distance(index), index)).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((distance, index)) = farthest
            && distance > tolerance * tolerance
        {
            keep[index] = true;
            spans.push((from, index));
            spans.push((index, to));
        }
    }
    points.iter().zip(keep).filter_map(|(&point, kept)| kept.then_some(point)).collect()
}

/// The squared distance from a point to the segment between two others.
fn squared_distance(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let (along, across) = (to[0] - from[0], to[1] - from[1]);
    let (x, y) = (point[0] - from[0], point[1] - from[1]);
    let length = along * along + across * across;
    let share =
        if length > 0.0 { ((x * along + y * across) / length).clamp(0.0, 1.0) } else { 0.0 };
    let (dx, dy) = (x - share * along, y - share * across);
    dx * dx + dy * dy
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simplified_line_keeps_its_ends_and_the_tip_of_a_spike() {
        let mut line: Vec<[f64; 2]> = (0..100).map(|x| [f64::from(x), 0.0]).collect();
        assert_eq!(simplify(&line, 0.3), [[0.0, 0.0], [99.0, 0.0]]);
        line[50][1] = 5.0;
        let kept = simplify(&line, 0.3);
        assert!(kept.contains(&[50.0, 5.0]) && kept.len() == 5, "{kept:?}");
    }

    #[test]
    fn simplified_closed_loop_keeps_its_corners() {
        let square = [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0], [0.0, 0.0]];
        assert_eq!(simplify(&square, 0.3), square);
    }

    #[test]
    fn removed_points_are_within_the_tolerance() {
        let wave: Vec<[f64; 2]> = (0..500)
            .map(|index| {
                let x = f64::from(index) * 0.8;
                [x, 40.0 * libm::sin(x / 17.0)]
            })
            .collect();
        let kept = simplify(&wave, TOLERANCE);
        assert!(kept.len() < 120, "{} of 500 points kept", kept.len());
        for &point in &wave {
            let nearest = kept
                .windows(2)
                .map(|ends| squared_distance(point, ends[0], ends[1]))
                .fold(f64::INFINITY, f64::min);
            assert!(nearest <= TOLERANCE * TOLERANCE, "{point:?}");
        }
    }

    #[test]
    fn style_has_the_values_of_its_variables() {
        let colours = "--ink: #1a1e24; --panel: #ffffff;";
        let text = with_values("a { fill: var(--ink); stroke: var(--panel); }", colours);
        assert_eq!(text, "a { fill: #1a1e24; stroke: #ffffff; }");
        assert_eq!(with_values("var(--none)", colours), "var(--none)");
        let themed = themed_style(&["a { fill: var(--ink) }"]);
        assert!(themed.starts_with("a { fill: #1a1e24 } @media (prefers-color-scheme: dark) {"));
        assert!(themed.contains("a { fill: #e6e9ee }"), "{themed}");
    }
}
