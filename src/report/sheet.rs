//! A map as one picture, to be looked at without a page: a headline, the map, a scale bar and a legend.

use maud::{Markup, PreEscaped, html};

use super::figure::{drawn_legend, legend_height};
use super::map_furniture::strip;
use super::map_picture::STRIP;
use super::number::coordinate;
use super::plain_style::plain;
use super::viewport::{MAP_WIDTH, Viewport};

const STYLE: &str = concat!(include_str!("drawing.css"), include_str!("map.css"));

/// What only a picture of its own needs.
const OWN_STYLE: &str = "svg { font-family: system-ui, \"DejaVu Sans\", sans-serif; font-size: 13px; } \
    .paper { fill: var(--panel); } .headline { font-size: 16px; font-weight: 700; } .caption { fill: var(--muted); } \
    .frame { fill: none; stroke: var(--rule); stroke-width: 1; } ";

/// Pixels of the ground's longer side, at most: twice those of a picture of 1440, so that nothing is blurred, and no
/// cell of a large mine is lost between two pixels.
pub(super) const RASTER_SIDE: i32 = 2880;

/// How far a drawn line may lie from the data, drawing units: less than on a page, whose lines are not drawn twice as
/// large.
pub(super) const TOLERANCE: f64 = 0.1;

/// Height of the headline and caption above the map.
const HEAD: f64 = 58.0;
/// Space beside the texts, and around the legend.
const MARGIN: f64 = 14.0;
/// Columns of the legend.
const COLUMNS: usize = 3;
/// Letters of the headline that fit beside one another, of the widest usual ones.
const HEADLINE_LETTERS: usize = 64;

/// What a picture shows.
pub(super) struct Sheet<'a> {
    /// Headline. It may hold any characters; it is escaped, and cut where it is too long.
    pub(super) title: &'a str,
    /// The line below.
    pub(super) caption: &'a str,
    /// Styles of what is drawn on the map.
    pub(super) style: &'a str,
    /// The map.
    pub(super) map: Markup,
    /// What its marks mean.
    pub(super) keys: Vec<(Markup, String)>,
}

impl Sheet<'_> {
    /// The picture as an SVG file.
    pub(super) fn svg(&self, view: &Viewport) -> String {
        let map_height = view.height();
        let legend_top = HEAD + map_height + STRIP + MARGIN;
        let height = legend_top + legend_height(self.keys.len(), COLUMNS) + MARGIN;
        let (width, height) = (coordinate(MAP_WIDTH), coordinate(height.ceil()));
        html! {
            svg xmlns="http://www.w3.org/2000/svg" role="img"
                aria-label=(format!("{}. {}", self.title, self.caption))
                width=(width) height=(height) viewBox=(format!("0 0 {width} {height}")) {
                style { (PreEscaped(plain(STYLE))) (PreEscaped(plain(OWN_STYLE))) (PreEscaped(plain(self.style))) }
                rect class="paper" width=(width) height=(height) {}
                text class="headline" x=(coordinate(MARGIN)) y="25" { (cut(self.title)) }
                text class="caption" x=(coordinate(MARGIN)) y="45" { (self.caption) }
                // A picture within the picture: what lies off the map's part stays inside its frame.
                svg y=(coordinate(HEAD)) width=(width) height=(coordinate(map_height + STRIP))
                    viewBox=(format!("0 0 {width} {}", coordinate(map_height + STRIP))) {
                    (self.map)
                    (strip(view, map_height))
                }
                rect class="frame" x=".5" y=(coordinate(HEAD)) width=(coordinate(MAP_WIDTH - 1.0))
                    height=(coordinate(map_height)) {}
                (drawn_legend(&self.keys, [MARGIN, legend_top], MAP_WIDTH - MARGIN, COLUMNS))
            }
        }
        .into_string()
    }
}

/// As much of a headline as fits.
fn cut(title: &str) -> String {
    if title.chars().count() <= HEADLINE_LETTERS {
        return title.to_owned();
    }
    let kept: String = title.chars().take(HEADLINE_LETTERS - 1).collect();
    kept + "…"
}
