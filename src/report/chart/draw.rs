//! Draws the description of a chart as SVG.

#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use maud::{Markup, html};

use super::axis::{Axis, Tick};
use super::{Bar, Curve, LabelSide, Mark, Panel, Plot, Row, RowMark, Upper, XAxis};
use crate::report::number::coordinate;
use crate::report::svg::{TOLERANCE, points_attribute, polyline};

/// Width of every chart, drawing units. It is small, so text stays readable on a phone.
pub(crate) const CHART_WIDTH: f64 = 440.0;

/// Margins left and right of a panel, and right of it for labels outside, drawing units.
const LEFT: f64 = 46.0;
const RIGHT: f64 = 14.0;
const RIGHT_WITH_LABELS: f64 = 58.0;
/// Space above a panel with its title, and below the last one with the horizontal axis.
const HEAD: f64 = 32.0;
const PANEL_GAP: f64 = 10.0;
const FOOT: f64 = 42.0;
/// Height of a label line, and estimated width of a letter on a small screen.
const LINE: f64 = 17.0;
const LETTER: f64 = 8.0;
/// Distance of a label from its vertical line.
const LABEL_SHIFT: f64 = 5.0;
/// Least distance between labels outside a panel.
const LABEL_PITCH: f64 = 13.0;
/// Rows: first row, height of a row, of its bars, space between groups, side margin.
const ROW_TOP: f64 = 4.0;
const ROW_PITCH: f64 = 33.0;
/// Width of a letter in a row.
const ROW_LETTER: f64 = 6.5;
const BAR_HEIGHT: f64 = 11.0;
const GROUP_GAP: f64 = 10.0;
const ROW_SIDE: f64 = 14.0;

/// Colours for series; further series reuse them with other markers.
const COLOURS: usize = 6;

/// A drawn chart.
pub(crate) struct Drawn {
    pub(crate) content: Markup,
    /// Drawing units.
    pub(crate) height: f64,
}

/// The area of a panel in the drawing.
struct Area<'a> {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    /// Height of the labels of vertical lines, between the title and the panel.
    labels_height: f64,
    x: &'a Axis,
    y: &'a Axis,
}

/// A label of a vertical line.
struct PlacedLabel<'p> {
    /// The position of the line in the drawing.
    x: f64,
    text: &'p str,
    /// Whether it stands left of its line.
    is_left: bool,
}

/// Draws a chart without its title and legend.
pub(crate) fn draw(plot: &Plot) -> Drawn {
    match plot {
        Plot::Panels { x, panels } => draw_panels(x, panels),
        Plot::Rows { axis, axis_title, rows } => draw_rows(axis, axis_title, rows),
        Plot::Empty(reason) => {
            Drawn { content: html! { text x="0" y="20" { (reason) } }, height: HEAD }
        }
    }
}

fn draw_panels(x: &XAxis, panels: &[Panel]) -> Drawn {
    let has_outside_labels = panels
        .iter()
        .flat_map(|panel| &panel.marks)
        .any(|mark| matches!(mark, Mark::Level(_, Some((side, _))) if *side == LabelSide::Outside));
    let right = if has_outside_labels { RIGHT_WITH_LABELS } else { RIGHT };
    let own_ticks = x.axis.ticks();
    let ticks = x.ticks.as_deref().unwrap_or(&own_ticks);
    let last = panels.len().saturating_sub(1);
    let mut top = 0.0;
    let content = html! {
        @for (index, panel) in panels.iter().enumerate() {
            @let labels_height = LINE * position_labels(panel).count() as f64;
            @let area = Area {
                left: LEFT,
                top: top + HEAD + labels_height,
                width: CHART_WIDTH - LEFT - right,
                height: panel.height,
                labels_height,
                x: &x.axis,
                y: &panel.y,
            };
            @for mark in &panel.marks { (area.background(mark)) }
            (area.axes(ticks, &panel.y.ticks(), (index == last).then_some(x.title), &panel.title))
            @for mark in &panel.marks { (area.mark(mark)) }
            (area.outside_labels(panel))
            @for (line, label) in area.placed_labels(panel).iter().enumerate() {
                (area.position_label(label, line))
            }
            @let () = top = area.bottom() + PANEL_GAP;
        }
    };
    Drawn { content, height: top - PANEL_GAP + FOOT }
}

