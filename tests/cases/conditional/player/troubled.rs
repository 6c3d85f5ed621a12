//! A drive on which much goes wrong, and what a on_tick of its own noted of it.

use core::ops::ControlFlow;
use std::collections::BTreeMap;

use inbye::geometry::Twist;
use inbye::local::{
    CpuEngine, Detail, Engine, EngineError, Evaluation, Failover, GpuFailureKind, QuantizedProblem,
};
use inbye::navigator::ObservationFault;
use inbye::runtime::{Config, GroundTruth, OdometryReading, Robot, SensorData, TickEvent};
use inbye::sim::{SimBase, Simulation};

/// Ticks at which the odometer is elsewhere, and those at which it stands.
const ELSEWHERE: [usize; 2] = [40, 43];
const FROZEN: [usize; 2] = [90, 100];
/// Ticks at which the base is too hot.
const HOT: [usize; 2] = [60, 64];
/// Answers that each GPU gives before it is lost.
const ANSWERS: u32 = 30;

/// A base whose odometer lies, and which is too hot for a while.
pub struct Troubled {
    base: SimBase,
    driven: usize,
    /// What the odometer said last before it stood.
    last: OdometryReading,
}

fn is_within(tick: usize, [from, to]: [usize; 2]) -> bool {
    (from..to).contains(&tick)
}

impl Troubled {
    pub fn new(simulation: &Simulation, config: &Config) -> Self {
        let start = simulation.mission.start;
        let base = SimBase::of(config, start, simulation.seed);
        let base = base.expect("sound settings");
        let last = base.odometry();
        Self {
            base,
            driven: 0,
            last,
        }
    }
}

impl Robot for Troubled {
    fn sense(&mut self, time_s: f64) -> SensorData {
        let mut sensed = self.base.sense(time_s);
        if is_within(self.driven, FROZEN) {
            sensed.odometry = self.last;
            return sensed;
        }
        if is_within(self.driven, ELSEWHERE) {
            sensed.odometry.pose.x += 5.0;
        }
        self.last = sensed.odometry;
        sensed
    }

    fn ground_truth(&self) -> Option<GroundTruth> {
        self.base.ground_truth()
    }

    fn drive(&mut self, command: &Twist, period_s: f64) -> ControlFlow<()> {
        self.driven += 1;
        self.base.drive(command, period_s)
    }

    fn fault(&self) -> Option<String> {
        // The loop calls it at the end of a tick.
        is_within(self.driven - 1, HOT).then(|| "the base reports: <overheated>".to_owned())
    }
}

/// A GPU that is lost after some answers.
struct Mortal {
    cpu: CpuEngine,
    left: u32,
}

impl Mortal {
    fn boxed() -> Box<dyn Engine> {
        Box::new(Self {
            cpu: CpuEngine::single_threaded(),
            left: ANSWERS,
        })
    }
}

impl Engine for Mortal {
    fn name(&self) -> String {
        "a mortal GPU".to_owned()
    }

    fn kind(&self) -> &'static str {
        "gpu"
    }

    fn threads(&self) -> usize {
        0
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        if self.left == 0 {
            return Err(EngineError::Lost {
                adapter: self.name(),
                kind: GpuFailureKind::DeviceLost,
                message: "unplugged </script>".to_owned(),
            });
        }
        self.left -= 1;
        self.cpu.evaluate(problem, detail)
    }
}

/// A GPU that is lost again and again, each time opened anew after a while.
pub fn mortal_engine() -> Box<dyn Engine> {
    let source = || Ok(Mortal::boxed());
    let cpu = CpuEngine::single_threaded();
    Box::new(Failover::new(Ok(Mortal::boxed()), source, cpu))
}

/// What went wrong at each tick, by the counts of the navigator and its engine.
#[derive(Clone, Default)]
pub struct Noted {
    pub at: Vec<Vec<String>>,
    observation_faults: BTreeMap<ObservationFault, u64>,
    told: usize,
}

impl Noted {
    pub fn take(&mut self, moment: &TickEvent<'_>) {
        let mut now = Vec::new();
        for (fault, &count) in moment.navigator.observation_faults() {
            if self
                .observation_faults
                .insert(*fault, count)
                .unwrap_or_default()
                < count
            {
                now.push(format!("sensors: {fault}"));
            }
        }
        if let Some(incidents) = moment.navigator.planner().incidents() {
            let new = &incidents.messages[self.told..];
            now.extend(new.iter().map(|one| format!("engine: {}", one.message)));
            self.told = incidents.messages.len();
        }
        now.extend(moment.robot_fault.map(|words| format!("base: {words}")));
        self.at.push(now);
    }

    /// Each thing once, where it begins: its tick and words.
    pub fn begun(&self) -> Vec<(usize, String)> {
        let of_tick = |tick: usize| {
            let before = tick
                .checked_sub(1)
                .map_or(&[][..], |before| &self.at[before]);
            let new = self.at[tick].iter().filter(|words| !before.contains(words));
            new.map(move |words| (tick, words.clone()))
                .collect::<Vec<_>>()
        };
        (0..self.at.len()).flat_map(of_tick).collect()
    }
}
