//! The CPU engine: rows of samples, one for each turn rate, judged by threads with the best instructions there are.

mod arithmetic;
mod bounds;
mod choice;
mod course;
mod crew;
mod groups;
mod instructions;
mod lanes;
mod looked;
mod march;
mod moving;
mod part;
mod patches;
mod pooled;
mod reach;
mod row;
mod scalar;
mod sieve;
mod spans;
mod table;
mod tally;
mod two_rows;
#[cfg(target_arch = "x86_64")]
mod x86;
mod yardstick;

#[cfg(test)]
mod tests;

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use choice::Share;
use course::Course;
use crew::Crew;
use instructions::Kernel;
use part::{Choice, Part};
use pooled::{Pooled, Pooling};
use tally::Tally;

pub use instructions::Instructions;
pub use yardstick::GatherOnly;

use super::contract::{Detail, Engine, Evaluation, SampleRecord, Winner};
use super::select::{Candidate, NOBODY, better};
use super::{EngineError, Prepared, score};

/// Parts for each thread of several: enough that one who wakes late leaves little undone.
const PARTS_PER_THREAD: usize = 4;

/// With fewer samples the choice is made sooner than handed out.
const CHOSEN_TOGETHER: usize = 1 << 15;

/// Evaluates on the machine's own cores.
pub struct CpuEngine {
    instructions: Instructions,
    kernel: Kernel,
    /// None where all is done in the caller's thread.
    crew: Option<Crew>,
    threads: usize,
    course: Course,
    pooled: Pooled,
    parts: Vec<Mutex<Part>>,
}

impl CpuEngine {
    /// An engine that works in the thread that calls it.
    #[must_use]
    pub fn single_threaded() -> Self {
        let instructions = Instructions::best();
        Self::new(
            instructions,
            Kernel::of(instructions).unwrap_or(Kernel::Portable),
            None,
            1,
        )
    }

    /// An engine that works in the thread that calls it and in others; with one thread, or none, in the caller's alone.
    ///
    /// # Errors
    /// When the system does not give the threads.
    pub fn with_threads(threads: usize) -> Result<Self, EngineError> {
        Self::with_instructions(Instructions::best(), threads)
    }

    /// An engine with certain instructions, to compare them.
    ///
    /// # Errors
    /// When the processor does not have them, or the system does not give the threads.
    pub fn with_instructions(
        instructions: Instructions,
        threads: usize,
    ) -> Result<Self, EngineError> {
        let kernel = Self::kernel_of(instructions)?;
        let crew = if threads > 1 {
            Some(Crew::new(threads - 1)?)
        } else {
            None
        };
        Ok(Self::new(instructions, kernel, crew, threads.max(1)))
    }

    fn kernel_of(instructions: Instructions) -> Result<Kernel, EngineError> {
        Kernel::of(instructions).ok_or(EngineError::NoInstructions {
            which: instructions.word(),
        })
    }

    fn new(instructions: Instructions, kernel: Kernel, crew: Option<Crew>, threads: usize) -> Self {
        let parts = if threads > 1 {
            threads * PARTS_PER_THREAD
        } else {
            1
        };
        Self {
            instructions,
            kernel,
            crew,
            threads,
            course: Course::default(),
            pooled: Pooled::default(),
            parts: (0..parts).map(|_| Mutex::default()).collect(),
        }
    }

    /// The instructions it uses.
    #[must_use]
    pub const fn instructions(&self) -> Instructions {
        self.instructions
    }

    /// Has every part judged.
    fn judge(&mut self, problem: &Prepared) {
        let (kernel, parts) = (self.kernel, &self.parts);
        let (course, pooled) = (&self.course, &self.pooled);
        let rows = problem.turns.len();
        let share = |number: usize| rows * number / parts.len();
        share_out(self.crew.as_mut(), parts, |number, part| {
            let rows = share(number)..share(number + 1);
            part.judge(kernel, problem, course, pooled, rows);
        });
    }

