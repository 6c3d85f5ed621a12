//! What goes wrong on a drive, tick by tick and in words: faulty observations, a GPU that is lost, trouble with the
//! base, contact, and why a mission is given up.

use super::TickEvent;
use crate::local::GpuFailureKind;
use crate::navigator::Mode;

/// Tells what is wrong at each tick of one drive, shown to it in order.
#[derive(Clone, Debug, Default)]
pub struct FaultEvents {
    /// Incidents of the engine up to the last tick.
    incidents: u64,
}

impl FaultEvents {
    /// A sentence for each thing that is wrong at the next tick; none where all is well.
    pub fn at(&mut self, moment: &TickEvent<'_>) -> Vec<String> {
        let navigator = moment.navigator;
        let mut now: Vec<String> = navigator
            .observation_fault()
            .map(|fault| format!("sensors: {fault}"))
            .into_iter()
            .collect();
        now.extend(self.of_engine(moment));
        now.extend(moment.robot_fault.map(|words| format!("base: {words}")));
        if moment.row.gap_m <= 0.0 {
            now.push("contact: the robot touches something".to_owned());
        }
        let fault = navigator
            .fault()
            .filter(|_| moment.row.mode == Mode::Failed);
        now.extend(fault.map(|fault| format!("gave up: {fault}")));
        now
    }

    /// What happened to a GPU with a stand-in since the last tick. That there is none to begin with is no fault.
    fn of_engine(&mut self, moment: &TickEvent<'_>) -> Vec<String> {
        let Some(incidents) = moment.navigator.planner().incidents() else {
            return Vec::new();
        };
        let before = std::mem::replace(&mut self.incidents, incidents.total());
        (before..self.incidents)
            .filter_map(|index| match incidents.messages.get(index as usize) {
                Some(one) if one.kind == Some(GpuFailureKind::Absent) => None,
                Some(one) => Some(format!("engine: {}", one.message)),
                None => {
                    Some("engine: one more incident; only the first are told in words".to_owned())
                }
            })
            .collect()
    }
}
