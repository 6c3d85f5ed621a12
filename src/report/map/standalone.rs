//! Maps with their texts and legends: one map or several side by side, as figures of a page and as SVG files.

use maud::{Markup, PreEscaped, html};

use super::decorations::{STRIP, strip};
use super::viewport::{MAP_WIDTH, Viewport};
use crate::bench::columns::wrapped;
use crate::report::number::coordinate;
use crate::report::svg::{LegendEntry, drawn_legend, legend_height, legend_list, light_style};

/// Styles of standalone maps.
const STYLES: [&str; 3] = [
    include_str!("../drawing.css"),
    include_str!("../map.css"),
    "svg { font-family: system-ui, \"DejaVu Sans\", sans-serif; font-size: 13px; } \
    .paper { fill: var(--panel); } .headline { font-size: 16px; font-weight: 700; } .caption { fill: var(--muted); } \
    .frame { fill: none; stroke: var(--rule); stroke-width: 1; } \
    .several text { font-size: 22px; } .several .number { font-size: 20px; font-weight: 700; } ",
];

/// Largest distance of a drawn line from its data, drawing units. A standalone picture is often drawn at twice its size.
pub(crate) const STANDALONE_TOLERANCE: f64 = 0.1;

/// Margin of the texts and the legend.
const MARGIN: f64 = 14.0;
/// Columns of the legend.
const LEGEND_COLUMNS: usize = 3;

/// A single map: height of its headline and caption, and letters of a headline that fit, for the widest common ones.
const HEAD: f64 = 58.0;
const HEADLINE_LETTERS: usize = 64;

/// Maps side by side: width of a map without others, and of each of several.
const SINGLE_WIDTH: f64 = 960.0;
const SHARED_WIDTH: f64 = 440.0;
/// Height of the headline, and of a line of a caption, and its letters that fit into the width of one of several maps.
const HEADLINE: f64 = 42.0;
const LINE: f64 = 18.0;
const LETTERS: usize = 60;

/// A map. Its width is [`MAP_WIDTH`].
pub(crate) struct MapPanel {
    content: Markup,
    height: f64,
    /// A sentence in place of the picture for screen readers.
    alt_text: String,
    /// The text below the map.
    caption: String,
}

impl MapPanel {
    /// The layers of a map, and the strip below them.
    pub(crate) fn new(
        view: &Viewport,
        layers: &Markup,
        alt_text: String,
        caption: impl Into<String>,
    ) -> Self {
        let content = html! { (layers) (strip(view)) };
        Self { content, height: view.height() + STRIP, alt_text, caption: caption.into() }
    }

    /// The picture on a page.
    pub(crate) fn picture(&self) -> Markup {
        html! {
            svg class="map-picture" xmlns="http://www.w3.org/2000/svg" role="img" aria-label=(self.alt_text)
                viewBox=(self.view_box()) { (self.content) }
        }
    }

    fn view_box(&self) -> String {
        format!("0 0 {MAP_WIDTH} {}", coordinate(self.height))
    }
}

/// A map as one SVG file that needs no page: headline, map, scale bar and legend.
pub(crate) struct StandaloneMap<'a> {
    /// Headline. It may hold any characters, and is cut if it is too long.
    pub(crate) title: &'a str,
    /// The line below the headline.
    pub(crate) caption: &'a str,
    /// Additional style of the marks on the map.
    pub(crate) style: &'a str,
    pub(crate) layers: Markup,
    pub(crate) legend: Vec<LegendEntry>,
}

impl StandaloneMap<'_> {
    /// The picture as an SVG file.
    pub(crate) fn svg(&self, view: &Viewport) -> String {
        let alt_text = format!("{}. {}", self.title, self.caption);
        let panel = MapPanel::new(view, &self.layers, alt_text, self.caption);
        let headline = if self.title.chars().count() <= HEADLINE_LETTERS {
            self.title.to_owned()
        } else {
            self.title.chars().take(HEADLINE_LETTERS - 1).chain(['…']).collect()
        };
        let content = html! {
            text class="headline" x=(coordinate(MARGIN)) y="25" { (headline) }
            text class="caption" x=(coordinate(MARGIN)) y="45" { (panel.caption) }
            // A nested picture clips everything outside the viewport.
            svg y=(coordinate(HEAD)) width=(coordinate(MAP_WIDTH)) height=(coordinate(panel.height))
                viewBox=(panel.view_box()) { (panel.content) }
            rect class="frame" x=".5" y=(coordinate(HEAD)) width=(coordinate(MAP_WIDTH - 1.0))
                height=(coordinate(view.height())) {}
        };
        let legend_top = HEAD + view.height() + STRIP + MARGIN;
        svg_file(&panel.alt_text, self.style, &content, MAP_WIDTH, legend_top, &self.legend)
    }
}

