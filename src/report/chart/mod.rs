//! Charts as data: series, axes, bands, reference lines and a legend. [`draw`] turns a description into SVG.

mod axis;
mod draw;

use maud::{Markup, PreEscaped, html};

pub(crate) use axis::{Axis, Tick, round_number_below};
use draw::{CHART_WIDTH, Drawn, draw};
pub(crate) use draw::{marker, series_class, spread};

use super::figure::{Table, figure};
use super::number::coordinate;
use super::svg::{LegendEntry, drawn_legend, legend_height, legend_list, themed_style};

/// Style of a standalone picture: that of a page, a background, and the size of its text.
const STANDALONE_STYLE: [&str; 3] = [
    include_str!("../drawing.css"),
    include_str!("../chart.css"),
    "svg { font-family: system-ui, \"DejaVu Sans\", sans-serif; } text { font-size: 11.5px; } \
    .background { fill: var(--panel); } .headline { font-size: 14px; font-weight: 600; }",
];

/// Margin around and between the charts of a standalone picture.
const MARGIN: f64 = 16.0;
/// Height of the headline above a chart.
const HEADLINE: f64 = 30.0;
/// Most charts next to each other.
const MAX_COLUMNS: usize = 4;
/// Letters of a legend entry that fit into half the width of a chart.
const SHORT_ENTRY: usize = 27;

/// A chart, with its caption and the table of its data on a page.
pub(crate) struct Chart {
    pub(crate) title: &'static str,
    pub(crate) plot: Plot,
    pub(crate) legend: Vec<LegendEntry>,
    /// A sentence in place of the picture for screen readers.
    pub(crate) alt_text: String,
    pub(crate) caption: String,
    /// None if the page shows the data elsewhere.
    pub(crate) table: Option<Table>,
}

