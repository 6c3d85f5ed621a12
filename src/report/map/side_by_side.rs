//! Maps next to each other that show the same marks: a figure of a page, and a standalone SVG file.

use maud::{Markup, PreEscaped, html};

use super::standalone_map::{LEGEND_COLUMNS, MARGIN, STYLES};
use super::viewport::MAP_WIDTH;
use crate::report::number::coordinate;
use crate::report::svg::{LegendEntry, drawn_legend, legend_height, legend_list, light_style};

/// Width of a single map, and of each of several, drawing units.
const SINGLE_WIDTH: f64 = 960.0;
const SHARED_WIDTH: f64 = 440.0;
/// Height of the headline, and of a line of a caption.
const HEAD: f64 = 42.0;
const LINE: f64 = 18.0;
/// Letters of a caption that fit into the width of one of several maps.
const LETTERS: usize = 60;

/// One of the maps. Its width is [`MAP_WIDTH`].
pub(crate) struct MapPanel {
    pub(crate) content: Markup,
    pub(crate) height: f64,
    /// A sentence in place of the picture for screen readers.
    pub(crate) alt_text: String,
    /// The text below the map.
    pub(crate) caption: String,
}

/// Maps with a common legend.
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
                            svg class="map-picture" xmlns="http://www.w3.org/2000/svg" role="img" aria-label=(panel.alt_text)
                                viewBox=(panel.view_box()) { (panel.content) }
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
        let captions: Vec<Vec<String>> =
            self.panels.iter().map(|panel| lines(&panel.caption)).collect();
        let tallest = self.panels.iter().map(|panel| panel.height * scale).fold(0.0, f64::max);
        let most_lines = captions.iter().map(Vec::len).max().unwrap_or(0) as f64;
        let below = HEAD + tallest + LINE;
        let legend_top = below + LINE * most_lines;
        let width = columns as f64 * (map_width + MARGIN) + MARGIN;
        let height = legend_top + legend_height(self.legend.len(), LEGEND_COLUMNS) + MARGIN;
        let left = |column: usize| MARGIN + column as f64 * (map_width + MARGIN);
        let alternatives: Vec<&str> =
            self.panels.iter().map(|panel| panel.alt_text.as_str()).collect();
        let (w, h) = (coordinate(width), coordinate(height.ceil()));
        html! {
            svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label=(format!("{}. {}", self.title, alternatives.join(" ")))
                width=(w) height=(h) viewBox=(format!("0 0 {w} {h}")) {
                style { (PreEscaped(light_style(&STYLES))) }
                rect class="paper" width=(w) height=(h) {}
                text class="headline" x=(coordinate(MARGIN)) y="25" { (self.title) }
                @for (column, (panel, caption)) in self.panels.iter().zip(&captions).enumerate() {
                    // A nested picture clips everything outside the viewport.
                    svg class=(class) x=(coordinate(left(column))) y=(coordinate(HEAD)) width=(coordinate(map_width))
                        height=(coordinate(panel.height * scale)) viewBox=(panel.view_box()) { (panel.content) }
                    @for (number, line) in caption.iter().enumerate() {
                        text class="caption" x=(coordinate(left(column))) y=(coordinate(below + LINE * number as f64)) { (line) }
                    }
                }
                (drawn_legend(&self.legend, [MARGIN, legend_top], width - MARGIN, LEGEND_COLUMNS))
            }
        }
        .into_string()
    }
}

impl MapPanel {
    fn view_box(&self) -> String {
        format!("0 0 {MAP_WIDTH} {}", coordinate(self.height))
    }
}

/// Breaks a caption into lines that fit below a map.
fn lines(caption: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in caption.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= LETTERS => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
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