/// Maps that show the same marks.
pub(crate) struct MapsSideBySide {
    /// Name of the file without its extension.
    pub(crate) name: String,
    pub(crate) title: String,
    pub(crate) panels: Vec<MapPanel>,
    pub(crate) legend: Vec<LegendEntry>,
}

impl MapsSideBySide {
    /// The figure of a page. Several figures with the same marks share one legend.
    pub(crate) fn figure(&self, with_legend: bool) -> Markup {
        html! {
            figure class="full-row" {
                h3 { (self.title) }
                div class=[(self.panels.len() > 1).then_some("three-maps")] {
                    @for panel in &self.panels {
                        div {
                            (panel.picture())
                            @if !panel.caption.is_empty() { p { (panel.caption) } }
                        }
                    }
                }
                @if with_legend { (legend_list(&self.legend)) }
            }
        }
    }

    /// An SVG file that needs no page.
    pub(crate) fn standalone_svg(&self) -> String {
        let columns = self.panels.len().max(1);
        let (map_width, class) =
            if columns > 1 { (SHARED_WIDTH, "several") } else { (SINGLE_WIDTH, "single") };
        let scale = map_width / MAP_WIDTH;
        let left = |column: usize| MARGIN + column as f64 * (map_width + MARGIN);
        let captions: Vec<Vec<String>> =
            self.panels.iter().map(|panel| lines(&panel.caption)).collect();
        let tallest = self.panels.iter().map(|panel| panel.height * scale).fold(0.0, f64::max);
        let most_lines = captions.iter().map(Vec::len).max().unwrap_or(0) as f64;
        let below = HEADLINE + tallest + LINE;
        let alternatives: Vec<&str> =
            self.panels.iter().map(|panel| panel.alt_text.as_str()).collect();
        let alt_text = format!("{}. {}", self.title, alternatives.join(" "));
        let content = html! {
            text class="headline" x=(coordinate(MARGIN)) y="25" { (self.title) }
            @for (column, (panel, caption)) in self.panels.iter().zip(&captions).enumerate() {
                // A nested picture clips everything outside the viewport.
                svg class=(class) x=(coordinate(left(column))) y=(coordinate(HEADLINE)) width=(coordinate(map_width))
                    height=(coordinate(panel.height * scale)) viewBox=(panel.view_box()) { (panel.content) }
                @for (number, line) in caption.iter().enumerate() {
                    text class="caption" x=(coordinate(left(column))) y=(coordinate(below + LINE * number as f64)) { (line) }
                }
            }
        };
        let width = columns as f64 * (map_width + MARGIN) + MARGIN;
        svg_file(&alt_text, "", &content, width, below + LINE * most_lines, &self.legend)
    }
}

/// An SVG file of maps with a legend below them.
fn svg_file(
    alt_text: &str,
    style: &str,
    content: &Markup,
    width: f64,
    legend_top: f64,
    legend: &[LegendEntry],
) -> String {
    let [drawing, map, own] = STYLES;
    let height = legend_top + legend_height(legend.len(), LEGEND_COLUMNS) + MARGIN;
    let (w, h) = (coordinate(width), coordinate(height.ceil()));
    html! {
        svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label=(alt_text)
            width=(w) height=(h) viewBox=(format!("0 0 {w} {h}")) {
            style { (PreEscaped(light_style(&[drawing, map, own, style]))) }
            rect class="paper" width=(w) height=(h) {}
            (content)
            (drawn_legend(legend, [MARGIN, legend_top], width - MARGIN, LEGEND_COLUMNS))
        }
    }
    .into_string()
}

/// Breaks a caption into lines that fit below a map.
fn lines(caption: &str) -> Vec<String> {
    wrapped(caption.split_whitespace(), LETTERS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn caption_lines_keep_every_word_and_their_width() {
        let caption = "one two three four five ".repeat(20);
        let lines = lines(&caption);
        assert!(lines.iter().all(|line| line.chars().count() <= LETTERS));
        assert_eq!(lines.join(" "), caption.trim());
        // Each line is full: the first word of the next line does not fit.
        for pair in lines.windows(2) {
            let next = pair[1].split(' ').next().expect("a line has words");
            assert!(pair[0].len() + 1 + next.len() > LETTERS, "{pair:?}");
        }
    }
}