/// The labels above a panel.
fn position_labels(panel: &Panel) -> impl Iterator<Item = (f64, &str)> {
    panel.marks.iter().filter_map(|mark| match mark {
        Mark::Position(value, Some(label)) => Some((*value, label.as_str())),
        _ => None,
    })
}

impl Area<'_> {
    fn bottom(&self) -> f64 {
        self.top + self.height
    }

    fn right(&self) -> f64 {
        self.left + self.width
    }

    fn x_at(&self, value: f64) -> f64 {
        self.left + self.x.fraction(value) * self.width
    }

    /// The vertical position of a value. The y axis of the drawing points down.
    fn y_at(&self, value: f64) -> f64 {
        self.bottom() - self.y.fraction(value) * self.height
    }

    /// The frame, the grid with its labels, and the titles. Only the lowest panel has a horizontal title and labels.
    fn axes(
        &self,
        x_ticks: &[Tick],
        y_ticks: &[Tick],
        x_title: Option<&str>,
        y_title: &str,
    ) -> Markup {
        let (left, right) = (coordinate(self.left), coordinate(self.right()));
        let (top, bottom) = (coordinate(self.top), coordinate(self.bottom()));
        let title_gap = if self.labels_height > 0.0 { 18.0 } else { 13.0 };
        html! {
            g class="axes" {
                @for tick in y_ticks {
                    @let y = coordinate(self.y_at(tick.value));
                    line x1=(left) x2=(right) y1=(y) y2=(y) {}
                    text class="end" x=(coordinate(self.left - 6.0)) y=(y) dy=".35em" { (tick.label) }
                }
                @for tick in self.spaced(x_ticks) {
                    @let x = coordinate(self.x_at(tick.value));
                    line x1=(x) x2=(x) y1=(top) y2=(bottom) {}
                    @if x_title.is_some() {
                        text class="middle" x=(x) y=(bottom) dy="1.25em" { (tick.label) }
                    }
                }
                rect x=(left) y=(top) width=(coordinate(self.width)) height=(coordinate(self.height)) {}
                @if !y_title.is_empty() {
                    text class="title" x="0" y=(coordinate(self.top - self.labels_height - title_gap)) { (y_title) }
                }
                @if let Some(title) = x_title {
                    text class="title end" x=(right) y=(bottom) dy="2.6em" { (title) }
                }
            }
        }
    }

    /// The ticks whose labels do not overlap, chosen from the last one on.
    fn spaced<'t>(&self, ticks: &'t [Tick]) -> Vec<&'t Tick> {
        let mut spaced: Vec<&Tick> = Vec::new();
        let mut limit = f64::INFINITY;
        for tick in ticks.iter().rev() {
            let half = tick.label.chars().count() as f64 * LETTER / 2.0;
            let x = self.x_at(tick.value);
            if x + half <= limit {
                limit = x - half - LETTER / 2.0;
                spaced.push(tick);
            }
        }
        spaced.reverse();
        spaced
    }

    /// A mark behind the grid.
    fn background(&self, mark: &Mark) -> Markup {
        match mark {
            Mark::Bands(class, bands) => html! {
                @for &[from, to] in bands {
                    @let (left, right) = (self.x_at(from), self.x_at(to).min(self.right()));
                    // A single tick of a long run stays visible.
                    (rectangle(class, [left, self.top], [(right - left).max(1.0), self.height]))
                }
            },
            Mark::AreaBelow(class, value) => {
                let top = self.y_at(*value);
                rectangle(class, [self.left, top], [self.width, self.bottom() - top])
            }
            _ => html! {},
        }
    }

    /// A mark in front of the grid.
    fn mark(&self, mark: &Mark) -> Markup {
        match mark {
            Mark::Bands(..) | Mark::AreaBelow(..) => html! {},
            Mark::Line(class, points) => self.line(class, points),
            Mark::Dots(class, points) => self.dots(class, points),
            Mark::Circles(class, radius, points) => html! {
                g class=(class) {
                    @for &[x, y] in points {
                        circle cx=(coordinate(self.x_at(x))) cy=(coordinate(self.y_at(y))) r=(radius) {}
                    }
                }
            },
            Mark::Curve(curve) => self.curve(curve),
            Mark::Bars(class, bars) => html! { @for bar in bars { (self.bar(class, bar)) } },
            Mark::Ranges(ranges) => self.ranges(ranges),
            Mark::Level(value, label) => self.level(*value, label.as_ref()),
            Mark::Position(value, label) => {
                let x = coordinate(self.x_at(*value));
                // The line of a labelled position is drawn up to its label.
                html! {
                    @if label.is_none() {
                        line class="limit" x1=(x) x2=(x) y1=(coordinate(self.top)) y2=(coordinate(self.bottom())) {}
                    }
                }
            }
            Mark::Group(tooltip, marks) => html! {
                g { title { (tooltip) } @for mark in marks { (self.mark(mark)) } }
            },
        }
    }

    fn line(&self, class: &str, points: &[[f64; 2]]) -> Markup {
        let is_gap = |[x, y]: &[f64; 2]| !(x.is_finite() && y.is_finite());
        html! {
            @for run in points.split(is_gap).filter(|run| !run.is_empty()) {
                @let run: Vec<_> = run.iter().map(|&[x, y]| [self.x_at(x), self.y_at(y)]).collect();
                (polyline(class, &run, TOLERANCE))
            }
        }
    }

    /// Dots nearer than half a drawing unit to another are drawn once.
    fn dots(&self, class: &str, points: &[[f64; 2]]) -> Markup {
        let half_units = |at: f64| libm::round(at * 2.0) as i64;
        let finite = points.iter().filter(|[x, y]| x.is_finite() && y.is_finite());
        let distinct: BTreeSet<(i64, i64)> =
            finite.map(|&[x, y]| (half_units(self.x_at(x)), half_units(self.y_at(y)))).collect();
        // A stroke of zero length with round ends is a dot.
        let dot = |(x, y): (i64, i64)| {
            format!("M{} {}h0", coordinate(x as f64 / 2.0), coordinate(y as f64 / 2.0))
        };
        let path: String = distinct.into_iter().map(dot).collect();
        html! { path class=(class) d=(path) {} }
    }

    fn curve(&self, Curve { index, points, upper }: &Curve) -> Markup {
        let medians: Vec<[f64; 2]> = points.iter().map(|&[x, median, _]| [x, median]).collect();
        let uppers: Vec<[f64; 2]> = points.iter().map(|&[x, _, upper]| [x, upper]).collect();
        let at = |&[x, y]: &[f64; 2]| [self.x_at(x), self.y_at(y)];
        html! {
            g class=(series_class(*index)) {
                @match upper {
                    Upper::Band => {
                        @let band: Vec<_> = medians.iter().chain(uppers.iter().rev()).map(at).collect();
                        polygon class="band" points=(points_attribute(&band)) {}
                    }
                    Upper::Line => { (self.line("upper", &uppers)) }
                    Upper::None => {}
                }
                (self.line("median", &medians))
                @for [x, y] in medians.iter().map(at) { (marker(*index, x, y)) }
            }
        }
    }

    fn bar(&self, class: &str, bar: &Bar) -> Markup {
        let [left, right] = bar.x.map(|x| self.x_at(x));
        let [bottom, top] = bar.y.map(|y| self.y_at(y));
        // Narrow bars stay visible in a chart with many bars.
        let width = (right - left).max(2.0);
        rectangle(class, [f64::midpoint(left, right) - width / 2.0, top], [width, bottom - top])
    }

    fn ranges(&self, ranges: &[(f64, [f64; 3])]) -> Markup {
        // The width follows from one unit of the horizontal axis.
        let unit = self.x_at(1.0) - self.x_at(0.0);
        let width = (0.45 * unit).clamp(1.0, 5.0);
        html! {
            @for (x, [low, middle, high]) in ranges {
                @let x = coordinate(self.x_at(*x));
                line class="series-0 spread" stroke-width=(coordinate(width)) x1=(x) x2=(x)
                    y1=(coordinate(self.y_at(*low))) y2=(coordinate(self.y_at(*high))) {}
                circle class="series-0 middle-mark" cx=(x) cy=(coordinate(self.y_at(*middle)))
                    r=(coordinate((width * 0.8).max(1.4))) {}
            }
        }
    }

    fn level(&self, value: f64, label: Option<&(LabelSide, String)>) -> Markup {
        let y = coordinate(self.y_at(value));
        html! {
            line class="limit" x1=(coordinate(self.left)) x2=(coordinate(self.right())) y1=(y) y2=(y) {}
            @match label {
                Some((LabelSide::Right, text)) => {
                    text class="end halo" x=(coordinate(self.right() - 4.0)) y=(y) dy="-.4em" { (text) }
                }
                Some((LabelSide::Outside, _)) | None => {}
            }
        }
    }

    /// The labels right of the panel, moved apart if their lines are close to each other.
    fn outside_labels(&self, panel: &Panel) -> Markup {
        let labels = panel.marks.iter().filter_map(|mark| match mark {
            Mark::Level(value, Some((LabelSide::Outside, text))) => Some((self.y_at(*value), text)),
            _ => None,
        });
        let mut labels: Vec<(f64, &String)> = labels.collect();
        labels.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut least_y = f64::NEG_INFINITY;
        html! {
            @for (y, text) in labels {
                @let y = y.max(least_y);
                @let () = least_y = y + LABEL_PITCH;
                text x=(coordinate(self.right() + 5.0)) y=(coordinate(y)) dy=".35em" { (text) }
            }
        }
    }

    /// The labels of vertical lines in the order of their lines of text, from the top. A label stands right of its line
    /// unless it would reach the next one. Those at the left come first, from the rightmost on; then the others, from the
    /// leftmost on. So no line crosses the label of another.
    fn placed_labels<'p>(&self, panel: &'p Panel) -> Vec<PlacedLabel<'p>> {
        let mut lines: Vec<(f64, &str)> =
            position_labels(panel).map(|(value, text)| (self.x_at(value), text)).collect();
        lines.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut limit = self.right();
        let labels = lines.into_iter().map(|(x, text)| {
            let width = text.chars().count() as f64 * LETTER + LABEL_SHIFT;
            let is_left = x + width > limit && x - width >= 0.0;
            limit = x;
            PlacedLabel { x, text, is_left }
        });
        let (mut labels, right): (Vec<_>, Vec<_>) = labels.partition(|label| label.is_left);
        labels.extend(right.into_iter().rev());
        labels
    }

    /// A vertical reference line up to its label. Each label has its own line of text.
    fn position_label(&self, label: &PlacedLabel<'_>, line: usize) -> Markup {
        let y = self.top - self.labels_height + LINE * line as f64;
        let PlacedLabel { x, text, is_left } = *label;
        let (class, shift) =
            if is_left { ("end halo", -LABEL_SHIFT) } else { ("halo", LABEL_SHIFT) };
        html! {
            line class="percentile" x1=(coordinate(x)) x2=(coordinate(x))
                y1=(coordinate(y - 9.0)) y2=(coordinate(self.bottom())) {}
            text class=(class) x=(coordinate(x + shift)) y=(coordinate(y)) { (text) }
        }
    }
}