/// What a chart shows.
pub(crate) enum Plot {
    /// Panels one below the other over one horizontal axis.
    Panels { x: XAxis, panels: Vec<Panel> },
    /// Labelled rows of horizontal bars.
    Rows { axis: Axis, axis_title: &'static str, rows: Vec<Row> },
    /// A sentence that says why there is no data.
    Empty(&'static str),
}

/// The horizontal axis of all panels.
pub(crate) struct XAxis {
    pub(crate) axis: Axis,
    pub(crate) title: &'static str,
    /// Ticks in place of those of the axis.
    pub(crate) ticks: Option<Vec<Tick>>,
}

/// A plotting area with its own vertical axis.
pub(crate) struct Panel {
    pub(crate) title: String,
    /// Drawing units.
    pub(crate) height: f64,
    pub(crate) y: Axis,
    pub(crate) marks: Vec<Mark>,
}

/// Something drawn in a panel. Positions are values of the axes; classes are those of `chart.css` and `style.css`.
pub(crate) enum Mark {
    /// Vertical bands behind the grid: from and to, on the horizontal axis.
    Bands(&'static str, Vec<[f64; 2]>),
    /// The area below a value, behind the grid.
    AreaBelow(&'static str, f64),
    /// A line. It breaks at points that are not finite.
    Line(&'static str, Vec<[f64; 2]>),
    /// Many small dots.
    Dots(&'static str, Vec<[f64; 2]>),
    /// Circles of a radius in drawing units.
    Circles(&'static str, f64, Vec<[f64; 2]>),
    /// A series of medians with markers.
    Curve(Curve),
    /// Vertical bars.
    Bars(String, Vec<Bar>),
    /// Vertical ranges with their middle values: position, and least, middle and greatest value.
    Ranges(Vec<(f64, [f64; 3])>),
    /// A horizontal reference line.
    Level(f64, Option<(LabelSide, String)>),
    /// A vertical reference line. Its label stands above the panel.
    Position(f64, Option<String>),
    /// Marks that share a tooltip.
    Group(String, Vec<Mark>),
}

/// Where the label of a horizontal reference line stands.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum LabelSide {
    /// On the line, at the right end.
    Right,
    /// Right of the panel.
    Outside,
}

/// A bar: its left and right end, and its lower and upper end.
pub(crate) struct Bar {
    pub(crate) x: [f64; 2],
    pub(crate) y: [f64; 2],
}

/// A curve of medians, and how far the values reach above them.
pub(crate) struct Curve {
    /// Index of its series, which decides colour and marker.
    pub(crate) index: usize,
    /// Position, median, and upper value.
    pub(crate) points: Vec<[f64; 3]>,
    pub(crate) upper: Upper,
}

/// How the upper values of a curve are drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Upper {
    /// As a shaded band up to them.
    Band,
    /// As a dashed line, where bands would cover one another.
    Line,
    /// Not at all.
    None,
}

/// A row of a chart: label and value above its bars.
pub(crate) struct Row {
    /// Rows of different groups have more space between them.
    pub(crate) group: usize,
    pub(crate) label: String,
    pub(crate) value: String,
    pub(crate) mark: RowMark,
}

/// The bars of a row.
pub(crate) enum RowMark {
    /// One bar in parts: class and length of each.
    Stack(Vec<(&'static str, f64)>),
    /// Two bars of half the height: class and length of each.
    Pair([(&'static str, f64); 2]),
    /// A distribution: least, 10th percentile, median, 90th percentile, greatest.
    Spread([f64; 5]),
    /// No data.
    None,
}

/// The least and greatest finite value; none without any.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values
        .filter(|value| value.is_finite())
        .map(|value| (value, value))
        .reduce(|(low, high), (value, _)| (low.min(value), high.max(value)))
}

impl Chart {
    /// A chart without a legend, a caption and a table.
    const fn new(title: &'static str, plot: Plot, alt_text: String) -> Self {
        Self { title, plot, legend: Vec::new(), alt_text, caption: String::new(), table: None }
    }

    /// A chart of panels.
    pub(crate) const fn of_panels(
        title: &'static str,
        x: XAxis,
        panels: Vec<Panel>,
        alt_text: String,
    ) -> Self {
        Self::new(title, Plot::Panels { x, panels }, alt_text)
    }

    /// A chart of rows. Its text alternative lists their labels and values.
    pub(crate) fn of_rows(
        title: &'static str,
        (axis, axis_title): (Axis, &'static str),
        rows: Vec<Row>,
        legend: Vec<LegendEntry>,
    ) -> Self {
        let texts: Vec<String> =
            rows.iter().map(|row| format!("{} {}", row.label, row.value)).collect();
        let alt_text = format!("{title}: {}.", texts.join("; "));
        Self { legend, ..Self::new(title, Plot::Rows { axis, axis_title, rows }, alt_text) }
    }

    /// A chart without data, and the sentence that says so.
    pub(crate) const fn empty(title: &'static str, reason: &'static str) -> Self {
        Self::new(title, Plot::Empty(reason), String::new())
    }

    /// Whether the chart shows data.
    pub(crate) const fn has_data(&self) -> bool {
        !matches!(self.plot, Plot::Empty(_))
    }

    /// The figure of a page; a sentence in place of the picture if the chart has no data.
    pub(crate) fn figure(&self) -> Markup {
        if let Plot::Empty(reason) = self.plot {
            return html! { figure { h3 { (self.title) } p class="nothing" { (reason) } } };
        }
        let drawn = draw(&self.plot);
        let picture = html! {
            svg class="chart" xmlns="http://www.w3.org/2000/svg" role="img" aria-label=(self.alt_text)
                viewBox=(format!("0 0 {CHART_WIDTH} {}", drawn.height)) {
                (drawn.content)
            }
        };
        if let Some(table) = &self.table {
            figure(self.title, &picture, &self.legend, &self.caption, table)
        } else {
            html! { figure { h3 { (self.title) } (picture) (legend_list(&self.legend)) } }
        }
    }

    /// Columns of the legend in a standalone picture: two if all entries are short.
    fn legend_columns(&self) -> usize {
        let is_short = |entry: &LegendEntry| entry.text.chars().count() <= SHORT_ENTRY;
        if self.legend.iter().all(is_short) { 2 } else { 1 }
    }
}

impl XAxis {
    /// An axis with its own ticks.
    pub(crate) const fn new(axis: Axis, title: &'static str) -> Self {
        Self { axis, title, ticks: None }
    }
}

impl Panel {
    /// A panel of a height in drawing units.
    pub(crate) fn new(
        title: impl Into<String>,
        height: f64,
        y: Axis,
        marks: impl IntoIterator<Item = Mark>,
    ) -> Self {
        Self { title: title.into(), height, y, marks: marks.into_iter().collect() }
    }
}

/// Returns an SVG file with all charts that have data, each with its title and legend. Without any, it shows a sentence.
pub(crate) fn standalone_svg<'a>(
    charts: impl IntoIterator<Item = &'a Chart>,
    nothing: &str,
) -> String {
    let charts = charts.into_iter().filter(|chart| chart.has_data());
    let drawn: Vec<(&Chart, Drawn)> = charts.map(|chart| (chart, draw(&chart.plot))).collect();
    let alt_texts: Vec<&str> = drawn.iter().map(|(chart, _)| chart.alt_text.as_str()).collect();
    let alt_text = if drawn.is_empty() { nothing.to_owned() } else { alt_texts.join(" ") };
    let pitch = CHART_WIDTH + MARGIN;
    let width = drawn.len().clamp(1, MAX_COLUMNS) as f64 * pitch + MARGIN;
    let total = |(chart, drawn): &(&Chart, Drawn)| {
        let legend = legend_height(chart.legend.len(), chart.legend_columns());
        HEADLINE + drawn.height + 12.0 + legend + MARGIN
    };
    let mut height = MARGIN;
    let content = html! {
        @for line in drawn.chunks(MAX_COLUMNS) {
            @for (column, (chart, drawn)) in line.iter().enumerate() {
                @let x = MARGIN + column as f64 * pitch;
                g transform=(format!("translate({} {})", coordinate(x), coordinate(height))) {
                    text class="headline" x="0" y="14" { (chart.title) }
                    g transform=(format!("translate(0 {})", coordinate(HEADLINE))) {
                        (drawn.content)
                        (drawn_legend(&chart.legend, [0.0, drawn.height + 6.0], CHART_WIDTH, chart.legend_columns()))
                    }
                }
            }
            @let () = height += line.iter().map(total).fold(0.0, f64::max);
        }
        @if drawn.is_empty() {
            text x=(coordinate(MARGIN)) y=(coordinate(MARGIN + HEADLINE)) { (nothing) }
            @let () = height += 2.0 * HEADLINE;
        }
    };
    let (width, height) = (coordinate(width), coordinate(height));
    html! {
        svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label=(alt_text)
            width=(width) height=(height) viewBox=(format!("0 0 {width} {height}")) {
            style { (PreEscaped(themed_style(&STANDALONE_STYLE))) }
            rect class="background" width="100%" height="100%" {}
            (content)
        }
    }
    .into_string()
}
