//! The faults of a drive, each with its ticks.

use maud::{Markup, html};
use serde_json::{Value, json};

use super::number::fixed;
use crate::runtime::{FaultEvents, TickEvent};

/// Most faults in the list. The timeline and the readings show the others too.
const MAX_LISTED: usize = 200;

/// A fault over consecutive ticks.
#[derive(Clone, Debug, PartialEq)]
struct Span {
    /// Index of its first tick.
    tick: usize,
    ticks: usize,
    /// Times of its first and last tick, s.
    from_s: f64,
    to_s: f64,
    text: String,
}

/// All faults of a drive, sorted by their first tick.
#[derive(Clone, Debug, Default)]
pub(super) struct FaultList {
    spans: Vec<Span>,
    events: FaultEvents,
}

impl FaultList {
    /// Records the faults of a tick. Ticks are recorded in order, without gaps.
    pub(super) fn record(&mut self, tick: usize, event: &TickEvent<'_>) {
        for text in self.events.update(event) {
            self.add(tick, event.row.time_s, text);
        }
    }

    fn add(&mut self, tick: usize, time_s: f64, text: String) {
        let continues = |span: &&mut Span| span.tick + span.ticks == tick && span.text == text;
        if let Some(span) = self.spans.iter_mut().rev().find(continues) {
            span.ticks += 1;
            span.to_s = time_s;
            return;
        }
        self.spans.push(Span { tick, ticks: 1, from_s: time_s, to_s: time_s, text });
    }

    /// The faults for the script: all distinct texts, and for each fault its first frame, its last frame and the index of
    /// its text. A frame covers `stride` ticks.
    pub(super) fn json(&self, stride: usize) -> Value {
        let mut texts: Vec<&str> = Vec::new();
        let mut spans: Vec<[usize; 3]> = Vec::new();
        for span in &self.spans {
            let index = texts.iter().position(|text| *text == span.text);
            let index = index.unwrap_or_else(|| {
                texts.push(&span.text);
                texts.len() - 1
            });
            let last = span.tick + span.ticks - 1;
            spans.push([span.tick / stride, last / stride, index]);
        }
        json!({ "texts": texts, "spans": spans })
    }

    /// A sentence for the text alternative of the timeline.
    pub(super) fn alt_text(&self) -> String {
        match self.spans.len() {
            0 => "No faults.".to_owned(),
            1 => "One fault is marked; it is listed below.".to_owned(),
            count => format!("{count} faults are marked; they are listed below."),
        }
    }

    /// The list. Each entry is a button that selects the first tick of its fault.
    pub(super) fn list(&self, stride: usize) -> Markup {
        let unlisted = self.spans.len().saturating_sub(MAX_LISTED);
        html! {
            div class="faults" {
                h4 { "Faults" }
                @if self.spans.is_empty() { p { "none" } } @else {
                    ol {
                        @for span in self.spans.iter().take(MAX_LISTED) {
                            li {
                                button type="button" data-frame=(span.tick / stride) {
                                    b { (fixed(span.from_s, 2)) " s" } " " (span.text)
                                    @if span.ticks > 1 { " (" (span.ticks) " ticks, until " (fixed(span.to_s, 2)) " s)" }
                                }
                            }
                        }
                    }
                    @if unlisted > 0 { p { (unlisted) " more faults are marked on the timeline above." } }
                }
            }
        }
    }
}
