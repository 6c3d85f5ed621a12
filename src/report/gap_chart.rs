//! The gap between the robot and the nearest solid thing over time.

use maud::{Markup, html};

use super::MissionView;
use super::axis::Axis;
use super::figure::{Figure, Table, key, line_key, nothing_to_show};
use super::motion_chart::time_axis;
use super::number::{coordinate, fixed};
use super::panel::{Panel, chart};
use crate::runtime::TraceRow;

const TITLE: &str = "Gap to the nearest solid thing";
const HEIGHT: f64 = 340.0;

/// Least range of the axis above contact, metres.
const LEAST_RANGE_M: f64 = 0.1;

pub(super) fn figure(mission: &MissionView) -> Markup {
    let rows = &mission.trace.rows;
    let Some(closest) = closest(rows) else {
        return nothing_to_show(
            TITLE,
            "At no tick was anything solid in reach of the robot.",
        );
    };
    let widest = gaps(rows)
        .map(|row| row.gap_m)
        .fold(LEAST_RANGE_M, f64::max);
    let panel = Panel::across(
        32.0,
        266.0,
        time_axis(rows),
        Axis::rounded(closest.gap_m.min(0.0), widest),
    );
    let contact = panel.y_at(0.0);
    let (x, y) = (panel.x_at(closest.time_s), panel.y_at(closest.gap_m));
    let picture = html! {
        rect class="contact" x=(coordinate(panel.left)) y=(coordinate(contact))
            width=(coordinate(panel.width)) height=(coordinate(panel.bottom() - contact)) {}
        (panel.axes(Some("Time, s"), "Gap, m"))
        (panel.line("gap", rows.iter().map(|row| (row.time_s, row.gap_m))))
        line class="limit" x1=(coordinate(panel.left)) x2=(coordinate(panel.right()))
            y1=(coordinate(contact)) y2=(coordinate(contact)) {}
        circle class="closest" cx=(coordinate(x)) cy=(coordinate(y)) r="5" {}
    };
    let out_of_reach = rows.len() - gaps(rows).count();
    let caption = if out_of_reach == 0 {
        "At or below zero the robot touches something.".to_owned()
    } else {
        format!(
            "At or below zero the robot touches something. The line breaks at the {out_of_reach} ticks with nothing \
             in reach."
        )
    };
    Figure {
        title: TITLE,
        picture: chart(HEIGHT, &alternative(closest, rows.len()), &picture),
        legend: vec![
            line_key("gap", "gap, from the edge of the footprint"),
            line_key("limit", "contact"),
            key(
                &html! { circle class="closest" cx="14" cy="7" r="5" {} },
                &format!(
                    "smallest, {} m at {} s",
                    fixed(closest.gap_m, 3),
                    fixed(closest.time_s, 1)
                ),
            ),
        ],
        caption,
        table: Table::of_ticks("gap", &["time, s", "gap, m"], rows, |_, row| {
            vec![fixed(row.time_s, 2), fixed(row.gap_m, 3)]
        }),
    }
    .markup()
}

/// The rows where something solid was in reach.
fn gaps(rows: &[TraceRow]) -> impl Iterator<Item = &TraceRow> {
    rows.iter()
        .filter(|row| row.gap_m.is_finite() && row.time_s.is_finite())
}

/// The tick of the smallest gap, the first of several.
pub(super) fn closest(rows: &[TraceRow]) -> Option<&TraceRow> {
    gaps(rows).min_by(|a, b| a.gap_m.total_cmp(&b.gap_m))
}

fn alternative(closest: &TraceRow, ticks: usize) -> String {
    format!(
        "Gap between the robot and the nearest solid thing over {ticks} ticks. It is smallest at {} seconds, with {} \
         metres.",
        fixed(closest.time_s, 1),
        fixed(closest.gap_m, 3)
    )
}
