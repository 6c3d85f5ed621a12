//! One run of an experiment for inspection: drawn, and recorded tick by tick.

use std::fs::File;
use std::path::Path;
use std::str::FromStr;

use anyhow::bail;
use inbye::map::OccupancyGrid;
use inbye::report::{DriveView, drive_svg};
use inbye::runtime::MissionResult;
use inbye::sim::Simulation;

use super::arguments::whole;
use super::drive::one_line;
use super::output_file::Output;
use super::{output, recording};

/// Selects a run.
#[derive(Clone, Copy, Debug)]
pub struct OneRun {
    /// The world's number.
    pub world: u32,
    /// Seed of the noise.
    pub seed: u64,
}

impl FromStr for OneRun {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (world, seed) = text.split_once(',').ok_or("write WORLD,SEED, such as 12,0")?;
        Ok(Self { world: whole(0, u64::from(u32::MAX))(world)?, seed: whole(0, u64::MAX)(seed)? })
    }
}

/// The requested output files of a run.
pub struct Files<'a> {
    svg: Option<Output<'a>>,
    ticks: Option<File>,
}

impl<'a> Files<'a> {
    /// Creates the files before the run, so that a wrong name fails early.
    pub fn create(svg: Option<&'a Path>, ticks: Option<&Path>) -> anyhow::Result<Self> {
        Ok(Self {
            svg: Output::create("--svg", svg, &["svg"])?,
            ticks: ticks.map(output::create_record).transpose()?,
        })
    }

    /// Draws the run on the true map and writes its ticks.
    pub fn write(
        self,
        title: &str,
        simulation: &Simulation,
        result: &MissionResult,
    ) -> anyhow::Result<()> {
        if let Some(svg) = self.svg {
            let solid = |&blocked: &bool| if blocked { 100 } else { 0 };
            let mission = &simulation.mission;
            let truth = simulation.truth.as_ref().map(|truth| {
                OccupancyGrid::new(*truth.frame(), truth.cells().iter().map(solid).collect())
            });
            svg.write(drive_svg(&DriveView {
                title,
                caption: &one_line(result),
                map: truth.as_ref().unwrap_or(&mission.map),
                start: mission.start,
                goal: mission.goal.position,
                trace: &result.trace,
            }))?;
        }
        if let Some(file) = self.ticks {
            let recorded = recording::lines(file, result);
            recorded.stopped.map_or(Ok(()), |why| bail!("--record: {why}"))?;
        }
        Ok(())
    }
}
