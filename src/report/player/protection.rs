//! The actions of the protective layer over a drive.

use std::collections::BTreeMap;

use maud::{Markup, html};
use serde_json::{Value, json};

use super::event_list::EventList;
use crate::base::ProtectiveAction;
use crate::runtime::TickEvent;

/// The actions of the protective layer over a drive.
#[derive(Clone, Debug, Default)]
pub(super) struct ProtectionEvents {
    /// The command was zero instead.
    stops: EventList,
    /// The command was reduced.
    reductions: EventList,
    /// Ticks by the name of the action.
    ticks: BTreeMap<&'static str, u64>,
}

impl ProtectionEvents {
    /// Records the action of a tick. Ticks are recorded in order, without gaps.
    pub(super) fn record(&mut self, tick: usize, event: &TickEvent<'_>) {
        let action = event.protective_action;
        if action.passes() {
            return;
        }
        let list = if is_reduction(action) { &mut self.reductions } else { &mut self.stops };
        let name = action.name().to_owned();
        list.record(tick, event.row.time_s, name, Some(action.to_string()));
        *self.ticks.entry(action.name()).or_default() += 1;
    }

    /// Number of ticks with an action.
    pub(super) fn event_ticks(&self) -> usize {
        self.stops.ticks() + self.reductions.ticks()
    }

    /// Stops, reductions and the title of their lane, for the script.
    pub(super) fn json(&self, stride: usize) -> Value {
        json!({
            "title": format!("protective layer: {}", self.counts()),
            "stops": self.stops.json(stride),
            "reductions": self.reductions.json(stride),
        })
    }

    /// Ticks of each action.
    fn counts(&self) -> String {
        let counts = self.ticks.iter();
        let counts: Vec<String> =
            counts.map(|(name, ticks)| format!("{} {ticks}", name.replace('_', " "))).collect();
        if counts.is_empty() { "no action".to_owned() } else { counts.join(", ") + " ticks" }
    }

    /// A sentence for the text alternative of the timeline.
    pub(super) fn alt_text(&self) -> String {
        match self.event_ticks() {
            0 => "The protective layer did not act.".to_owned(),
            _ => format!(
                "The protective layer stopped the robot in {} ticks and reduced its command in {}; both are marked and listed.",
                self.stops.ticks(),
                self.reductions.ticks()
            ),
        }
    }

    /// The lists of stops and of reductions.
    pub(super) fn lists(&self, stride: usize) -> Markup {
        let lists =
            [("stops", "Stops", &self.stops), ("reductions", "Reduced commands", &self.reductions)];
        html! {
            @for (kind, title, list) in lists {
                details class="events" {
                    summary { (title) " of the protective layer: " (list.ticks()) " ticks" }
                    (list.list(kind, stride))
                }
            }
        }
    }
}

/// Whether the robot moves on with a part of its command.
const fn is_reduction(action: &ProtectiveAction) -> bool {
    match action {
        ProtectiveAction::Zone { factor, .. } => *factor > 0.0,
        ProtectiveAction::BlindSector { limit, .. } => *limit > 0.0,
        ProtectiveAction::Approach { .. }
        | ProtectiveAction::Slow { .. }
        | ProtectiveAction::Escape { .. } => true,
        _ => false,
    }
}
