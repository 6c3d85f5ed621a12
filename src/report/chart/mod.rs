//! Charts as data: series, axes, bands, reference lines and a legend. [`draw`] turns a description into SVG.

mod axis;
mod draw;
mod standalone_svg;

use maud::{Markup, html};

pub(crate) use axis::{Axis, Tick, round_number_below};
pub(crate) use standalone_svg::standalone_svg;

use super::svg::LegendEntry;

/// Colours for series; further series reuse them with other markers.
const COLOURS: usize = 6;

/// A chart.
pub(crate) struct Chart {
    pub(crate) title: String,
    pub(crate) plot: Plot,
    pub(crate) legend: Vec<LegendEntry>,
    /// A sentence in place of the picture for screen readers.
    pub(crate) alt_text: String,
}

/// What a chart shows.
pub(crate) enum Plot {
    /// Panels one below the other over one horizontal axis.
    Panels { x: XAxis, panels: Vec<Panel> },
    /// Labelled rows of horizontal bars.
    Rows { axis: Axis, axis_title: String, rows: Vec<Row> },
    /// A sentence that says why there is no data.
    Empty(&'static str),
}

/// The horizontal axis of all panels.
pub(crate) struct XAxis {
    pub(crate) axis: Axis,
    pub(crate) title: String,
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
    /// On the line, at the left end.
    Left,
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

/// Rows of one name, in ascending order of their position.
pub(crate) struct Series<'a, R> {
    pub(crate) name: String,
    pub(crate) rows: Vec<&'a R>,
}

/// Groups rows by name, in the order in which the names first occur, and sorts each group by position. Rows without a
/// name are left out.
pub(crate) fn series_by_name<R>(
    rows: &[R],
    name: impl Fn(&R) -> Option<String>,
    position: impl Fn(&R) -> u64,
) -> Vec<Series<'_, R>> {
    let mut all: Vec<Series<R>> = Vec::new();
    for row in rows {
        let Some(name) = name(row) else { continue };
        match all.iter_mut().find(|series| series.name == name) {
            Some(series) => series.rows.push(row),
            None => all.push(Series { name, rows: vec![row] }),
        }
    }
    for series in &mut all {
        series.rows.sort_by_key(|row| position(row));
    }
    all
}

/// A curve for each series.
pub(crate) fn curves<R>(
    all: &[Series<R>],
    upper: Upper,
    point: impl Fn(&R) -> Option<[f64; 3]>,
) -> Vec<Mark> {
    let curve = |(index, series): (usize, &Series<R>)| {
        let points = series.rows.iter().filter_map(|row| point(row)).collect();
        Mark::Curve(Curve { index, points, upper })
    };
    all.iter().enumerate().map(curve).collect()
}

/// A legend entry for each series.
pub(crate) fn series_legend<R>(all: &[Series<R>]) -> Vec<LegendEntry> {
    let entry = |(index, series): (usize, &Series<R>)| {
        let mark = html! {
            g class=(series_class(index)) {
                line class="median" x1="1" x2="27" y1="7" y2="7" {}
                (draw::marker(index, 14.0, 7.0))
            }
        };
        LegendEntry::new(mark, series.name.as_str())
    };
    all.iter().enumerate().map(entry).collect()
}

/// A text alternative that names the first and the last row of each series.
pub(crate) fn series_alt_text<R>(
    start: &str,
    all: &[Series<R>],
    text: impl Fn(&R) -> Option<String>,
) -> String {
    let ends = all.iter().filter_map(|series| {
        let (first, last) = (text(series.rows.first()?)?, text(series.rows.last()?)?);
        Some(format!(" {}: {first}, {last}.", series.name))
    });
    format!("{start}.{}", ends.collect::<String>())
}

/// The legend mark of a [`RowMark::Spread`].
pub(super) fn spread_mark() -> Markup {
    draw::spread([0.0, 6.0, 14.0, 22.0, 28.0], 7.0)
}

/// The class with the colour of a series.
pub(crate) fn series_class(index: usize) -> String {
    format!("series-{}", index % COLOURS)
}

/// The least and greatest finite value; none without any.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values
        .filter(|value| value.is_finite())
        .map(|value| (value, value))
        .reduce(|(low, high), (value, _)| (low.min(value), high.max(value)))
}

impl Chart {
    /// A chart without data, and the sentence that says so.
    pub(crate) fn empty(title: impl Into<String>, reason: &'static str) -> Self {
        Self {
            title: title.into(),
            plot: Plot::Empty(reason),
            legend: Vec::new(),
            alt_text: String::new(),
        }
    }

    /// A chart of rows. Its text alternative lists their labels and values.
    pub(crate) fn of_rows(
        title: &str,
        (axis, axis_title): (Axis, &str),
        rows: Vec<Row>,
        legend: Vec<LegendEntry>,
    ) -> Self {
        let texts: Vec<String> =
            rows.iter().map(|row| format!("{} {}", row.label, row.value)).collect();
        Self {
            title: title.to_owned(),
            alt_text: format!("{title}: {}.", texts.join("; ")),
            plot: Plot::Rows { axis, axis_title: axis_title.to_owned(), rows },
            legend,
        }
    }

    /// The chart as an SVG element of a page, without its legend.
    pub(crate) fn svg(&self) -> Markup {
        let drawn = draw::draw(&self.plot);
        html! {
            svg class="chart" xmlns="http://www.w3.org/2000/svg" role="img" aria-label=(self.alt_text)
                viewBox=(format!("0 0 {} {}", draw::CHART_WIDTH, drawn.height)) {
                (drawn.content)
            }
        }
    }
}

impl XAxis {
    /// An axis with its own ticks.
    pub(crate) fn new(axis: Axis, title: impl Into<String>) -> Self {
        Self { axis, title: title.into(), ticks: None }
    }
}
