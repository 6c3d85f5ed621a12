//! What AMD's compiler makes of the shaders must not get worse than the committed table.
//!
//! A change that is meant to cost something writes the table again:
//!
//! ```text
//! INBYE_WRITE_SHADER_STATISTICS=1 cargo test --release --test conditional statistics_are
//! ```

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use libtest_mimic::{Completion, Failed, Trial};

use crate::support::machine_code::largest_loop_cycles;
use crate::support::radv::{self, Report, Statistics};

/// One model of each generation since 2018, and one of a hand-held computer.
const FAMILIES: [&str; 5] = ["vega20", "navi10", "navi21", "vangogh", "gfx1100"];

const WRITE: &str = "INBYE_WRITE_SHADER_STATISTICS";

fn table_path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/records/shader-statistics.csv")
}

pub fn trials() -> Vec<Trial> {
    vec![
        Trial::ignorable_test("statistics_are_no_worse_than_recorded", no_worse),
        Trial::test("worse_statistics_are_found", worse_is_found),
        Trial::test("cycles_of_a_loop_are_counted", loop_is_counted),
    ]
}

fn no_worse() -> Result<Completion, Failed> {
    let Some(driver_file) = radv::driver_file() else {
        return Ok(Completion::ignored_with("no RADV here: Debian's mesa-vulkan-drivers has it"));
    };
    let reports: Vec<Report> = FAMILIES
        .iter()
        .map(|family| radv::statistics(&driver_file, family))
        .collect::<Result<_, _>>()
        .map_err(|error| error.to_string())?;
    let driver = &reports[0].driver;
    let found: Vec<Statistics> =
        reports.iter().flat_map(|report| report.pipelines.clone()).collect();
    if let Some(one) = found.iter().find(|one| one.spilled > 0) {
        return Err(format!("{} spills registers on {}", one.pipeline, one.family).into());
    }
    if std::env::var_os(WRITE).is_some() {
        std::fs::write(table_path(), write_table(driver, &found)?)?;
        return Ok(Completion::Completed);
    }
    let text = std::fs::read_to_string(table_path())?;
    let (recorded_driver, recorded) = read_table(&text)?;
    if recorded_driver != driver {
        return Ok(Completion::ignored_with(format!(
            "the table is of {recorded_driver}, here is {driver}"
        )));
    }
    let worse = worse(&recorded, &found);
    if worse.is_empty() { Ok(Completion::Completed) } else { Err(worse.into()) }
}

fn write_table(driver: &str, rows: &[Statistics]) -> Result<String, Failed> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    let rows = String::from_utf8(writer.into_inner()?)?;
    Ok(format!("# {driver}\n{rows}"))
}

fn read_table(text: &str) -> Result<(&str, Vec<Statistics>), Failed> {
    let (first, rows) = text.split_once('\n').ok_or("the table has no lines")?;
    let driver = first.strip_prefix("# ").ok_or("the first line must name the driver")?;
    let rows =
        csv::Reader::from_reader(rows.as_bytes()).into_deserialize().collect::<Result<_, _>>()?;
    Ok((driver, rows))
}

/// One line for each number that is worse than the recorded one, and for each pipeline that the table lacks.
fn worse(recorded: &[Statistics], found: &[Statistics]) -> String {
    let mut lines = String::new();
    for now in found {
        let of_same =
            |one: &&Statistics| (&one.family, &one.pipeline) == (&now.family, &now.pipeline);
        let Some(before) = recorded.iter().find(of_same) else {
            let _ = writeln!(lines, "{} on {} is not in the table", now.pipeline, now.family);
            continue;
        };
        let numbers = [
            ("VGPRs", before.vgprs, now.vgprs),
            ("spilled registers", before.spilled, now.spilled),
            ("bytes of workgroup memory", before.workgroup_bytes, now.workgroup_bytes),
            ("instructions", before.instructions, now.instructions),
            ("cycles of latency", before.latency, now.latency),
            ("cycles of inverse throughput", before.inverse_throughput, now.inverse_throughput),
            ("cycles of the largest loop", before.largest_loop_cycles, now.largest_loop_cycles),
        ];
        for (name, before, after) in numbers {
            if after > before {
                let _ = writeln!(
                    lines,
                    "{} on {}: {after} {name}, recorded are {before}",
                    now.pipeline, now.family
                );
            }
        }
        if now.waves_per_simd < before.waves_per_simd {
            let _ = writeln!(
                lines,
                "{} on {}: {} waves per SIMD, recorded are {}",
                now.pipeline, now.family, now.waves_per_simd, before.waves_per_simd
            );
        }
    }
    if !lines.is_empty() {
        let _ = write!(lines, "if this is meant, write the table again with {WRITE}=1");
    }
    lines
}

fn worse_is_found() -> Result<(), Failed> {
    let text = std::fs::read_to_string(table_path())?;
    let (_, recorded) = read_table(&text)?;
    if !worse(&recorded, &recorded).is_empty() {
        return Err("equal numbers are worse".into());
    }
    let changes: [fn(&mut Statistics); 4] = [
        |row| row.vgprs += 1,
        |row| row.waves_per_simd -= 1,
        |row| row.largest_loop_cycles += 1,
        |row| row.pipeline.push('2'),
    ];
    for change in changes {
        let mut changed = recorded.clone();
        change(&mut changed[0]);
        if worse(&recorded, &changed).is_empty() {
            return Err(format!("not worse: {:?}", changed[0]).into());
        }
    }
    Ok(())
}

fn loop_is_counted() -> Result<(), Failed> {
    let code = "BB0:\n v_add_u32 v0, v1, v2\nBB1:\n v_mul_lo_u32 v0, v0, v1\n v_min_i32 v0, v0, v1\n \
        s_cbranch_scc1 BB2\nBB2:\n s_branch BB1\n v_add_u32 v0, v1, v2\n s_endpgm";
    match largest_loop_cycles(code) {
        5 => Ok(()),
        other => Err(format!("{other} cycles").into()),
    }
}
