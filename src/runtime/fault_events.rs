//! Describes the faults of a drive tick by tick: faulty observations, GPU failures, faults of the base, contact, and
//! why the mission failed.

use super::TickEvent;
use crate::local::GpuFailureKind;
use crate::navigator::Mode;

/// Describes the faults of each tick of a drive. Takes the ticks in order.
#[derive(Clone, Debug, Default)]
pub struct FaultEvents {
    /// Number of GPU failures up to the last tick.
    incidents: u64,
}

impl FaultEvents {
    /// Returns a sentence for each fault of the next tick.
    pub fn update(&mut self, tick: &TickEvent<'_>) -> Vec<String> {
        let navigator = tick.navigator;
        let mut now: Vec<String> = navigator
            .observation_fault()
            .map(|fault| format!("sensors: {fault}"))
            .into_iter()
            .collect();
        now.extend(self.engine_events(tick));
        now.extend(tick.robot_fault.map(|words| format!("base: {words}")));
        if tick.row.gap_m <= 0.0 {
            now.push("contact: the robot touches something".to_owned());
        }
        let fault = navigator.fault().filter(|_| tick.row.mode == Mode::Failed);
        now.extend(fault.map(|fault| format!("gave up: {fault}")));
        now
    }

    /// Describes GPU failures since the last tick. A GPU that is absent from the start is no fault.
    fn engine_events(&mut self, tick: &TickEvent<'_>) -> Vec<String> {
        let Some(incidents) = tick.navigator.planner().incidents() else {
            return Vec::new();
        };
        let before = std::mem::replace(&mut self.incidents, incidents.total());
        (before..self.incidents)
            .filter_map(|index| match incidents.messages.get(index as usize) {
                Some(one) if one.kind == Some(GpuFailureKind::Absent) => None,
                Some(one) => Some(format!("engine: {}", one.message)),
                None => {
                    Some("engine: one more incident; only the first ones are described".to_owned())
                }
            })
            .collect()
    }
}
