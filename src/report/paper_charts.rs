//! The charts of the paper's experiments, table by table: on the page, and as pictures of their own.

use maud::{Markup, html};

use super::curves::Plot;
use super::panel::chart;
use super::{paper_bars, paper_drives_chart};
use crate::experiment::paper_drives::PaperTable as Table;

/// What their marks need beyond what every chart has.
pub(super) const STYLE: &str = include_str!("paper_charts.css");

/// Table whose paths are drawn as bars.
const BARS: &str = "figure_5";

/// The charts of a table; none of one that is shown by maps.
pub(super) fn plots(table: &Table) -> Vec<Plot> {
    match table {
        Table::Paths(table) if table.name == BARS => paper_bars::angles(&table.rows),
        Table::Paths(_) => Vec::new(),
        Table::Ablation(table) => vec![paper_bars::stages(&table.rows)],
        Table::Drives(table) => paper_drives_chart::plots(table),
    }
}

/// Charts as figures of a page, beside one another.
pub(super) fn figures(plots: &[Plot]) -> Markup {
    html! {
        @if !plots.is_empty() {
            div class="charts" {
                @for plot in plots {
                    figure {
                        h3 { (plot.title) }
                        (chart(plot.height, &plot.alternative, &plot.content))
                        @if !plot.keys.is_empty() { ul class="legend" { @for entry in plot.legend() { li { (entry) } } } }
                    }
                }
            }
        }
    }
}
