//! Events over consecutive ticks: the lanes of the timeline and the lists below it.

use maud::{Markup, html};
use serde_json::{Value, json};

use super::super::number::fixed;

/// Most events in a list. The timeline and the readings show the others too.
const MAX_LISTED: usize = 200;

/// An event over consecutive ticks.
#[derive(Clone, Debug, PartialEq)]
struct Span {
    /// Index of its first tick.
    tick: usize,
    ticks: usize,
    /// Times of its first and last tick, seconds.
    from_s: f64,
    to_s: f64,
    /// Equal names of consecutive ticks are one event.
    name: String,
    /// The sentence of its first tick; none where the name is the sentence.
    sentence: Option<String>,
}

impl Span {
    fn text(&self) -> &str {
        self.sentence.as_deref().unwrap_or(&self.name)
    }
}

/// The events of a kind over a drive, sorted by their first tick.
#[derive(Clone, Debug, Default)]
pub(super) struct EventList {
    spans: Vec<Span>,
}

impl EventList {
    /// Records an event of a tick, at a time in seconds, by its name. Ticks are recorded in order, without gaps. `sentence`
    /// describes this tick.
    pub(super) fn record(
        &mut self,
        tick: usize,
        time_s: f64,
        name: String,
        sentence: Option<String>,
    ) {
        let continues = |span: &&mut Span| span.tick + span.ticks == tick && span.name == name;
        if let Some(span) = self.spans.iter_mut().rev().find(continues) {
            span.ticks += 1;
            span.to_s = time_s;
        } else {
            self.spans.push(Span { tick, ticks: 1, from_s: time_s, to_s: time_s, name, sentence });
        }
    }

    /// Number of events.
    pub(super) const fn len(&self) -> usize {
        self.spans.len()
    }

    /// Number of ticks of all events.
    pub(super) fn ticks(&self) -> usize {
        self.spans.iter().map(|span| span.ticks).sum()
    }

    /// The events for the script: all distinct texts, and for each event its first frame, its last frame and the index of
    /// its text. A frame covers `stride` ticks.
    pub(super) fn json(&self, stride: usize) -> Value {
        let mut texts: Vec<&str> = Vec::new();
        let mut spans: Vec<[usize; 3]> = Vec::new();
        for span in &self.spans {
            let index = texts.iter().position(|text| *text == span.text());
            let index = index.unwrap_or_else(|| {
                texts.push(span.text());
                texts.len() - 1
            });
            let last = span.tick + span.ticks - 1;
            spans.push([span.tick / stride, last / stride, index]);
        }
        json!({ "texts": texts, "spans": spans })
    }

    /// The list. Each entry is a button that selects the first tick of its event. `kind` is the plural of the events.
    pub(super) fn list(&self, kind: &str, stride: usize) -> Markup {
        let unlisted = self.spans.len().saturating_sub(MAX_LISTED);
        html! {
            @if self.spans.is_empty() { p { "none" } } @else {
                ol {
                    @for span in self.spans.iter().take(MAX_LISTED) {
                        li {
                            button type="button" data-frame=(span.tick / stride) {
                                b { (fixed(span.from_s, 2)) " s" } " " (span.text())
                                @if span.ticks > 1 { " (" (span.ticks) " ticks, until " (fixed(span.to_s, 2)) " s)" }
                            }
                        }
                    }
                }
                @if unlisted > 0 { p { (unlisted) " more " (kind) " are marked on the timeline above." } }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn consecutive_ticks_of_a_name_are_one_event_with_the_sentence_of_the_first() {
        let mut list = EventList::default();
        for tick in [3, 4, 5, 9] {
            let sentence = Some(format!("slow at tick {tick}"));
            list.record(tick, tick as f64 * 0.1, "slow".to_owned(), sentence);
        }
        list.record(10, 1.0, "escape".to_owned(), None);
        assert_eq!((list.len(), list.ticks()), (3, 5));
        let expected = json!({
            "texts": ["slow at tick 3", "slow at tick 9", "escape"],
            "spans": [[1, 2, 0], [4, 4, 1], [5, 5, 2]],
        });
        assert_eq!(list.json(2), expected);
        let text = list.list("events", 2).into_string();
        assert!(text.contains("<b>0.30 s</b> slow at tick 3 (3 ticks, until 0.50 s)"), "{text}");
    }
}
