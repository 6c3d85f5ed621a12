//! Real logs: each is read to its end, and the localizer follows the one with the best poses.
//!
//! The logs are expected next to the repository; without them the trials are ignored.

use std::path::{Path, PathBuf};

use inbye::bench::localize_log;
use inbye::lidar_log::LidarLog;
use inbye::localization::LocalizationSettings;
use inbye::map::UnknownPolicy;
use inbye::mapping::{log_scans, render};
use libtest_mimic::{Completion, Failed, Trial};

const LOGS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/lidar_logs");

/// Files and their numbers of scans.
const FILES: [(&str, usize); 5] = [
    ("csail.corrected.gfs", 406),
    ("csail.corrected.log", 406),
    ("exp1.dat", 756),
    ("exp3.dat", 525),
    ("intel.gfs.log", 910),
];

pub fn trials() -> Vec<Trial> {
    let mut trials: Vec<Trial> = FILES
        .iter()
        .map(|&(file, scans)| {
            Trial::ignorable_test(format!("{file} is read to its end"), move || {
                with_log(file, |log| {
                    if log.scans() == scans {
                        Ok(())
                    } else {
                        Err(format!("{} scans instead of {scans}", log.scans()).into())
                    }
                })
            })
        })
        .collect();
    trials.push(Trial::ignorable_test("the localizer follows a real log", || {
        with_log("intel.gfs.log", |log| follows(&log))
    }));
    trials
}

fn with_log(
    file: &str,
    trial: impl FnOnce(LidarLog) -> Result<(), Failed>,
) -> Result<Completion, Failed> {
    let path: PathBuf = Path::new(LOGS).join(file);
    if !path.exists() {
        return Ok(Completion::ignored_with("the development data are missing"));
    }
    trial(LidarLog::read(&path)?)?;
    Ok(Completion::Completed)
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
