//! The legend of the player's map. Entries with a layer have a checkbox that shows or hides it.

use maud::{Markup, html};

use crate::report::map::{Viewport, goal_mark, ground_legend};
use crate::report::svg::{LegendEntry, legend_entry};
use crate::runtime::Mission;

/// The legend of everything that the map shows.
pub(super) fn legend(mission: &Mission, view: &Viewport) -> Markup {
    let ground = ground_legend(&mission.map, view);
    html! {
        ul class="legend layers" aria-label="Legend of the map, with a checkbox for each layer" {
            @for (layer, entry) in layers() {
                li { label {
                    input type="checkbox" data-layer=(layer) checked;
                    (legend_entry(&entry))
                } }
            }
            @for entry in marks().iter().chain(&ground) { li { (legend_entry(entry)) } }
        }
    }
}

/// The classes of scores from the lowest to the highest, and the ends of their lines in the legend.
const SCORES: [(&str, &str); 4] =
    [("speed-0", "24 6"), ("speed-1", "25 2"), ("speed-2", "25 -2"), ("speed-3", "24 -6")];

/// The layers: name in the script, and entry.
fn layers() -> [(&'static str, LegendEntry); 8] {
    let lidar = html! {
        @for x in [4, 12, 20] { rect class="lidar-return" x=(x) y="5" width="4" height="4" {} }
    };
    let sampled = html! {
        @for (class, end) in SCORES { path class=(format!("sample {class}")) d=(format!("M1 7q12 0 {end}")) {} }
    };
    let rejected = html! {
        path class="sample rejected" d="M1 7q12 0 24 6M1 7h25M1 7q12 0 24 -6" {}
    };
    let predicted = html! {
        @for x in [8, 14, 20] { circle class="predicted-obstacle" cx=(x) cy="7" r="6" {} }
    };
    [
        ("path", LegendEntry::line("followed-path", "global path")),
        ("track", LegendEntry::line("driven-track", "driven track")),
        ("lidar", LegendEntry::new(lidar, "lidar returns")),
        ("sampled", LegendEntry::new(sampled, "sampled trajectories, lowest to highest score")),
        (
            "rejected",
            LegendEntry::new(
                rejected,
                "rejected samples: they collide, cannot stop or leave the known area",
            ),
        ),
        ("chosen", LegendEntry::line("chosen-trajectory", "chosen trajectory")),
        ("moving", LegendEntry::circle("true-obstacle", 6.0, "moving obstacle, present position")),
        ("predictions", LegendEntry::new(predicted, "moving obstacle, predicted over the horizon")),
    ]
}

/// The marks that are always shown.
fn marks() -> [LegendEntry; 3] {
    let robot = html! {
        rect class="robot" x="5" y="2" width="15" height="10" {}
        line class="heading" x1="13" x2="22" y1="7" y2="7" {}
    };
    [
        LegendEntry::new(robot, "robot; the line is its heading"),
        LegendEntry::circle("key-node", 5.0, "key node, the target of the local planner"),
        LegendEntry::new(goal_mark([14.0, 7.0]), "goal"),
    ]
}
