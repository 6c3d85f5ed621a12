//! Which engine decides fastest on this machine, by measurement.

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::BenchError;
use super::roadway::{Roadway, roadway_field};
use super::timing::Latencies;
use crate::local::{
    AdapterSelection, CpuEngines, DeviceCloser, Engine, EngineChoice, EngineError, LocalSettings,
    Sampler, open_engine, open_engines,
};

/// Rounds of one decision on each engine: the first ones are not timed. They end early when the decisions take long.
const WARM_UP_ROUNDS: usize = 3;
const ROUNDS: usize = 15;
const MIN_ROUNDS: usize = 3;
/// Time after which no further round begins, seconds.
const MAX_SECONDS: f64 = 0.5;
/// Pause before each round. A robot does not decide all the time either: threads sleep, and a GPU lowers its clock.
const PAUSE: Duration = Duration::from_millis(5);

/// The engine that a user asks for: `auto`, the fastest of this machine by [`measure_engines`], or one by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum EngineRequest {
    /// The fastest.
    #[default]
    Auto,
    /// This one.
    Chosen(EngineChoice),
}

impl FromStr for EngineRequest {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.parse() {
            _ if text == "auto" => Ok(Self::Auto),
            Ok(choice) => Ok(Self::Chosen(choice)),
            Err(_) => Err(format!(
                "`{}` is not an engine: use auto, cpu, gpu or gpu:ADAPTER-NAME",
                text.escape_debug()
            )),
        }
    }
}

/// Opens the engine of a request. For `auto` it measures first, see [`measure_engines`]; an adapter that does not open is left
/// out. No threads count as one.
///
/// # Errors
/// Fails when the engine does not open, or fails while it is measured.
pub fn open_requested(
    request: &EngineRequest,
    size: &DecisionSize,
    threads: usize,
    clock: &mut dyn FnMut() -> f64,
    pause: &mut dyn FnMut(Duration),
) -> Result<Box<dyn Engine>, BenchError> {
    let threads = threads.max(1);
    let (choice, threads) = match request {
        EngineRequest::Chosen(choice) => (choice.clone(), threads),
        EngineRequest::Auto => {
            let times = measure_engines(size, threads, clock, pause, |_| {})?;
            times.first().map_or((EngineChoice::Cpu, threads), |first| first.choice(threads))
        }
    };
    Ok(open_engine(&choice, threads)?.engine)
}

/// The size of a decision, which tells how long it takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DecisionSize {
    /// Number of forward speeds.
    pub vx_samples: u32,
    /// Number of turn rates.
    pub vtheta_samples: u32,
    /// Steps of the horizon.
    pub steps: u32,
    /// Discs of the footprint, 1 to 8.
    pub discs: usize,
    /// Motion of the samples.
    pub sampler: Sampler,
}

impl DecisionSize {
    /// The size with these settings, of a robot whose footprint has this number of discs.
    #[must_use]
    pub fn new(settings: &LocalSettings, discs: usize) -> Self {
        Self {
            vx_samples: settings.vx_samples,
            vtheta_samples: settings.vtheta_samples,
            steps: settings.steps(),
            discs,
            sampler: settings.sampler,
        }
    }
}

impl Default for DecisionSize {
    /// The size with the default settings, of a robot with one disc.
    fn default() -> Self {
        Self::new(&LocalSettings::default(), 1)
    }
}

impl fmt::Display for DecisionSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { vx_samples, vtheta_samples, steps, discs, sampler } = self;
        let (sampler, plural) = (sampler.name(), if *discs == 1 { "" } else { "s" });
        write!(
            f,
            "{vx_samples} x {vtheta_samples} {sampler} of {steps} steps, {discs} disc{plural}"
        )
    }
}

/// The median time of a decision on one engine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EngineTime {
    /// The engine's name.
    pub name: String,
    /// Threads of a CPU engine; zero for a GPU engine.
    pub threads: usize,
    /// Median, milliseconds.
    pub p50_ms: f64,
}

impl EngineTime {
    /// The choice that opens the engine, and its threads; for a GPU, those of its fallback.
    #[must_use]
    pub fn choice(&self, threads: usize) -> (EngineChoice, usize) {
        match self.threads {
            0 => (EngineChoice::Gpu(Some(self.name.clone())), threads),
            own => (EngineChoice::Cpu, own),
        }
    }
}

impl fmt::Display for EngineTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {:.3} ms", self.name, self.p50_ms)
    }
}

/// Times each engine with decisions of one size: the CPU on 1, 2, 4... and on all `threads`, and each hardware adapter. Software
/// adapters run on the same cores, slower. The fastest comes first.
///
/// The engines take turns, with pauses between the rounds, as on a robot that decides a few times a second; this takes 0.1 to
/// 0.6 s, and a GPU's driver needs up to a second to open. `pause` waits for the given time. `left_out` receives the
/// error of each adapter that does not open, or fails while it is timed.
///
/// # Errors
/// Fails when a CPU engine fails, or the size is outside its range.
pub fn measure_engines(
    size: &DecisionSize,
    threads: usize,
    clock: &mut dyn FnMut() -> f64,
    pause: &mut dyn FnMut(Duration),
    mut left_out: impl FnMut(&EngineError),
) -> Result<Vec<EngineTime>, BenchError> {
    let engines =
        open_engines(CpuEngines::Doubling, AdapterSelection::Hardware, threads, &mut left_out)?;
    time_engines(engines, size, clock, pause, left_out)
}

