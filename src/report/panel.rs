//! The plotting area of a chart: axes, and marks placed by their values.

use std::collections::BTreeSet;
use std::fmt::Write;

use maud::{Markup, html};

use super::axis::{Axis, Tick};
use super::number::coordinate;
use super::simplify::{TOLERANCE, simplify};

/// Width of every chart in drawing units. Narrow, so that its text stays readable on a phone.
pub(super) const CHART_WIDTH: f64 = 440.0;

/// A rectangle of a drawing with a value axis on two sides.
pub(super) struct Panel {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) x: Axis,
    pub(super) y: Axis,
}

/// An SVG picture of [`CHART_WIDTH`] by a height, with a sentence for those who do not see it.
pub(super) fn chart(height: f64, alternative: &str, content: &Markup) -> Markup {
    html! {
        svg class="chart" xmlns="http://www.w3.org/2000/svg" role="img" aria-label=(alternative)
            viewBox=(format!("0 0 {CHART_WIDTH} {height}")) {
            (content)
        }
    }
}

/// The `points` attribute of a line.
pub(super) fn points_attribute(points: &[[f64; 2]]) -> String {
    let pairs: Vec<String> = points
        .iter()
        .map(|&[x, y]| format!("{},{}", coordinate(x), coordinate(y)))
        .collect();
    pairs.join(" ")
}

impl Panel {
    /// A panel as wide as the chart, with room for the labels of its axes, from `top` on.
    pub(super) fn across(top: f64, height: f64, x: Axis, y: Axis) -> Self {
        const LEFT: f64 = 46.0;
        const RIGHT: f64 = 14.0;
        Self {
            left: LEFT,
            top,
            width: CHART_WIDTH - LEFT - RIGHT,
            height,
            x,
            y,
        }
    }

    pub(super) fn bottom(&self) -> f64 {
        self.top + self.height
    }

    pub(super) fn right(&self) -> f64 {
        self.left + self.width
    }

    /// Where a horizontal value lies in the drawing.
    pub(super) fn x_at(&self, value: f64) -> f64 {
        self.left + self.x.fraction(value) * self.width
    }

    /// Where a vertical value lies in the drawing, whose y axis points down.
    pub(super) fn y_at(&self, value: f64) -> f64 {
        self.bottom() - self.y.fraction(value) * self.height
    }

    /// The frame, the grid lines with their labels, and the title of the vertical axis above it; that of the
    /// horizontal one below. Without a horizontal title its tick labels are left out too.
    pub(super) fn axes(&self, x_title: Option<&str>, y_title: &str) -> Markup {
        self.axes_with(&self.x.ticks(), x_title, y_title)
    }

    /// The same with these places along the horizontal axis.
    pub(super) fn axes_with(
        &self,
        x_ticks: &[Tick],
        x_title: Option<&str>,
        y_title: &str,
    ) -> Markup {
        let (left, right) = (coordinate(self.left), coordinate(self.right()));
        let (top, bottom) = (coordinate(self.top), coordinate(self.bottom()));
        html! {
            g class="axes" {
                @for tick in self.y.ticks() {
                    @let y = coordinate(self.y_at(tick.value));
                    line x1=(left) x2=(right) y1=(y) y2=(y) {}
                    text class="end" x=(coordinate(self.left - 6.0)) y=(y) dy=".35em" { (tick.label) }
                }
                @for tick in x_ticks {
                    @let x = coordinate(self.x_at(tick.value));
                    line x1=(x) x2=(x) y1=(top) y2=(bottom) {}
                    @if x_title.is_some() {
                        text class="middle" x=(x) y=(bottom) dy="1.25em" { (tick.label) }
                    }
                }
                rect x=(left) y=(top) width=(coordinate(self.width)) height=(coordinate(self.height)) {}
                text class="title" x="0" y=(coordinate(self.top - 13.0)) { (y_title) }
                @if let Some(title) = x_title {
                    text class="title end" x=(right) y=(bottom) dy="2.6em" { (title) }
                }
            }
        }
    }

    /// A line through values. It breaks where one is not finite, and is simplified to [`TOLERANCE`].
    pub(super) fn line(&self, class: &str, values: impl IntoIterator<Item = (f64, f64)>) -> Markup {
        let mut runs: Vec<Vec<[f64; 2]>> = vec![Vec::new()];
        for (x, y) in values {
            if x.is_finite() && y.is_finite() {
                if let Some(run) = runs.last_mut() {
                    run.push([self.x_at(x), self.y_at(y)]);
                }
            } else {
                runs.push(Vec::new());
            }
        }
        html! {
            @for run in runs.iter().filter(|run| !run.is_empty()) {
                polyline class=(class) points=(points_attribute(&simplify(run, TOLERANCE))) {}
            }
        }
    }

    /// The area between two lines of the same horizontal values, all finite.
    pub(super) fn band(&self, class: &str, low_and_high: &[(f64, f64, f64)]) -> Markup {
        let there = low_and_high
            .iter()
            .map(|&(x, low, _)| [self.x_at(x), self.y_at(low)]);
        let back = low_and_high
            .iter()
            .rev()
            .map(|&(x, _, high)| [self.x_at(x), self.y_at(high)]);
        let outline: Vec<[f64; 2]> = there.chain(back).collect();
        html! { polygon class=(class) points=(points_attribute(&outline)) {} }
    }

    /// A dot for each pair of values. Dots nearer than half a drawing unit to another are drawn once.
    pub(super) fn dots(&self, class: &str, values: impl IntoIterator<Item = (f64, f64)>) -> Markup {
        let half_units: BTreeSet<(i64, i64)> = values
            .into_iter()
            .filter(|(x, y)| x.is_finite() && y.is_finite())
            .map(|(x, y)| {
                let place = |at: f64| libm::round(at * 2.0) as i64;
                (place(self.x_at(x)), place(self.y_at(y)))
            })
            .collect();
        let mut path = String::new();
        for (x, y) in half_units {
            // A stroke of no length with round ends is a dot.
            let (x, y) = (coordinate(x as f64 / 2.0), coordinate(y as f64 / 2.0));
            write!(path, "M{x} {y}h0").expect("writing to a string cannot fail");
        }
        html! { path class=(class) d=(path) {} }
    }

    /// A horizontal line at a value, with its label on it at the right end.
    pub(super) fn level(&self, value: f64, label: &str) -> Markup {
        let y = coordinate(self.y_at(value));
        html! {
            line class="limit" x1=(coordinate(self.left)) x2=(coordinate(self.right())) y1=(y) y2=(y) {}
            text class="end halo" x=(coordinate(self.right() - 4.0)) y=(y) dy="-.4em" { (label) }
        }
    }
}