    /// What all samples add up to, and the best of them.
    fn select(&mut self, problem: &Prepared) -> (Tally, Candidate) {
        let mut tally = Tally::default();
        for part in &mut self.parts {
            tally.merge(unlocked(part).total());
        }
        let normalizers = score::normalizers(&problem.header, &tally.totals);
        let choice = Choice {
            kernel: self.kernel,
            problem,
            course: &self.course,
            shares: normalizers.map(|normalizer| Share::new(&normalizer)),
        };
        // The row that promises most comes first: few of the others can then still win.
        let mut first = (NOBODY, 0);
        for (number, part) in self.parts.iter_mut().enumerate() {
            let bound = unlocked(part).find_bounds(&choice);
            if better(first.0, bound) == bound {
                first = (bound, number);
            }
        }
        let (bound, number) = first;
        if bound == NOBODY {
            return (tally, NOBODY);
        }
        let row = bound.1 as usize / problem.speeds.len();
        let candidate = unlocked(&mut self.parts[number]).best_of_row(&choice, row, NOBODY);
        let parts = &self.parts;
        let crew = self
            .crew
            .as_mut()
            .filter(|_| problem.len() >= CHOSEN_TOGETHER);
        share_out(crew, parts, |_, part| part.choose(&choice, candidate));
        let best = self.parts.iter_mut().map(|part| unlocked(part).best());
        (tally, best.fold(NOBODY, better))
    }

    /// The winner, unless nobody won.
    fn winner(&mut self, problem: &Prepared, (score, index): Candidate) -> Option<Winner> {
        let speeds = problem.speeds.len();
        let (row, column) = (index as usize / speeds, index as usize % speeds);
        let course = &self.course;
        let mut parts = self.parts.iter_mut().map(unlocked);
        let part = parts.find(|part| part.rows().contains(&row))?;
        Some(Winner {
            index,
            score,
            terms: part.sample(problem, course, row, column).terms,
        })
    }

    /// All samples in order: parts follow one another as their rows do.
    fn samples(&mut self, problem: &Prepared) -> Vec<SampleRecord> {
        let course = &self.course;
        let mut samples = Vec::with_capacity(problem.len());
        for part in &mut self.parts {
            let part = unlocked(part);
            for row in part.rows().clone() {
                let row =
                    (0..problem.speeds.len()).map(|index| part.sample(problem, course, row, index));
                samples.extend(row);
            }
        }
        samples
    }
}

/// Does something with every part, each taken by whoever is free.
fn share_out(
    crew: Option<&mut Crew>,
    parts: &[Mutex<Part>],
    each: impl Fn(usize, &mut Part) + Sync,
) {
    let next = AtomicUsize::new(0);
    let work = || {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(part) = parts.get(number) else {
                break;
            };
            each(
                number,
                &mut part.lock().unwrap_or_else(PoisonError::into_inner),
            );
        }
    };
    match crew {
        None => work(),
        Some(crew) => crew.run(&work),
    }
}

fn unlocked(part: &mut Mutex<Part>) -> &mut Part {
    part.get_mut().unwrap_or_else(PoisonError::into_inner)
}

impl Engine for CpuEngine {
    fn name(&self) -> String {
        let plural = if self.threads == 1 { "" } else { "s" };
        let instructions = self.instructions.word();
        format!("CPU, {} thread{plural}, {instructions}", self.threads)
    }

    fn kind(&self) -> &'static str {
        "cpu"
    }

    fn threads(&self) -> usize {
        self.threads
    }

    fn evaluate(&mut self, problem: &Prepared, detail: Detail) -> Result<Evaluation, EngineError> {
        self.course.fill(problem);
        self.pooled.clear();
        let is_scalar = matches!(self.kernel, Kernel::Scalar);
        if !is_scalar && self.course.in_any_order && self.course.is_fine {
            self.kernel.run(Pooling {
                pooled: &mut self.pooled,
                problem,
            });
        }
        self.judge(problem);
        let (tally, best) = self.select(problem);
        let winner = self.winner(problem, best);
        let samples = (detail == Detail::Samples).then(|| self.samples(problem));
        Ok(Evaluation {
            counts: tally.counts,
            totals: tally.totals,
            winner,
            samples,
        })
    }
}