/// Times open engines. One on a GPU that fails is closed and left out: the CPU can still decide.
fn time_engines(
    engines: Vec<Box<dyn Engine>>,
    size: &DecisionSize,
    clock: &mut dyn FnMut() -> f64,
    pause: &mut dyn FnMut(Duration),
    mut left_out: impl FnMut(&EngineError),
) -> Result<Vec<EngineTime>, BenchError> {
    let &DecisionSize { vx_samples, vtheta_samples, steps, discs, sampler } = size;
    let roadway =
        Roadway { vx_samples, vtheta_samples, steps, window_s: 0.1, discs, people: 0, sampler };
    let mut timed: Vec<(Option<Box<dyn Engine>>, Latencies)> =
        engines.into_iter().map(|engine| (Some(engine), Latencies::default())).collect();
    let mut closer = DeviceCloser::default();
    let field = roadway_field();
    let began = clock();
    for round in 0..WARM_UP_ROUNDS + ROUNDS {
        pause(PAUSE);
        for (slot, latencies) in &mut timed {
            let Some(engine) = slot else { continue };
            let before = clock();
            match roadway.decide(engine.as_mut(), &field, round) {
                Err(BenchError::Engine { error, .. }) if engine.kind() == "gpu" => {
                    left_out(&error);
                    slot.take().into_iter().for_each(|lost| closer.close(lost));
                    continue;
                }
                decided => decided?,
            };
            let seconds = clock() - before;
            if round >= WARM_UP_ROUNDS {
                latencies.record(seconds)?;
            }
        }
        if round >= WARM_UP_ROUNDS + MIN_ROUNDS && clock() - began > MAX_SECONDS {
            break;
        }
    }
    let mut times: Vec<EngineTime> = timed
        .iter()
        .filter_map(|(engine, latencies)| Some((engine.as_ref()?, latencies)))
        .map(|(engine, latencies)| EngineTime {
            name: engine.name(),
            threads: engine.threads(),
            p50_ms: latencies.quantile_ms(0.5).unwrap_or(f64::INFINITY),
        })
        .collect();
    times.sort_by(|one, other| one.p50_ms.total_cmp(&other.p50_ms));
    Ok(times)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::lost_gpu::{clock, with_gpu};

    fn small() -> DecisionSize {
        let settings = LocalSettings { vx_samples: 4, vtheta_samples: 4, ..Default::default() };
        DecisionSize::new(&settings, 1)
    }

    #[test]
    fn every_thread_count_is_timed_with_pauses_between_the_rounds() {
        let mut pauses = 0;
        let mut pause = |time: Duration| {
            assert_eq!(time, PAUSE);
            pauses += 1;
        };
        let times = measure_engines(&small(), 3, &mut clock(1e-6), &mut pause, |_| {});
        let times = times.expect("the CPU never fails");
        let mut threads: Vec<usize> = times.iter().map(|time| time.threads).collect();
        threads.retain(|&threads| threads > 0);
        threads.sort_unstable();
        assert_eq!(threads, [1, 2, 3]);
        assert!(times.windows(2).all(|pair| pair[0].p50_ms <= pair[1].p50_ms), "{times:?}");
        assert_eq!(pauses, WARM_UP_ROUNDS + ROUNDS);
    }

    #[test]
    fn slow_decisions_are_timed_less_often() {
        let mut pauses = 0;
        let times = measure_engines(&small(), 1, &mut clock(0.1), &mut |_| pauses += 1, |_| {});
        assert!(times.is_ok_and(|times| times[0].p50_ms > 99.0));
        assert_eq!(pauses, WARM_UP_ROUNDS + MIN_ROUNDS + 1);
    }

    #[test]
    fn gpu_that_fails_while_it_is_timed_is_left_out_with_its_error() {
        for remaining in [0, WARM_UP_ROUNDS + 2, 1000] {
            let engines = with_gpu(remaining).into_iter().rev().collect();
            let mut errors = Vec::new();
            let left_out = |error: &EngineError| errors.push(error.to_string());
            let times = time_engines(engines, &small(), &mut clock(1e-6), &mut |_| {}, left_out);
            let times = times.expect("the CPU never fails");
            let is_lost = remaining < 1000;
            assert_eq!(
                times.iter().filter(|time| time.threads == 0).count(),
                usize::from(!is_lost)
            );
            assert_eq!(times.iter().filter(|time| time.threads == 1).count(), 1);
            let expected = "GPU a GPU gave no answer: simulated".to_owned();
            assert_eq!(errors, if is_lost { vec![expected] } else { Vec::new() });
        }
    }

    #[test]
    fn request_is_auto_or_an_engine() {
        assert_eq!("auto".parse(), Ok(EngineRequest::Auto));
        assert_eq!("cpu".parse(), Ok(EngineRequest::Chosen(EngineChoice::Cpu)));
        let named = EngineChoice::Gpu(Some("H200".to_owned()));
        assert_eq!("gpu:H200".parse(), Ok(EngineRequest::Chosen(named)));
        assert!("gpu:".parse::<EngineRequest>().is_err_and(|error| error.contains("auto, cpu")));
    }
}
