//! Real logs: each is read to its end, and the localizer follows the one with the best poses.
//!
//! The logs are expected next to the repository; without them the trials are ignored.

use std::path::Path;

use inbye::bench::localize_log;
use inbye::lidar_log::LidarLog;
use inbye::localization::LocalizationSettings;
use inbye::map::UnknownPolicy;
use inbye::mapping::{log_scans, render};
use libtest_mimic::{Failed, Trial};

use crate::support::trials::with_data;

/// The folder of the logs, in the development data.
const LOGS: &str = "lidar_logs";

/// Files and their numbers of scans.
const FILES: [(&str, usize); 5] = [
    ("csail.corrected.gfs", 406),
    ("csail.corrected.log", 406),
    ("exp1.dat", 756),
    ("exp3.dat", 525),
    ("intel.gfs.log", 910),
];

pub fn trials() -> Vec<Trial> {
    let is_whole = |(file, scans): (&'static str, usize)| {
        with_log(format!("{file} is read to its end"), file, move |log| match log.scans() {
            found if found == scans => Ok(()),
            found => Err(format!("{found} scans instead of {scans}").into()),
        })
    };
    let mut trials: Vec<Trial> = FILES.map(is_whole).into();
    trials.push(with_log("the localizer follows a real log", "intel.gfs.log", follows));
    trials
}

fn with_log(
    name: impl Into<String>,
    file: &str,
    test: impl FnOnce(&LidarLog) -> Result<(), Failed> + Send + 'static,
) -> Trial {
    with_data(name, Path::new(LOGS).join(file), |path| test(&LidarLog::read(path)?))
}

/// The bounds are far from what is measured, so that they hold for other builds of the localizer as well.
fn follows(log: &LidarLog) -> Result<(), Failed> {
    let scans = log_scans(log);
    let map = render(scans.iter().filter_map(|scan| Some((scan.corrected?, &scan.scan))))?;
    let obstacles = map.obstacles(UnknownPolicy::Blocked);
    let start = log.start().ok_or("it has scans")?;
    let settings = LocalizationSettings::default();
    let result = localize_log(log, &obstacles, &start, settings, None, &mut || 0.0)?;
    let error = result.absolute.ok_or("it has corrected poses")?.position_m;
    if result.lost_scans == 0 && error.mean < 0.1 && error.max < 1.0 {
        Ok(())
    } else {
        Err(format!("lost after {} scans, errors {error:?}", result.lost_scans).into())
    }
}
