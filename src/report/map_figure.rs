//! Maps beside one another that show the same thing: a figure of a page, and a picture of its own.

use maud::{Markup, PreEscaped, html};

use super::figure::{drawn_legend, key, legend_height};
use super::number::coordinate;
use super::plain_style::plain;
use super::viewport::MAP_WIDTH;

const STYLE: &str = concat!(
    include_str!("drawing.css"),
    include_str!("map.css"),
    include_str!("drive_map.css"),
    include_str!("paper_maps.css")
);

/// What only a picture of its own needs.
const OWN_STYLE: &str = "svg { font-family: system-ui, \"DejaVu Sans\", sans-serif; font-size: 13px; } \
    .paper { fill: var(--panel); } .headline { font-size: 16px; font-weight: 700; } .caption { fill: var(--muted); } \
    .several text { font-size: 22px; } .several .number { font-size: 20px; font-weight: 700; } ";

/// Width of a picture's map, of one alone and of one among several; and around and between them.
const ALONE: f64 = 960.0;
const AMONG: f64 = 440.0;
const MARGIN: f64 = 14.0;
/// Height of the headline, and of a line of a caption.
const HEAD: f64 = 42.0;
const LINE: f64 = 18.0;
/// Letters of a caption that fit into the width of a map among several.
const LETTERS: usize = 60;
/// Columns of the legend.
const COLUMNS: usize = 3;

/// A map of [`MAP_WIDTH`] by a height.
pub(super) struct MapPanel {
    pub(super) content: Markup,
    pub(super) height: f64,
    /// A sentence for those who do not see it.
    pub(super) alternative: String,
    /// Stands below it.
    pub(super) words: String,
}

/// Maps and what their marks mean.
pub(super) struct MapFigure {
    /// Name of its file without the ending.
    pub(super) name: String,
    pub(super) title: String,
    pub(super) panels: Vec<MapPanel>,
    pub(super) keys: Vec<(Markup, String)>,
}

impl MapFigure {
    /// As a page has it, where its legend may stand below another figure with the same marks.
    pub(super) fn markup(&self, with_legend: bool) -> Markup {
        html! {
            figure class="whole-row" {
                h3 { (self.title) }
                div class=[(self.panels.len() > 1).then_some("trio")] {
                    @for panel in &self.panels {
                        div {
                            svg class="map-picture" xmlns="http://www.w3.org/2000/svg" role="img" aria-label=(panel.alternative)
                                viewBox=(panel.view_box()) { (panel.content) }
                            @if !panel.words.is_empty() { p { (panel.words) } }
                        }
                    }
                }
                @if with_legend { ul class="legend" { @for (mark, meaning) in &self.keys { li { (key(mark, meaning)) } } } }
            }
        }
    }

    /// An SVG file that holds everything it needs, and no style in it asks more of a program than CSS classes.
    pub(super) fn picture(&self) -> String {
        let columns = self.panels.len().max(1);
        let (map_width, class) = if columns > 1 {
            (AMONG, "several")
        } else {
            (ALONE, "alone")
        };
        let scale = map_width / MAP_WIDTH;
        let captions: Vec<Vec<String>> = self
            .panels
            .iter()
            .map(|panel| lines(&panel.words))
            .collect();
        let tallest = self
            .panels
            .iter()
            .map(|panel| panel.height * scale)
            .fold(0.0, f64::max);
        let most_lines = captions.iter().map(Vec::len).max().unwrap_or(0) as f64;
        let below = HEAD + tallest + LINE;
        let legend_top = below + LINE * most_lines;
        let width = columns as f64 * (map_width + MARGIN) + MARGIN;
        let height = legend_top + legend_height(self.keys.len(), COLUMNS) + MARGIN;
        let left = |column: usize| MARGIN + column as f64 * (map_width + MARGIN);
        let alternatives: Vec<&str> = self
            .panels
            .iter()
            .map(|panel| panel.alternative.as_str())
            .collect();
        let (w, h) = (coordinate(width), coordinate(height.ceil()));
        html! {
            svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label=(format!("{}. {}", self.title, alternatives.join(" ")))
                width=(w) height=(h) viewBox=(format!("0 0 {w} {h}")) {
                style { (PreEscaped(plain(STYLE))) (PreEscaped(plain(OWN_STYLE))) }
                rect class="paper" width=(w) height=(h) {}
                text class="headline" x=(coordinate(MARGIN)) y="25" { (self.title) }
                @for (column, (panel, caption)) in self.panels.iter().zip(&captions).enumerate() {
                    // A picture within the picture: what lies off the map's part stays inside its frame.
                    svg class=(class) x=(coordinate(left(column))) y=(coordinate(HEAD)) width=(coordinate(map_width))
                        height=(coordinate(panel.height * scale)) viewBox=(panel.view_box()) { (panel.content) }
                    @for (number, line) in caption.iter().enumerate() {
                        text class="caption" x=(coordinate(left(column))) y=(coordinate(below + LINE * number as f64)) { (line) }
                    }
                }
                (drawn_legend(&self.keys, [MARGIN, legend_top], width - MARGIN, COLUMNS))
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

/// Words in lines that fit below a map.
fn lines(words: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words.split_whitespace() {
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
    fn captions_keep_every_word_and_their_width() {
        let words = "one two three four five ".repeat(20);
        let lines = lines(&words);
        assert!(lines.iter().all(|line| line.chars().count() <= LETTERS));
        assert_eq!(lines.join(" "), words.trim());
        // And no line has room for the word that begins the next.
        for pair in lines.windows(2) {
            let next = pair[1].split(' ').next().expect("a line has words");
            assert!(pair[0].len() + 1 + next.len() > LETTERS, "{pair:?}");
        }
    }
}
