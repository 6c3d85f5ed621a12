//! What is lost with few samples: regret against sampling density.

use maud::{Markup, html};

use super::axis::Axis;
use super::curves::{Curve, Far, Plot, far_mark};
use super::figure::{Figure, Table, nothing_to_show};
use super::number::{fixed, significant};
use super::panel::{Panel, chart};
use super::samples_axis::SAMPLES;
use super::sampling_shape::SamplingShape;
use crate::bench::QualityRow;

const TITLE: &str = "Sampling density against the quality of the command";
const HEIGHT: f64 = 360.0;

/// Regret is drawn down to this, percent: less is not seen, and a logarithmic scale has no zero.
const LEAST_PERCENT: f64 = 0.01;

/// Samplings of one window and shape, in order of density.
struct Series<'a> {
    window_s: f64,
    shape: SamplingShape,
    rows: Vec<&'a QualityRow>,
}

pub(super) fn figure(rows: &[QualityRow], samples: Axis) -> Markup {
    let Some(plot) = plot(rows, samples) else {
        return nothing_to_show(TITLE, "No commands were compared.");
    };
    Figure {
        title: TITLE,
        picture: chart(plot.height, &plot.alternative, &plot.content),
        legend: plot.legend(),
        caption: caption(rows),
        table: table(rows),
    }
    .markup()
}

/// The panel with all windows and shapes; none where no row can be shown.
pub(super) fn plot(rows: &[QualityRow], samples: Axis) -> Option<Plot> {
    let series = series(rows);
    let usable = || series.iter().flat_map(|series| &series.rows);
    usable().next()?;
    let worst = usable()
        .filter_map(|row| percent(row.regret_max))
        .fold(LEAST_PERCENT, f64::max);
    let panel = Panel::across(
        32.0,
        286.0,
        samples,
        Axis::logarithmic(LEAST_PERCENT, worst),
    );
    let curves: Vec<Curve> = series
        .iter()
        .enumerate()
        .map(|(index, series)| series.curve(index))
        .collect();
    let content = html! {
        (panel.axes(Some(SAMPLES), "Regret, % of what choosing gains (logarithmic)"))
        @for curve in &curves { (curve.draw(&panel)) }
    };
    let mut keys: Vec<(Markup, String)> = curves
        .into_iter()
        .map(|curve| (curve.piece(), curve.name))
        .collect();
    keys.push((far_mark(), "the worst of all decisions".to_owned()));
    Some(Plot {
        title: TITLE,
        style: "",
        content,
        height: HEIGHT,
        keys,
        alternative: alternative(&series),
    })
}

/// A share as a percentage that the panel can show; none where there is no finite one.
fn percent(share: Option<f64>) -> Option<f64> {
    share
        .filter(|share| share.is_finite())
        .map(|share| (share * 100.0).max(LEAST_PERCENT))
}

/// Windows and shapes in the order in which they first occur. Rows without a figure are left out.
fn series(rows: &[QualityRow]) -> Vec<Series<'_>> {
    let mut all: Vec<Series> = Vec::new();
    let shown = |row: &&QualityRow| {
        row.samples > 0
            && row.window_s.is_finite()
            && percent(row.regret_p50).is_some()
            && percent(row.regret_max).is_some()
    };
    for row in rows.iter().filter(shown) {
        let window_s = row.window_s;
        let Some(shape) = SamplingShape::of(row.vx_samples, row.vtheta_samples) else {
            continue;
        };
        let same = |series: &&mut Series| series.window_s == window_s && series.shape == shape;
        if let Some(series) = all.iter_mut().find(same) {
            series.rows.push(row);
        } else {
            let rows = vec![row];
            all.push(Series {
                window_s,
                shape,
                rows,
            });
        }
    }
    for series in &mut all {
        series.rows.sort_by_key(|row| row.samples);
    }
    all
}

impl Series<'_> {
    fn name(&self) -> String {
        format!("window {} s, {}", self.window_s, self.shape)
    }

    fn curve(&self, index: usize) -> Curve {
        let point = |row: &&QualityRow| {
            let (median, worst) = (percent(row.regret_p50)?, percent(row.regret_max)?);
            Some((row.samples as f64, median, worst))
        };
        Curve {
            name: self.name(),
            index,
            points: self.rows.iter().filter_map(point).collect(),
            far: Far::Line,
        }
    }
}

fn alternative(series: &[Series]) -> String {
    let words: Vec<String> = series
        .iter()
        .filter_map(|series| {
            let said = |row: &&QualityRow| {
                Some(format!(
                    "{} % with {} samples",
                    significant(percent(row.regret_p50)?),
                    row.samples
                ))
            };
            let (first, last) = (said(series.rows.first()?)?, said(series.rows.last()?)?);
            Some(format!(" {}: {first}, {last}.", series.name()))
        })
        .collect();
    format!(
        "Median regret against the number of samples.{}",
        words.concat()
    )
}

fn caption(rows: &[QualityRow]) -> String {
    let (decisions, densest) = rows
        .first()
        .map_or((0, 0), |row| (row.decisions, row.densest));
    format!(
        "Lines are medians of {decisions} decisions, dashed ones the worst. 0 % is as good as the \
         choice among {densest} samples, 100 % no better than a sample picked blindly; {LEAST_PERCENT} % also stands \
         for less. v : omega is forward speeds to turn rates."
    )
}

fn table(rows: &[QualityRow]) -> Table<'static> {
    let number = |value: Option<f64>, decimals| fixed(value.unwrap_or(f64::NAN), decimals);
    let share = |value: Option<f64>| number(value.map(|share| share * 100.0), 2);
    Table {
        title: "density against quality".to_owned(),
        heads: &[
            "window, s",
            "samples",
            "forward speeds",
            "turn rates",
            "decisions",
            "without a command",
            "regret, median, %",
            "regret, worst, %",
            "v off, median, m/s",
            "v off, worst, m/s",
            "omega off, median, rad/s",
            "omega off, worst, rad/s",
        ],
        rows: rows
            .iter()
            .map(|row| {
                vec![
                    significant(row.window_s),
                    row.samples.to_string(),
                    row.vx_samples.to_string(),
                    row.vtheta_samples.to_string(),
                    row.decisions.to_string(),
                    row.without_command.to_string(),
                    share(row.regret_p50),
                    share(row.regret_max),
                    number(row.v_off_p50_m_s, 4),
                    number(row.v_off_max_m_s, 4),
                    number(row.omega_off_p50_rad_s, 4),
                    number(row.omega_off_max_rad_s, 4),
                ]
            })
            .collect(),
    }
}
