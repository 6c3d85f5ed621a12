//! Engines, and decisions with their digests.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Instant;

use inbye::bench::{DecisionSize, EngineRequest, EvaluationDigest, open_requested};
use inbye::local::{Detail, Evaluation, Explainer, QuantizedProblem, SampleSi, WinnerSi};
use pyo3::prelude::*;

use super::conversion::{raise, whole};
use super::problem::Problem;
use super::records::Records;

/// The answer to one problem.
#[pyclass(frozen, module = "inbye")]
pub struct Decision {
    winner: Option<WinnerSi>,
    evaluation: Evaluation,
    samples: Option<Vec<SampleSi>>,
}

/// Columns of the samples of a decision.
const SAMPLES: &[(&str, &str)] = &[
    ("vx", "<f8"),
    ("vtheta", "<f8"),
    ("status", "<U12"),
    ("x", "<f8"),
    ("y", "<f8"),
    ("yaw", "<f8"),
    ("heading", "<f8"),
    ("clearance", "<f8"),
    ("velocity", "<f8"),
    ("path", "<f8"),
    ("score", "<f8"),
];

impl Decision {
    fn new(problem: &Problem, quantized: &QuantizedProblem, evaluation: Evaluation) -> Self {
        let explainer = Explainer::new(&problem.inner, quantized, &evaluation);
        let winner = explainer.winner(&evaluation);
        let samples = evaluation.samples.is_some().then(|| explainer.samples(&evaluation));
        Self { winner, evaluation, samples }
    }
}

#[pymethods]
impl Decision {
    /// Velocity of the best sample; none if no sample is admissible.
    #[getter]
    fn command(&self) -> Option<(f64, f64)> {
        self.winner.map(|winner| (winner.vx, winner.vtheta))
    }

    /// Index of the best sample.
    #[getter]
    fn index(&self) -> Option<u32> {
        self.winner.map(|winner| winner.index)
    }

    /// Score of the best sample.
    #[getter]
    fn score(&self) -> Option<f64> {
        self.winner.map(|winner| winner.score)
    }

    /// Number of admissible samples.
    #[getter]
    const fn admissible(&self) -> u32 {
        self.evaluation.counts.admissible
    }

    /// Numbers of samples that collide, cannot stop, and leave the map.
    #[getter]
    const fn rejected(&self) -> (u32, u32, u32) {
        (
            self.evaluation.counts.collision,
            self.evaluation.counts.cannot_stop,
            self.evaluation.counts.outside,
        )
    }

    /// SHA-256 of the exact bits. With samples=True it covers all samples and is the digest of `inbye evaluate`. Without, it covers
    /// the answer only and is another value.
    #[getter]
    fn digest(&self) -> String {
        let mut digest = EvaluationDigest::default();
        digest.add(&self.evaluation);
        digest.hex()
    }

    /// Every sample as a structured array; none unless they were asked for.
    #[getter]
    fn samples<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some(samples) = &self.samples else { return Ok(None) };
        let mut records = Records::new(SAMPLES);
        for sample in samples {
            let terms = &sample.terms;
            records.reals([sample.vx, sample.vtheta]);
            records.text(sample.status, 12);
            records.reals([sample.end.x, sample.end.y, sample.end.yaw]);
            records.reals([terms.heading, terms.clearance, terms.velocity, terms.path]);
            records.real(sample.score.unwrap_or(f64::NAN));
        }
        records.to_array(py).map(Some)
    }

    fn __copy__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    fn __deepcopy__<'py>(slf: Bound<'py, Self>, _memo: &Bound<'py, PyAny>) -> Bound<'py, Self> {
        slf
    }

    fn __repr__(&self) -> String {
        let samples: u32 = self.evaluation.counts.to_array().iter().sum();
        match &self.winner {
            Some(WinnerSi { vx, vtheta, .. }) => {
                format!(
                    "Decision(command=({vx}, {vtheta}), {} of {samples} admissible)",
                    self.evaluation.counts.admissible
                )
            }
            None => format!("Decision(command=None, none of {samples} admissible)"),
        }
    }
}

/// Evaluates problems on the CPU or on a GPU, with the same bits.
#[pyclass(frozen, module = "inbye")]
pub struct Engine {
    name: String,
    inner: Mutex<Box<dyn inbye::local::Engine>>,
}

/// Opens an engine by its name: "auto", the fastest for decisions of the default size, "cpu", "gpu" or "gpu:NAME".
pub fn open(name: &str, threads: usize) -> PyResult<Box<dyn inbye::local::Engine>> {
    let request: EngineRequest = name.parse().map_err(raise)?;
    let size = DecisionSize::default();
    let started = Instant::now();
    let clock = &mut || started.elapsed().as_secs_f64();
    open_requested(&request, &size, threads, clock, &mut thread::sleep).map_err(raise)
}

impl Engine {
    fn open(&self) -> MutexGuard<'_, Box<dyn inbye::local::Engine>> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

const fn detail(samples: bool) -> Detail {
    if samples { Detail::Samples } else { Detail::Answer }
}

#[pymethods]
impl Engine {
    #[new]
    #[pyo3(signature = (name="auto", *, threads=1))]
    fn new(py: Python<'_>, name: &str, threads: i128) -> PyResult<Self> {
        let threads = whole("threads", threads)?;
        let inner = py.detach(|| open(name, threads))?;
        Ok(Self { name: inner.name(), inner: Mutex::new(inner) })
    }

    /// The processor.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// Takes one decision.
    #[pyo3(signature = (problem, *, samples=false))]
    fn evaluate(
        &self,
        py: Python<'_>,
        problem: &Bound<'_, Problem>,
        samples: bool,
    ) -> PyResult<Decision> {
        let problem = problem.get();
        py.detach(|| {
            let quantized = QuantizedProblem::new(&problem.inner).map_err(raise)?;
            let evaluation = self.open().evaluate(&quantized, detail(samples)).map_err(raise)?;
            Ok(Decision::new(problem, &quantized, evaluation))
        })
    }

    /// Takes the decisions of many robots in one submission.
    #[pyo3(signature = (problems, *, samples=false))]
    fn evaluate_batch(
        &self,
        py: Python<'_>,
        problems: Vec<Bound<'_, Problem>>,
        samples: bool,
    ) -> PyResult<Vec<Decision>> {
        let problems: Vec<&Problem> = problems.iter().map(Bound::get).collect();
        py.detach(|| {
            let quantized = problems.iter().map(|problem| QuantizedProblem::new(&problem.inner));
            let quantized: Vec<_> = quantized.collect::<Result<_, _>>().map_err(raise)?;
            let evaluations =
                self.open().evaluate_batch(&quantized, detail(samples)).map_err(raise)?;
            let answers = problems.iter().zip(&quantized).zip(evaluations);
            Ok(answers
                .map(|((problem, quantized), it)| Decision::new(problem, quantized, it))
                .collect())
        })
    }

    fn __repr__(&self) -> String {
        format!("Engine({:?})", self.name)
    }
}
