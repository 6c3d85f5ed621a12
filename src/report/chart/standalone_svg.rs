//! Charts as one SVG file that needs no page.

use maud::{PreEscaped, html};

use super::{Chart, Plot, draw};
use crate::report::number::coordinate;
use crate::report::svg::{drawn_legend, legend_height, themed_style};

const STYLE: &str = concat!(include_str!("../drawing.css"), include_str!("../chart.css"));

/// Style that only a standalone picture needs: a background and the size of its text.
const OWN_STYLE: &str = "svg { font-family: system-ui, \"DejaVu Sans\", sans-serif; } text { font-size: 11.5px; } \
    .background { fill: var(--panel); } .headline { font-size: 14px; font-weight: 600; }";

/// Margin around and between the charts.
const MARGIN: f64 = 16.0;
/// Height of the headline above a chart.
const HEADLINE: f64 = 30.0;
/// Most charts next to each other.
const MAX_COLUMNS: usize = 4;
/// Letters of a legend entry that fit into half the width of a chart.
const SHORT_ENTRY: usize = 27;

/// Returns an SVG file with all charts that have data, each with its title and legend. Without any, it shows a sentence.
pub(crate) fn standalone_svg<'a>(
    charts: impl IntoIterator<Item = &'a Chart>,
    nothing: &str,
) -> String {
    let charts: Vec<&Chart> =
        charts.into_iter().filter(|chart| !matches!(chart.plot, Plot::Empty(_))).collect();
    let drawn: Vec<_> = charts.iter().map(|chart| (*chart, draw::draw(&chart.plot))).collect();
    let columns = charts.len().clamp(1, MAX_COLUMNS) as f64;
    let width = columns * (draw::CHART_WIDTH + MARGIN) + MARGIN;
    let total = |(chart, drawn): &(&Chart, draw::Drawn)| {
        let legend = legend_height(chart.legend.len(), legend_columns(chart));
        HEADLINE + drawn.height + 12.0 + legend + MARGIN
    };
    let mut height = MARGIN;
    let lines: Vec<(f64, &[(&Chart, draw::Drawn)])> = drawn
        .chunks(MAX_COLUMNS)
        .map(|line| {
            let top = height;
            height += line.iter().map(total).fold(0.0, f64::max);
            (top, line)
        })
        .collect();
    if lines.is_empty() {
        height += 2.0 * HEADLINE;
    }
    let alt_texts: Vec<&str> = charts.iter().map(|chart| chart.alt_text.as_str()).collect();
    let alt_text = if charts.is_empty() { nothing.to_owned() } else { alt_texts.join(" ") };
    let (width, height) = (coordinate(width), coordinate(height));
    html! {
        svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label=(alt_text)
            width=(width) height=(height) viewBox=(format!("0 0 {width} {height}")) {
            style { (PreEscaped(themed_style(&[STYLE, OWN_STYLE]))) }
            rect class="background" width="100%" height="100%" {}
            @if charts.is_empty() {
                text x=(coordinate(MARGIN)) y=(coordinate(MARGIN + HEADLINE)) { (nothing) }
            }
            @for (top, line) in lines {
                @for (column, (chart, drawn)) in line.iter().enumerate() {
                    @let x = MARGIN + column as f64 * (draw::CHART_WIDTH + MARGIN);
                    g transform=(format!("translate({} {})", coordinate(x), coordinate(top))) {
                        text class="headline" x="0" y="14" { (chart.title) }
                        g transform=(format!("translate(0 {})", coordinate(HEADLINE))) {
                            (drawn.content)
                            (drawn_legend(&chart.legend, [0.0, drawn.height + 6.0], draw::CHART_WIDTH, legend_columns(chart)))
                        }
                    }
                }
            }
        }
    }
    .into_string()
}

/// Two columns if all entries are short.
fn legend_columns(chart: &Chart) -> usize {
    let is_short = |text: &String| text.chars().count() <= SHORT_ENTRY;
    if chart.legend.iter().all(|entry| is_short(&entry.text)) { 2 } else { 1 }
}
