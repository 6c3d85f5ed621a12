//! Curves of several things measured at the same values, told apart by colour and by the shape of their marks.

use maud::{Markup, html};

use super::figure::{drawn_legend, key, legend_height, line_mark};
use super::number::coordinate;
use super::panel::{CHART_WIDTH, Panel};

/// Things that colours can tell apart; further ones repeat them with other marks.
const COLOURS: usize = 6;

/// A curve of medians, and how far values go beyond them.
pub(super) struct Curve {
    pub(super) name: String,
    /// Which of several: decides colour and mark.
    pub(super) index: usize,
    /// Where it is measured, the median there, and the far value.
    pub(super) points: Vec<(f64, f64, f64)>,
    pub(super) far: Far,
}

/// How the far values are drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Far {
    /// A shaded band up to them.
    Band,
    /// A line through them: for curves that lie so near together that their bands would cover one another.
    Line,
    /// Not at all: there are none.
    Nothing,
}

impl Curve {
    pub(super) fn draw(&self, panel: &Panel) -> Markup {
        let middle = || self.points.iter().map(|&(x, middle, _)| (x, middle));
        html! {
            g class=(class(self.index)) {
                @match self.far {
                    Far::Band => { (panel.band("tail", &self.points)) }
                    Far::Nothing => {}
                    Far::Line => { (panel.line("far", self.points.iter().map(|&(x, _, far)| (x, far)))) }
                }
                (panel.line("median", middle()))
                @for (x, middle) in middle() { (self.marker(panel.x_at(x), panel.y_at(middle))) }
            }
        }
    }

    /// A piece of the curve, to explain it by, in a box of 28 by 14 units.
    pub(super) fn piece(&self) -> Markup {
        html! {
            g class=(class(self.index)) {
                line class="median" x1="1" x2="27" y1="7" y2="7" {}
                (self.marker(14.0, 7.0))
            }
        }
    }

    fn marker(&self, x: f64, y: f64) -> Markup {
        const SHAPES: [&str; 5] = [
            "m-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z",
            "m-3.5 -3.5h7v7h-7z",
            "m0 -4.8l4.4 8h-8.8z",
            "m0 -5l5 5l-5 5l-5 -5z",
            "m0 4.8l4.4 -8h-8.8z",
        ];
        let shape = SHAPES[self.index % SHAPES.len()];
        html! { path class="marker" d=(format!("M{} {}{shape}", coordinate(x), coordinate(y))) {} }
    }
}

/// The class that gives the first, second, ... of several things its colour.
pub(super) fn class(index: usize) -> String {
    format!("engine-{}", index % COLOURS)
}

/// A piece of a line through far values, of whichever curve, in a box of 28 by 14 units.
pub(super) fn far_mark() -> Markup {
    line_mark("far")
}

/// A panel with its curves, to stand in a page or in a picture of its own.
pub(super) struct Plot {
    pub(super) title: &'static str,
    /// Style of its marks, beyond what every chart has.
    pub(super) style: &'static str,
    pub(super) content: Markup,
    pub(super) height: f64,
    /// A mark in a box of 28 by 14 units, and its meaning.
    pub(super) keys: Vec<(Markup, String)>,
    /// A sentence for those who do not see it.
    pub(super) alternative: String,
}

/// Letters of a legend's entry that fit into half the width of a chart.
const SHORT: usize = 27;

impl Plot {
    /// Entries of a page's legend.
    pub(super) fn legend(&self) -> Vec<Markup> {
        self.keys
            .iter()
            .map(|(mark, meaning)| key(mark, meaning))
            .collect()
    }

    /// The legend as part of the picture, below the panel; in two columns where all its entries are short.
    pub(super) fn drawn_legend(&self) -> Markup {
        let place = [0.0, self.height + 6.0];
        drawn_legend(&self.keys, place, CHART_WIDTH, self.columns())
    }

    /// Height of the panel and its drawn legend.
    pub(super) fn height_with_legend(&self) -> f64 {
        self.height + 12.0 + legend_height(self.keys.len(), self.columns())
    }

    fn columns(&self) -> usize {
        let short = |(_, meaning): &(Markup, String)| meaning.chars().count() <= SHORT;
        if self.keys.iter().all(short) { 2 } else { 1 }
    }
}