fn rectangle(class: &str, [x, y]: [f64; 2], [width, height]: [f64; 2]) -> Markup {
    html! {
        rect class=(class) x=(coordinate(x)) y=(coordinate(y)) width=(coordinate(width)) height=(coordinate(height)) {}
    }
}

/// The marker of a series at a position of the drawing.
pub(crate) fn marker(index: usize, x: f64, y: f64) -> Markup {
    const SHAPES: [&str; 5] = [
        "m-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z",
        "m-3.5 -3.5h7v7h-7z",
        "m0 -4.8l4.4 8h-8.8z",
        "m0 -5l5 5l-5 5l-5 -5z",
        "m0 4.8l4.4 -8h-8.8z",
    ];
    let shape = SHAPES[index % SHAPES.len()];
    html! { path class="marker" d=(format!("M{} {}{shape}", coordinate(x), coordinate(y))) {} }
}

/// The class with the colour of a series.
pub(crate) fn series_class(index: usize) -> String {
    format!("series-{}", index % COLOURS)
}

fn draw_rows(axis: &Axis, axis_title: &str, rows: &[Row]) -> Drawn {
    let first_group = rows.first().map_or(0, |row| row.group);
    let width = CHART_WIDTH - 2.0 * ROW_SIDE;
    // The space for the value of a row below its label, where they do not fit side by side.
    let value_height = |row: &Row| {
        let letters = row.label.chars().count() + row.value.chars().count() + 1;
        if letters as f64 * ROW_LETTER + 8.0 > width { LINE } else { 0.0 }
    };
    let mut bottom = ROW_TOP;
    let mut group = first_group;
    let mut tops = Vec::with_capacity(rows.len());
    for row in rows {
        bottom += GROUP_GAP * (row.group - group) as f64;
        group = row.group;
        tops.push(bottom);
        bottom += ROW_PITCH + value_height(row);
    }
    let area = Area {
        left: ROW_SIDE,
        top: ROW_TOP,
        width,
        height: bottom.max(ROW_TOP + ROW_PITCH) - ROW_TOP,
        labels_height: 0.0,
        x: axis,
        // Rows have no vertical axis.
        y: axis,
    };
    let content = html! {
        (area.axes(&axis.ticks(), &[], Some(axis_title), ""))
        @for (row, &top) in rows.iter().zip(&tops) {
            @let middle = coordinate(top + 9.0);
            @let value_height = value_height(row);
            g {
                title { (row.label) ": " (row.value) }
                text class="halo" x=(coordinate(area.left + 4.0)) y=(middle) dy=".35em" { (row.label) }
                text class="halo end" x=(coordinate(area.right() - 4.0)) y=(coordinate(top + 9.0 + value_height)) dy=".35em" { (row.value) }
                (area.row_mark(top + 17.5 + value_height, &row.mark))
            }
        }
    };
    Drawn { content, height: area.bottom() + FOOT }
}

