//! A picture with its title, legend and caption, and the table behind it.

use maud::{Markup, html};

use super::number::{NONE, coordinate};
use crate::bench::csv_line;

/// Rows that a table shows of a long run.
const TABLE_ROWS: usize = 50;

/// What stands around a picture.
pub(super) struct Figure<'a> {
    pub(super) title: &'a str,
    pub(super) picture: Markup,
    /// Entries made by [`key`].
    pub(super) legend: Vec<Markup>,
    pub(super) caption: String,
    pub(super) table: Table<'a>,
}

/// Numbers as text, with their units in the heads of the columns.
pub(super) struct Table<'a> {
    pub(super) title: String,
    pub(super) heads: &'a [&'a str],
    pub(super) rows: Vec<Vec<String>>,
}

impl Figure<'_> {
    pub(super) fn markup(&self) -> Markup {
        html! {
            figure {
                h3 { (self.title) }
                (self.picture)
                @if !self.legend.is_empty() {
                    ul class="legend" { @for entry in &self.legend { li { (entry) } } }
                }
                figcaption { (self.caption) }
                details { summary { "Table: " (self.table.title) } (self.table.markup()) }
            }
        }
    }
}

impl Table<'_> {
    /// The table as a CSV file; what it has no number for is left empty.
    pub(super) fn csv(&self) -> String {
        let filled = |cell: &String| {
            if cell == NONE {
                String::new()
            } else {
                cell.clone()
            }
        };
        let lines = self.rows.iter().map(|row| csv_line(row.iter().map(filled)));
        csv_line(self.heads) + &lines.collect::<String>()
    }

    pub(super) fn markup(&self) -> Markup {
        html! {
            div class="scroll" tabindex="0" role="region" aria-label=(self.title) {
                table {
                    thead { tr { @for head in self.heads { th scope="col" { (head) } } } }
                    tbody { @for row in &self.rows { tr { @for cell in row { td { (cell) } } } } }
                }
            }
        }
    }
}

/// The files of a chart by their endings, to be taken along.
pub(super) fn files_beside(name: &str, endings: &[&str]) -> Markup {
    let files: Vec<String> = endings
        .iter()
        .map(|ending| format!("{name}.{ending}"))
        .collect();
    linked_files(&files)
}

/// Files beside a page, to be taken along.
pub(super) fn linked_files(files: &[String]) -> Markup {
    html! {
        p class="files" {
            "Beside this page: "
            @for (index, file) in files.iter().enumerate() {
                @if index > 0 { ", " }
                a href=(file) { (file) }
            }
        }
    }
}

/// A legend entry: a mark as the picture has it, drawn in a box of 28 by 14 units, and its meaning.
pub(super) fn key(mark: &Markup, meaning: &str) -> Markup {
    html! {
        svg class="key" viewBox="0 0 28 14" role="presentation" aria-hidden="true" { (mark) }
        span { (meaning) }
    }
}

/// The key of a line of this class.
pub(super) fn line_key(class: &str, meaning: &str) -> Markup {
    key(&line_mark(class), meaning)
}

/// The key of an area of this class.
pub(super) fn area_key(class: &str, meaning: &str) -> Markup {
    key(&area_mark(class), meaning)
}

/// A piece of a line of this class, to explain it by, in a box of 28 by 14 units.
pub(super) fn line_mark(class: &str) -> Markup {
    html! { line class=(class) x1="1" x2="27" y1="7" y2="7" {} }
}

/// A piece of an area of this class, to explain it by, in a box of 28 by 14 units.
pub(super) fn area_mark(class: &str) -> Markup {
    html! { rect class=(class) x="2" y="2" width="24" height="10" {} }
}

/// Height of a line of a drawn legend.
const LEGEND_LINE: f64 = 18.0;

/// A legend as part of a picture, from a place on downwards, in columns that share a width: marks, each in a box of
/// 28 by 14 units, and their meanings.
pub(super) fn drawn_legend(
    keys: &[(Markup, String)],
    [left, top]: [f64; 2],
    width: f64,
    columns: usize,
) -> Markup {
    html! {
        @for (index, (mark, meaning)) in keys.iter().enumerate() {
            @let x = left + width / columns as f64 * (index % columns) as f64;
            @let y = top + LEGEND_LINE * (index / columns) as f64;
            g transform=(format!("translate({} {})", coordinate(x), coordinate(y))) {
                (mark)
                text x="36" y="7" dy=".35em" { (meaning) }
            }
        }
    }
}

/// Height of such a legend of so many entries.
pub(super) fn legend_height(keys: usize, columns: usize) -> f64 {
    LEGEND_LINE * keys.div_ceil(columns) as f64
}

/// A sentence in place of a picture that has nothing to show.
pub(super) fn nothing_to_show(title: &str, reason: &str) -> Markup {
    html! { figure { h3 { (title) } p class="nothing" { (reason) } } }
}

impl<'a> Table<'a> {
    /// A table of a run, of all ticks or of one in so many, which the title then says.
    pub(super) fn of_ticks<T>(
        title: &str,
        heads: &'a [&'a str],
        ticks: &[T],
        row: impl Fn(usize, &T) -> Vec<String>,
    ) -> Self {
        let stride = ticks.len().div_ceil(TABLE_ROWS).max(1);
        let title = if stride == 1 {
            title.to_owned()
        } else {
            format!("{title}, one tick in {stride}")
        };
        let rows = ticks
            .iter()
            .enumerate()
            .step_by(stride)
            .map(|(index, tick)| row(index, tick))
            .collect();
        Self { title, heads, rows }
    }
}
