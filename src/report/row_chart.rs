//! Rows one below the other: over each its name and what came of it, below them their marks along one axis.

use maud::{Markup, html};

use super::axis::Axis;
use super::number::coordinate;
use super::panel::{CHART_WIDTH, Panel};

/// What the marks of such charts need beyond what every chart has.
pub(super) const STYLE: &str = include_str!("rows.css");

/// Where the first row begins, height of a row, of its mark, and the space between two parts, drawing units.
const TOP: f64 = 4.0;
const PITCH: f64 = 33.0;
const MARK: f64 = 11.0;
const APART: f64 = 10.0;
/// From the last row to the bottom: the axis's numbers and title.
const FOOT: f64 = 40.0;
/// Room for half a number of the axis.
const SIDE: f64 = 14.0;

/// A row.
pub(super) struct Row {
    /// Which part of the chart it is in: parts stand apart.
    pub(super) part: usize,
    pub(super) label: String,
    /// What came of it, at the right.
    pub(super) value: String,
}

/// The rows of a chart, and the axis of all.
pub(super) struct RowChart<'a> {
    /// Stands below the axis.
    pub(super) axis_title: &'a str,
    pub(super) axis: Axis,
    pub(super) rows: &'a [Row],
}

/// The place of a row's mark.
pub(super) struct Place<'a> {
    panel: &'a Panel,
    top: f64,
}

impl RowChart<'_> {
    pub(super) fn height(&self) -> f64 {
        self.panel().bottom() + FOOT
    }

    /// A sentence for those who do not see it.
    pub(super) fn said(&self, title: &str) -> String {
        let row = |row: &Row| format!("{} {}", row.label, row.value);
        let rows: Vec<String> = self.rows.iter().map(row).collect();
        format!("{title}: {}.", rows.join("; "))
    }

    /// Axis, labels, and the mark of each row by its index.
    pub(super) fn draw(&self, mark: impl Fn(&Place<'_>, usize) -> Markup) -> Markup {
        let panel = self.panel();
        html! {
            (self.axes(&panel))
            @for (index, row) in self.rows.iter().enumerate() {
                @let top = self.top(index);
                @let middle = coordinate(top + 9.0);
                g {
                    title { (row.label) ": " (row.value) }
                    text class="halo" x=(coordinate(panel.left + 4.0)) y=(middle) dy=".35em" { (row.label) }
                    text class="halo end" x=(coordinate(panel.right() - 4.0)) y=(middle) dy=".35em" { (row.value) }
                    (mark(&Place { panel: &panel, top: top + 17.5 }, index))
                }
            }
        }
    }

    fn top(&self, index: usize) -> f64 {
        let part = self.rows[index].part - self.rows[0].part;
        TOP + PITCH * index as f64 + APART * part as f64
    }

    fn panel(&self) -> Panel {
        let bottom = match self.rows.len() {
            0 => TOP + PITCH,
            rows => self.top(rows - 1) + PITCH,
        };
        Panel {
            left: SIDE,
            top: TOP,
            width: CHART_WIDTH - 2.0 * SIDE,
            height: bottom - TOP,
            x: self.axis,
            y: Axis::exact(0.0, 1.0),
        }
    }

    fn axes(&self, panel: &Panel) -> Markup {
        let (top, bottom) = (coordinate(panel.top), coordinate(panel.bottom()));
        html! {
            g class="axes" {
                @for tick in self.axis.ticks() {
                    @let x = coordinate(panel.x_at(tick.value));
                    line x1=(x) x2=(x) y1=(top) y2=(bottom) {}
                    text class="middle" x=(x) y=(bottom) dy="1.25em" { (tick.label) }
                }
                rect x=(coordinate(panel.left)) y=(top) width=(coordinate(panel.width)) height=(coordinate(panel.height)) {}
                text class="title end" x=(coordinate(panel.right())) y=(bottom) dy="2.6em" { (self.axis_title) }
            }
        }
    }
}

impl Place<'_> {
    /// Bars from zero on, one behind the other: class and length of each.
    pub(super) fn stack<'a>(&self, parts: impl Iterator<Item = (&'a str, f64)>) -> Markup {
        let ends = parts.scan(0.0, |end, (class, length)| {
            let from = *end;
            *end += length;
            Some((class, from, *end))
        });
        html! {
            @for (class, from, to) in ends { (self.bar(class, [from, to], 0.0, MARK)) }
        }
    }

    /// Two bars of half the height from zero on, one below the other: their classes and lengths.
    pub(super) fn halves(&self, classes: [&str; 2], lengths: [f64; 2]) -> Markup {
        let half = MARK / 2.0;
        html! {
            (self.bar(classes[0], [0.0, lengths[0]], 0.0, half))
            (self.bar(classes[1], [0.0, lengths[1]], half, half))
        }
    }

    fn bar(&self, class: &str, values: [f64; 2], down: f64, height: f64) -> Markup {
        let [left, right] = values.map(|value| self.panel.x_at(value));
        html! {
            @if right > left {
                rect class=(class) x=(coordinate(left)) y=(coordinate(self.top + down)) width=(coordinate(right - left))
                    height=(coordinate(height)) {}
            }
        }
    }

    /// A spread: a thin line from the least to the greatest of five values, a thick one between the second and the fourth,
    /// a dot at the third.
    pub(super) fn spread(&self, values: &[f64; 5]) -> Markup {
        let [least, low, middle, high, most] =
            values.map(|value| coordinate(self.panel.x_at(value)));
        let y = coordinate(self.top + MARK / 2.0);
        html! {
            g class="engine-0" {
                line class="spread" stroke-width="2" x1=(least) x2=(most) y1=(y) y2=(y) {}
                line class="spread" stroke-width="7" x1=(low) x2=(high) y1=(y) y2=(y) {}
                circle class="middle-mark" cx=(middle) cy=(y) r="4.5" {}
            }
        }
    }
}

/// What a spread means.
pub(super) fn spread_key() -> (Markup, String) {
    let mark = html! {
        g class="engine-0" {
            line class="spread" stroke-width="2" x1="0" x2="28" y1="7" y2="7" {}
            line class="spread" stroke-width="7" x1="6" x2="22" y1="7" y2="7" {}
            circle class="middle-mark" cx="14" cy="7" r="4.5" {}
        }
    };
    (mark, "median, 10 to 90 %, least to greatest".to_owned())
}