/// Rows of horizontal bars.
impl Area<'_> {
    fn row_mark(&self, top: f64, mark: &RowMark) -> Markup {
        match mark {
            RowMark::Stack(parts) => {
                let mut end = 0.0;
                html! {
                    @for &(class, length) in parts {
                        (self.row_bar(class, [end, end + length], top, BAR_HEIGHT))
                        @let () = end += length;
                    }
                }
            }
            RowMark::Pair(bars) => {
                let half = BAR_HEIGHT / 2.0;
                html! {
                    @for (&(class, length), top) in bars.iter().zip([top, top + half]) {
                        (self.row_bar(class, [0.0, length], top, half))
                    }
                }
            }
            RowMark::Spread(values) => {
                spread(values.map(|value| self.x_at(value)), top + BAR_HEIGHT / 2.0)
            }
            RowMark::None => html! {},
        }
    }

    fn row_bar(&self, class: &str, values: [f64; 2], top: f64, height: f64) -> Markup {
        let [left, right] = values.map(|value| self.x_at(value));
        html! {
            @if right > left { (rectangle(class, [left, top], [right - left, height])) }
        }
    }
}

/// A thin line over all values, a thick one between the outer percentiles, and a dot at the median.
pub(crate) fn spread(x: [f64; 5], y: f64) -> Markup {
    let [least, low, median, high, most] = x.map(coordinate);
    let y = coordinate(y);
    html! {
        g class="series-0" {
            line class="spread" stroke-width="2" x1=(least) x2=(most) y1=(y) y2=(y) {}
            line class="spread" stroke-width="7" x1=(low) x2=(high) y1=(y) y2=(y) {}
            circle class="middle-mark" cx=(median) cy=(y) r="4.5" {}
        }
    }
}
