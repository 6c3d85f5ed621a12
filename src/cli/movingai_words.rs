//! What `inbye bench movingai` tells people.

use inbye::bench::movingai::{AlgorithmRow, MapRows};

/// Heads the rows of [`algorithm`].
const HEADER: &str = "  algorithm                  solved  longer  illegal  median us    p95 us     max us  expanded  \
    length mean   worst";

/// A table for each map, one for all together where there are several, and what was wrong.
pub fn tables(maps: &[MapRows], totals: &[AlgorithmRow]) -> Vec<String> {
    let mut lines = Vec::new();
    for map in maps {
        table(&mut lines, &map.map, map.scenarios, &map.algorithms);
    }
    if maps.len() > 1 {
        let scenarios = maps.iter().map(|map| map.scenarios).sum();
        let title = format!("all {} maps", maps.len());
        table(&mut lines, &title, scenarios, totals);
    }
    lines.extend(totals.iter().filter_map(fault));
    lines
}

fn table(lines: &mut Vec<String>, title: &str, scenarios: usize, rows: &[AlgorithmRow]) {
    lines.push(format!("{title}: {scenarios} scenarios"));
    lines.push(HEADER.to_owned());
    lines.extend(rows.iter().map(algorithm));
}

fn algorithm(row: &AlgorithmRow) -> String {
    let ratio = |ratio: Option<f64>| ratio.map_or_else(|| "-".to_owned(), |it| format!("{it:.5}"));
    format!(
        "  {:18} {:>14} {:7} {:8} {:10.1} {:9.1} {:10.1} {:9.0} {:>12} {:>7}",
        row.name,
        format!("{}/{}", row.solved, row.total),
        row.suboptimal,
        row.illegal,
        row.median_us,
        row.p95_us,
        row.max_us,
        row.expanded,
        ratio(row.mean_length_ratio),
        ratio(row.worst_length_ratio),
    )
}

fn fault(row: &AlgorithmRow) -> Option<String> {
    let first = row.first_fault.as_ref()?;
    Some(format!("WRONG: {}, first at {first}", row.name))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(first_fault: Option<&str>) -> AlgorithmRow {
        AlgorithmRow {
            name: "A* octile".to_owned(),
            exact: true,
            solved: 3,
            total: 4,
            suboptimal: 0,
            illegal: 1,
            median_us: 12.34,
            p95_us: 56.0,
            max_us: 78.9,
            expanded: 90.4,
            mean_length_ratio: Some(1.0),
            worst_length_ratio: None,
            first_fault: first_fault.map(str::to_owned),
        }
    }

    #[test]
    fn a_table_stands_under_its_header_and_what_is_wrong_below() {
        let map = |fault| MapRows {
            map: "a.map".to_owned(),
            scenarios: 4,
            algorithms: vec![row(fault)],
        };
        let fault = Some("a.map, scenario of line 2: no path was found");
        let lines = tables(&[map(fault)], &[row(fault)]);
        assert_eq!(lines.len(), 4, "{lines:#?}");
        assert_eq!(lines[0], "a.map: 4 scenarios");
        assert_eq!(lines[1].len(), lines[2].len(), "{lines:#?}");
        assert!(lines[2].ends_with("1.00000       -"), "{lines:#?}");
        assert!(lines[3].starts_with("WRONG: A* octile, first at a.map, scenario of line 2"));
        let lines = tables(&[map(None), map(None)], &[row(None)]);
        assert_eq!(
            (lines.len(), lines[6].as_str()),
            (9, "all 2 maps: 8 scenarios")
        );
    }
}
