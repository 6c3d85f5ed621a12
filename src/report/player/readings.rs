//! The values next to the player's map, each with its meaning, which is shown on hover and on keyboard focus.

use maud::{Markup, html};

/// A group of values.
struct Group {
    title: &'static str,
    readings: &'static [Reading],
}

/// A value.
struct Reading {
    label: &'static str,
    /// Its name in the script.
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    /// Whether it is a sentence, not a number.
    is_text: bool,
}

const fn value(
    label: &'static str,
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
) -> Reading {
    Reading { label, name, unit, meaning, is_text: false }
}

const fn text(label: &'static str, name: &'static str, meaning: &'static str) -> Reading {
    Reading { label, name, unit: "", meaning, is_text: true }
}

const GROUPS: [Group; 3] = [
    Group {
        title: "Motion",
        readings: &[
            value(
                "speed",
                "speed",
                "m/s",
                "Forward speed of the robot: the simulated truth, or as the base measured it in a real or replayed drive.",
            ),
            value(
                "speed, command",
                "commanded_speed",
                "m/s",
                "Forward speed that was sent to the base in this tick. The base follows with a delay.",
            ),
            value(
                "turn rate",
                "turn_rate",
                "rad/s",
                "Turn rate of the robot, counter-clockwise positive: the simulated truth, or as the base measured it in a real or replayed drive.",
            ),
            value(
                "turn rate, command",
                "commanded_turn_rate",
                "rad/s",
                "Turn rate that was sent to the base in this tick, counter-clockwise positive.",
            ),
            value(
                "gap",
                "gap",
                "m",
                "Smallest distance between the footprint and anything solid, standing or moving. At or below 0 the robot touches it.",
            ),
        ],
    },
    Group {
        title: "Decision",
        readings: &[
            value(
                "admissible",
                "admissible",
                "samples",
                "Samples that touch nothing and from which the robot can stop in time, of all samples of the dynamic window.",
            ),
            value(
                "decision time",
                "decision_time",
                "ms",
                "Time of the whole decision, from the sensor data to the command. LATE: longer than the control period.",
            ),
            value(
                "heading",
                "heading",
                "rad",
                "Pi minus the angle between the heading at the end of the chosen trajectory and the direction to the target. \
                3.142: it faces the target; 0: it faces away. More is better.",
            ),
            value(
                "clearance",
                "clearance",
                "m",
                "Smallest clearance along the chosen trajectory, at most max_clearance_m. More is better.",
            ),
            value(
                "velocity",
                "velocity",
                "m/s",
                "Forward speed of the chosen trajectory, 0 in reverse. More is better.",
            ),
            value(
                "path",
                "path",
                "m",
                "Distance from the end of the chosen trajectory to the key node of the global path. Less is better.",
            ),
            value(
                "score",
                "score",
                "",
                "Weighted sum of the normalised heading, clearance and velocity, less that of the path (eq. 35). The sample with the largest \
                score is chosen. Scores of different ticks do not compare.",
            ),
        ],
    },
    Group {
        title: "State",
        readings: &[
            value(
                "time",
                "time",
                "s",
                "Time since the start of the drive, at the start of the tick.",
            ),
            value("mode", "mode", "", "Behaviour of the navigator that decided in this tick."),
            value(
                "plan",
                "plan",
                "",
                "Number of the global path that the robot follows, of all global paths of the drive.",
            ),
            text(
                "protective layer",
                "protection",
                "What the protective layer did to the command before it was sent to the base.",
            ),
            text("fault", "fault", "Faults of the sensors, the engine or the base in this tick."),
        ],
    },
];

/// The values in their groups. Identifiers start with a prefix that is unique on the page.
pub(super) fn readings(prefix: &str) -> Markup {
    html! {
        div class="readings" {
            @for group in &GROUPS {
                div class="reading-group" role="group" aria-label=(group.title) {
                    h4 { (group.title) }
                    dl aria-live="off" {
                        @for reading in group.readings { (reading.markup(prefix)) }
                    }
                }
            }
        }
    }
}

impl Reading {
    fn markup(&self, prefix: &str) -> Markup {
        let id = format!("{prefix}-meaning-{}", self.name);
        html! {
            div class=[self.is_text.then_some("full-line")] {
                dt {
                    span class="term" tabindex="0" aria-describedby=(id) { (self.label) }
                    span class="meaning" role="tooltip" id=(id) { (self.meaning) }
                }
                dd { span data-reading=(self.name) { "–" } " " (self.unit) }
            }
        }
    }
}
