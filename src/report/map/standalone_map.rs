//! A map as one SVG file that needs no page: headline, map, scale bar and legend.

use maud::{Markup, PreEscaped, html};

use super::decorations::{STRIP, strip};
use super::viewport::{MAP_WIDTH, Viewport};
use crate::report::number::coordinate;
use crate::report::svg::{LegendEntry, drawn_legend, legend_height, light_style};

/// Styles of standalone maps.
pub(super) const STYLES: [&str; 3] = [
    include_str!("../drawing.css"),
    include_str!("../map.css"),
    "svg { font-family: system-ui, \"DejaVu Sans\", sans-serif; font-size: 13px; } \
    .paper { fill: var(--panel); } .headline { font-size: 16px; font-weight: 700; } .caption { fill: var(--muted); } \
    .frame { fill: none; stroke: var(--rule); stroke-width: 1; } \
    .several text { font-size: 22px; } .several .number { font-size: 20px; font-weight: 700; } ",
];

/// Largest distance of a drawn line from its data, drawing units. A standalone picture is often drawn at twice its size.
pub(crate) const TOLERANCE: f64 = 0.1;

/// Height of the headline and the caption above the map.
const HEAD: f64 = 58.0;
/// Margin of the texts and the legend.
pub(super) const MARGIN: f64 = 14.0;
/// Columns of the legend.
pub(super) const LEGEND_COLUMNS: usize = 3;
/// Letters of a headline that fit, for the widest common ones.
const HEADLINE_LETTERS: usize = 64;

/// A standalone map picture.
pub(crate) struct StandaloneMap<'a> {
    /// Headline. It may hold any characters, and is cut if it is too long.
    pub(crate) title: &'a str,
    /// The line below the headline.
    pub(crate) caption: &'a str,
    /// Additional style of the marks on the map.
    pub(crate) style: &'a str,
    pub(crate) map: Markup,
    pub(crate) legend: Vec<LegendEntry>,
}

impl StandaloneMap<'_> {
    /// The picture as an SVG file.
    pub(crate) fn svg(&self, view: &Viewport) -> String {
        let map_height = view.height();
        let legend_top = HEAD + map_height + STRIP + MARGIN;
        let height = legend_top + legend_height(self.legend.len(), LEGEND_COLUMNS) + MARGIN;
        let (width, height) = (coordinate(MAP_WIDTH), coordinate(height.ceil()));
        let [drawing, map, own] = STYLES;
        html! {
            svg xmlns="http://www.w3.org/2000/svg" role="img"
                aria-label=(format!("{}. {}", self.title, self.caption))
                width=(width) height=(height) viewBox=(format!("0 0 {width} {height}")) {
                style { (PreEscaped(light_style(&[drawing, map, own, self.style]))) }
                rect class="paper" width=(width) height=(height) {}
                text class="headline" x=(coordinate(MARGIN)) y="25" { (shortened_headline(self.title)) }
                text class="caption" x=(coordinate(MARGIN)) y="45" { (self.caption) }
                // A nested picture clips everything outside the viewport.
                svg y=(coordinate(HEAD)) width=(width) height=(coordinate(map_height + STRIP))
                    viewBox=(format!("0 0 {width} {}", coordinate(map_height + STRIP))) {
                    (self.map)
                    (strip(view, map_height))
                }
                rect class="frame" x=".5" y=(coordinate(HEAD)) width=(coordinate(MAP_WIDTH - 1.0))
                    height=(coordinate(map_height)) {}
                (drawn_legend(&self.legend, [MARGIN, legend_top], MAP_WIDTH - MARGIN, LEGEND_COLUMNS))
            }
        }
        .into_string()
    }
}

fn shortened_headline(title: &str) -> String {
    if title.chars().count() <= HEADLINE_LETTERS {
        return title.to_owned();
    }
    let kept: String = title.chars().take(HEADLINE_LETTERS - 1).collect();
    kept + "…"
}
