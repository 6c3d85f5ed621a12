//! The page and the animation of a drive, from the drive itself or from its recording.

use std::path::PathBuf;

#[cfg(feature = "png")]
use anyhow::Context;
use clap::Args;
use inbye::report::{MissionView, PlaybackRecorder};

use super::drive_text;
use super::files::{Output, ReportFolder, all_written};

/// The requested pictures.
#[derive(Debug, Args)]
pub struct PictureArguments {
    /// Write a report page into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Show the drive as an animation in this file, at most 160 frames.
    #[arg(long, value_name = "FILE.gif")]
    pub animation: Option<PathBuf>,
}

/// The page and the animation of a drive.
pub struct Pictures<'a> {
    report: ReportFolder<'a>,
    animation: Output<'a>,
    /// Whether any is requested.
    pub are_requested: bool,
}

impl<'a> Pictures<'a> {
    /// Opens the files. They are opened before the drive: a wrong name must not cost an hour of driving.
    pub fn create(arguments: &'a PictureArguments) -> anyhow::Result<Self> {
        let PictureArguments { report, animation } = arguments;
        anyhow::ensure!(cfg!(feature = "png") || animation.is_none(), WITHOUT_GIF);
        Ok(Self {
            are_requested: report.is_some() || animation.is_some(),
            report: ReportFolder::create(report.as_deref())?,
            animation: Output::create("--animation", animation.as_deref(), &["gif"])?,
        })
    }

    /// Writes the requested ones.
    pub fn write(
        self,
        intro: &str,
        view: MissionView<'_>,
        playback: &PlaybackRecorder,
    ) -> anyhow::Result<()> {
        let animated = if self.animation.is_requested() {
            gif(&view, playback).and_then(|bytes| self.animation.write(|| bytes))
        } else {
            Ok(())
        };
        all_written([animated, self.report.write_page(|| drive_text::page(intro, view))])
    }
}

const WITHOUT_GIF: &str = "--animation: this build, such as that of the Python wheel, has no feature `png`: use --report, a package, or a build with `--features png`";

#[cfg(feature = "png")]
fn gif(view: &MissionView<'_>, playback: &PlaybackRecorder) -> anyhow::Result<Vec<u8>> {
    inbye::report::gif_animation(view, playback).context("--animation")
}

#[cfg(not(feature = "png"))]
fn gif(_view: &MissionView<'_>, _playback: &PlaybackRecorder) -> anyhow::Result<Vec<u8>> {
    anyhow::bail!(WITHOUT_GIF)
}
