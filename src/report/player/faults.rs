//! What went wrong on a drive, each at its tick.

use maud::{Markup, html};
use serde_json::{Value, json};

use crate::report::number::fixed;
use crate::runtime::{FaultEvents, TickEvent};

/// So many are listed in words; the curves and the read-out show the others too.
const MOST_LISTED: usize = 200;

/// One thing that went wrong, for as many ticks in a row as it was the same.
#[derive(Clone, Debug, PartialEq)]
struct Span {
    /// Its first tick, from zero.
    tick: usize,
    ticks: usize,
    /// Times of its first and last tick, seconds.
    from_s: f64,
    to_s: f64,
    what: String,
}

/// All of it, in order of its beginning.
#[derive(Clone, Debug, Default)]
pub(super) struct Faults {
    spans: Vec<Span>,
    troubles: FaultEvents,
}

impl Faults {
    /// Takes what went wrong at a tick, which is one after the last.
    pub fn take(&mut self, tick: usize, moment: &TickEvent<'_>) {
        for what in self.troubles.at(moment) {
            self.note(tick, moment.row.time_s, what);
        }
    }

    fn note(&mut self, tick: usize, time_s: f64, what: String) {
        let goes_on = |span: &&mut Span| span.tick + span.ticks == tick && span.what == what;
        if let Some(span) = self.spans.iter_mut().rev().find(goes_on) {
            span.ticks += 1;
            span.to_s = time_s;
            return;
        }
        self.spans.push(Span {
            tick,
            ticks: 1,
            from_s: time_s,
            to_s: time_s,
            what,
        });
    }

    /// As the script reads it: all words, and of each fault its first and last frame and the place of its words. A frame
    /// stands for so many ticks.
    pub fn film(&self, stride: usize) -> Value {
        let mut words: Vec<&str> = Vec::new();
        let mut spans: Vec<[usize; 3]> = Vec::new();
        for span in &self.spans {
            let place = words.iter().position(|word| *word == span.what);
            let place = place.unwrap_or_else(|| {
                words.push(&span.what);
                words.len() - 1
            });
            let last = span.tick + span.ticks - 1;
            spans.push([span.tick / stride, last / stride, place]);
        }
        json!({ "words": words, "spans": spans })
    }

    /// In a word, for those who do not see the marks.
    pub fn said(&self) -> String {
        match self.spans.len() {
            0 => "No faults.".to_owned(),
            1 => "One fault is marked; it is listed below.".to_owned(),
            many => format!("{many} faults are marked; they are listed below."),
        }
    }

    /// The list, each entry a button that leads to its tick.
    pub fn list(&self, stride: usize) -> Markup {
        let more = self.spans.len().saturating_sub(MOST_LISTED);
        html! {
            div class="faults" {
                h4 { "Faults" }
                @if self.spans.is_empty() { p { "none" } } @else {
                    ol {
                        @for span in self.spans.iter().take(MOST_LISTED) {
                            li {
                                button type="button" data-frame=(span.tick / stride) {
                                    b { (fixed(span.from_s, 2)) " s" } " " (span.what)
                                    @if span.ticks > 1 { " (" (span.ticks) " ticks, to " (fixed(span.to_s, 2)) " s)" }
                                }
                            }
                        }
                    }
                    @if more > 0 { p { "And " (more) " more, marked on the curves above." } }
                }
            }
        }
    }
}
