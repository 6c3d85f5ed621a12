//! Figures and tables of a page.

use maud::{Markup, Render, html};
use serde_json::Value;

use super::number::NONE;
use super::page::ReportFile;
use super::svg::{LegendEntry, legend_list};
use crate::bench::columns::{aligned, csv_line, named_columns};
use crate::bench::{self, Columns};

/// Most rows of a table of ticks.
const MAX_TICK_ROWS: usize = 50;

/// A column of a table: its heading with the unit, and the text of a row.
pub(super) type Column<R> = (&'static str, fn(&R) -> String);

/// A table as text.
#[derive(Default)]
pub(super) struct Table {
    pub(super) title: String,
    pub(super) headers: Vec<String>,
    /// Headers of the columns with texts, which are aligned left in [`Table::lines`].
    pub(super) text_columns: &'static [&'static str],
    pub(super) rows: Vec<Vec<String>>,
}

impl Table {
    /// A table of rows.
    pub(super) fn new<'r, R: 'r>(
        title: impl Into<String>,
        rows: impl IntoIterator<Item = &'r R>,
        columns: &[Column<R>],
    ) -> Self {
        let texts = |row: &R| columns.iter().map(|(_, text)| text(row)).collect();
        Self {
            title: title.into(),
            headers: columns.iter().map(|(header, _)| (*header).to_owned()).collect(),
            rows: rows.into_iter().map(texts).collect(),
            ..Self::default()
        }
    }

    /// A table of some declared columns of rows, whose names are separated by spaces.
    pub(super) fn of_columns<R: Columns>(title: &str, rows: &[R], names: &str) -> Self {
        let columns = named_columns::<R>(names);
        let texts = |row: &R| {
            // A row of numbers and texts always serialises.
            let record = serde_json::to_value(row).unwrap_or_default();
            let text = |column: &&bench::Column| match &record[column.name] {
                Value::Null => NONE.to_owned(),
                value => column.text(value),
            };
            columns.iter().map(text).collect()
        };
        Self {
            title: title.to_owned(),
            headers: columns.iter().map(|column| column.heading()).collect(),
            rows: rows.iter().map(texts).collect(),
            ..Self::default()
        }
    }

    /// A table of the ticks of a run. A long run shows one tick in several, and its title says so.
    pub(super) fn of_ticks<R>(title: &str, ticks: &[R], columns: &[Column<R>]) -> Self {
        let stride = ticks.len().div_ceil(MAX_TICK_ROWS).max(1);
        let title =
            if stride == 1 { title.to_owned() } else { format!("{title}, one tick in {stride}") };
        Self::new(title, ticks.iter().step_by(stride), columns)
    }

    /// The table as a CSV file. Missing numbers are empty fields.
    pub(super) fn csv(&self) -> String {
        let field = |cell: &String| {
            if cell == NONE { String::new() } else { cell.clone() }
        };
        let lines = self.rows.iter().map(|row| csv_line(row.iter().map(field)));
        csv_line(&self.headers) + &lines.collect::<String>()
    }

    /// The table as lines of text: the title, if it has one, the headers and the rows.
    pub(super) fn lines(&self) -> Vec<String> {
        let lines = [std::slice::from_ref(&self.headers), &self.rows[..]].concat();
        let is_text = |place: usize| self.text_columns.contains(&&*self.headers[place]);
        let title = (!self.title.is_empty()).then(|| self.title.clone());
        title.into_iter().chain(aligned(&lines, is_text)).collect()
    }

    pub(super) fn markup(&self) -> Markup {
        let rows = html! { @for row in &self.rows { tr { @for cell in row { td { (cell) } } } } };
        scrolling_table(&self.title, None, &self.headers, &rows)
    }
}

/// A table that scrolls where the page is narrow. Screen readers name it by its title.
pub(super) fn scrolling_table(
    title: &str,
    class: Option<&str>,
    headers: impl IntoIterator<Item: Render>,
    rows: &Markup,
) -> Markup {
    html! {
        div class="scroll" tabindex="0" role="region" aria-label=(title) {
            table class=[class] {
                thead { tr { @for header in headers { th scope="col" { (header) } } } }
                tbody { (rows) }
            }
        }
    }
}

/// A picture with its title, legend and caption, and the table of its data.
pub(super) fn figure(
    title: &str,
    picture: &Markup,
    legend: &[LegendEntry],
    caption: &str,
    table: &Table,
) -> Markup {
    html! {
        figure {
            h3 { (title) }
            (picture)
            (legend_list(legend))
            figcaption { (caption) }
            details { summary { "Table: " (table.title) } (table.markup()) }
        }
    }
}

/// Links to the files next to a page.
pub(super) fn file_links(files: &[ReportFile]) -> Markup {
    html! {
        p class="files" {
            "Files: "
            @for (index, file) in files.iter().enumerate() {
                @if index > 0 { ", " }
                a href=(file.name) { (file.name) }
            }
        }
    }
}
