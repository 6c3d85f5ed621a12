//! Limits the speed by the visible space: a person may come out of each place that the scan does not show.

use super::super::Fault;
use super::super::occlusion::hidden_people;
use super::super::state::State;
use super::{Behaviour, Proposal};

/// Slows down so that the robot stands before a person from a hidden place can reach it.
#[derive(Debug, Default)]
pub(super) struct OcclusionSpeed;

impl Behaviour for OcclusionSpeed {
    fn propose(&mut self, state: &State<'_>) -> Result<Option<Proposal>, Fault> {
        let Some(room) = state.standing_room else {
            return Ok(None);
        };
        let settings = state.settings;
        let moving = &state.now.moving;
        let people = hidden_people(&state.visible, room, moving, settings.pedestrian_speed);
        let fastest = state.safety_from(&people).fastest(state.robot.limits.max_vel_x);
        Ok(Some(Proposal::SpeedLimit(fastest.max(settings.occlusion_min_speed))))
    }
}
