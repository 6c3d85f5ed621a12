//! Plots as one picture of their own, to be looked at without a page.

use std::collections::BTreeSet;

use maud::{PreEscaped, html};

use super::curves::Plot;
use super::number::coordinate;
use super::panel::CHART_WIDTH;

const STYLE: &str = concat!(
    include_str!("colours.css"),
    include_str!("drawing.css"),
    include_str!("chart.css")
);

/// What only a picture of its own needs: a ground to stand on, and the size of its text.
const OWN_STYLE: &str = "svg { font-family: system-ui, \"DejaVu Sans\", sans-serif; } text { font-size: 11.5px; } \
    .ground { fill: var(--panel); } .headline { font-size: 14px; font-weight: 600; }";

/// Around the plots, and between them.
const MARGIN: f64 = 16.0;
/// Height of the headline above a plot.
const HEADLINE: f64 = 30.0;

/// An SVG file: the plots beside one another, each with its headline and its legend. It holds everything it needs. Without
/// any plot it says this sentence.
pub(super) fn own_picture(plots: &[Plot], nothing: &str) -> String {
    let columns = plots.len().max(1) as f64;
    let width = columns * CHART_WIDTH + (columns + 1.0) * MARGIN;
    let tallest = plots
        .iter()
        .map(Plot::height_with_legend)
        .fold(HEADLINE, f64::max);
    let height = tallest + HEADLINE + 2.0 * MARGIN;
    let alternatives: Vec<&str> = plots.iter().map(|plot| plot.alternative.as_str()).collect();
    let styles: BTreeSet<&str> = plots.iter().map(|plot| plot.style).collect();
    let (width, height) = (coordinate(width), coordinate(height));
    html! {
        svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label=(alternatives.join(" "))
            width=(width) height=(height) viewBox=(format!("0 0 {width} {height}")) {
            style { (PreEscaped(STYLE)) (PreEscaped(OWN_STYLE)) @for style in &styles { (PreEscaped(style)) } }
            rect class="ground" width="100%" height="100%" {}
            @if plots.is_empty() {
                text x=(coordinate(MARGIN)) y=(coordinate(MARGIN + HEADLINE)) { (nothing) }
            }
            @for (column, plot) in plots.iter().enumerate() {
                @let x = MARGIN + column as f64 * (CHART_WIDTH + MARGIN);
                g transform=(format!("translate({} {})", coordinate(x), coordinate(MARGIN))) {
                    text class="headline" x="0" y="14" { (plot.title) }
                    g transform=(format!("translate(0 {})", coordinate(HEADLINE))) {
                        (plot.content)
                        (plot.drawn_legend())
                    }
                }
            }
        }
    }
    .into_string()
}
