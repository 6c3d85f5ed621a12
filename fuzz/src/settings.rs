//! What the program is told: problems, settings, words.

use std::sync::OnceLock;

use inbye::base::{PlannedTrouble, Protocol, Trouble};
use inbye::local::{CpuEngine, Detail, Engine, Evaluation, Preference, Prepared};
use inbye::map::{LoadOptions, MapError, OccupancyGrid};
use inbye::sim::Config;

use super::one_line;
use super::program::base_file::BaseFile;
use super::program::{changes, config, problem_file};
use super::wire;

/// Problems above so many samples times steps are prepared and not evaluated: it would only take long.
const MOST_WORK: usize = 20_000;

/// A problem of `inbye evaluate`. One that is read is prepared or refused, and its answer is one of its samples.
pub fn problem_json(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    // No file is opened for a name that chance has written.
    let load = |name: &str, options: &LoadOptions| match name {
        "" => Err(MapError::NoRows),
        _ => OccupancyGrid::from_text("....\n.##.\n....\n", options.resolution_m),
    };
    let problem = match problem_file::parse(text, load) {
        Ok(problem) => problem,
        Err(error) => return one_line(&format!("{error:#}")),
    };
    let prepared = match Prepared::new(&problem) {
        Ok(prepared) => prepared,
        Err(error) => return one_line(&error),
    };
    assert!(!prepared.is_empty());
    assert_eq!(prepared.len(), problem.window.len());
    if prepared.len() * problem.steps as usize <= MOST_WORK {
        let evaluated = evaluate(&prepared);
        let counts = &evaluated.counts;
        let rejected = counts.collision + counts.cannot_stop + counts.outside;
        assert_eq!((counts.admissible + rejected) as usize, prepared.len());
        assert_eq!(evaluated.winner.is_some(), counts.admissible > 0);
        if let Some(winner) = evaluated.winner {
            let command = problem.window.twist(winner.index);
            let (v, omega) = (&problem.window.linear, &problem.window.angular);
            let (fastest, sharpest) = (v.largest(), omega.largest());
            assert!(command.linear.abs() <= fastest, "{command:?}");
            assert!(command.angular.abs() <= sharpest, "{command:?}");
        }
    }
}

fn evaluate(prepared: &Prepared) -> Evaluation {
    thread_local! {
        static ENGINE: std::cell::RefCell<CpuEngine> = CpuEngine::single_threaded().into();
    }
    let evaluated = ENGINE.with_borrow_mut(|engine| engine.evaluate(prepared, Detail::Samples));
    evaluated.expect("the CPU answers")
}

/// A configuration of `--config`. What is read is sound, and the same when it is written and read again; as changes of the
/// defaults the same text is the same configuration.
pub fn drive_config(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    let defaults = DEFAULTS.get_or_init(Config::default);
    let changed = changes::by_text(defaults, text);
    match config::parse(text, |config: &Config| Ok(config.validate()?)) {
        Err(error) => {
            one_line(&format!("{error:#}"));
            if let Err(error) = changed {
                one_line(&format!("{error:#}"));
            }
        }
        Ok(config) => {
            config.validate().expect("it was just checked");
            let written = toml::to_string(&config).expect("a configuration is a table");
            let again = config::parse(&written, |config: &Config| Ok(config.validate()?));
            assert_eq!(again.expect("what is written is sound"), config);
            assert_eq!(changed.expect("its changes are sound too"), config);
        }
    }
}

static DEFAULTS: OnceLock<Config> = OnceLock::new();

/// A file of `--base-config`. What is read is sound, the same when it is written and read again, and a base of such
/// settings is talked to in every protocol within its limits.
pub fn base_config(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    match config::parse(text, BaseFile::validate) {
        Err(error) => one_line(&format!("{error:#}")),
        Ok(file) => {
            let written = toml::to_string(&file).expect("settings are a table");
            let again = config::parse(&written, BaseFile::validate);
            assert_eq!(again.expect("what is written is sound"), file);
            wire::short(file.base);
        }
    }
}

/// Words of the command line: planned troubles, protocols, engines.
pub fn words(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    match text.parse::<PlannedTrouble>() {
        Err(error) => one_line(&error),
        Ok(planned) => {
            let PlannedTrouble {
                trouble,
                from_s,
                to_s,
            } = planned;
            assert!(Trouble::ALL.contains(&trouble));
            assert!(
                from_s.is_finite() && from_s >= 0.0 && to_s > from_s,
                "{planned:?}"
            );
            let written = if to_s.is_finite() {
                format!("{trouble}@{from_s}..{to_s}")
            } else {
                format!("{trouble}@{from_s}")
            };
            assert_eq!(written.parse(), Ok(planned), "{written}");
        }
    }
    match text.parse::<Protocol>() {
        Err(error) => one_line(&error),
        Ok(protocol) => assert_eq!(protocol.name(), text),
    }
    if let Err(error) = text.parse::<Preference>() {
        one_line(&error);
    }
}
