//! A drive with many faults, and an observer that counts them on its own.

use core::ops::ControlFlow;
use std::collections::BTreeMap;

use inbye::geometry::Twist;
use inbye::local::{
    CpuEngine, Detail, Engine, EngineError, Evaluation, Failover, GpuFailureKind, QuantizedProblem,
};
use inbye::navigator::ObservationFault;
use inbye::runtime::{Config, GroundTruth, OdometryReading, Robot, SensorData, TickEvent};
use inbye::sim::{SimBase, Simulation};

/// Ticks with a jump of the odometry.
const JUMP: [usize; 2] = [40, 43];
/// The odometry freezes at the first tick from this one on at which the robot is at least this fast, m/s, for so many ticks. On a
/// robot that stands it cannot be noticed.
const FROZEN_FROM: usize = 120;
const FROZEN_SPEED: f64 = 0.2;
const FROZEN_TICKS: usize = 10;
/// Ticks at which the base is overheated.
const HOT: [usize; 2] = [60, 64];
/// Evaluations of each GPU before it is lost.
const EVALUATIONS: u32 = 30;

/// A base with odometry faults that also overheats.
pub struct FaultyBase {
    base: SimBase,
    driven: usize,
    /// the last odometry reading before it froze.
    last: OdometryReading,
    frozen_from: Option<usize>,
}

fn is_within(tick: usize, [from, to]: [usize; 2]) -> bool {
    (from..to).contains(&tick)
}

impl FaultyBase {
    pub fn new(simulation: &Simulation, config: &Config) -> Self {
        let start = simulation.mission.start;
        let base = SimBase::of(config, start, simulation.seed);
        let base = base.expect("sound settings");
        let last = base.odometry();
        Self { base, driven: 0, last, frozen_from: None }
    }
}

impl Robot for FaultyBase {
    fn sense(&mut self, time_s: f64) -> SensorData {
        let mut sensed = self.base.sense(time_s);
        if self.driven >= FROZEN_FROM && sensed.odometry.twist.linear >= FROZEN_SPEED {
            self.frozen_from.get_or_insert(self.driven);
        }
        let is_frozen = |from: usize| is_within(self.driven, [from, from + FROZEN_TICKS]);
        if self.frozen_from.is_some_and(is_frozen) {
            sensed.odometry = self.last;
            return sensed;
        }
        if is_within(self.driven, JUMP) {
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

/// A GPU that is lost after some evaluations.
struct LostGpu {
    cpu: CpuEngine,
    left: u32,
}

impl LostGpu {
    fn boxed() -> Box<dyn Engine> {
        Box::new(Self { cpu: CpuEngine::single_threaded(), left: EVALUATIONS })
    }
}

impl Engine for LostGpu {
    fn name(&self) -> String {
        "a failing GPU".to_owned()
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

/// A GPU that is lost repeatedly and reopened each time.
pub fn failing_engine() -> Box<dyn Engine> {
    let source = || Ok(LostGpu::boxed());
    let cpu = CpuEngine::single_threaded();
    Box::new(Failover::new(Ok(LostGpu::boxed()), source, cpu))
}

/// The faults of each tick, from the counters of the navigator and its engine.
#[derive(Clone, Default)]
pub struct ObservedFaults {
    pub at: Vec<Vec<String>>,
    observation_faults: BTreeMap<ObservationFault, u64>,
    messages: usize,
}

impl ObservedFaults {
    pub fn record(&mut self, event: &TickEvent<'_>) {
        let mut now = Vec::new();
        for (fault, &count) in event.navigator.observation_faults() {
            if self.observation_faults.insert(*fault, count).unwrap_or_default() < count {
                now.push(format!("sensors: {fault}"));
            }
        }
        if let Some(incidents) = event.navigator.planner().incidents() {
            let new = &incidents.messages[self.messages..];
            now.extend(new.iter().map(|one| format!("engine: {}", one.message)));
            self.messages = incidents.messages.len();
        }
        now.extend(event.robot_fault.map(|text| format!("base: {text}")));
        self.at.push(now);
    }

    /// The first tick and the text of each fault.
    pub fn begun(&self) -> Vec<(usize, String)> {
        let of_tick = |tick: usize| {
            let before = tick.checked_sub(1).map_or(&[][..], |before| &self.at[before]);
            let new = self.at[tick].iter().filter(|text| !before.contains(text));
            new.map(move |text| (tick, text.clone())).collect::<Vec<_>>()
        };
        (0..self.at.len()).flat_map(of_tick).collect()
    }
}
