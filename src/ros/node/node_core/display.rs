//! What the node shows of its decisions.

use super::{NodeCore, Outgoing};
use crate::navigator::Decision;
use crate::ros::convert::{self, SAMPLING, markers};
use crate::ros::msg::{Duration, Header, Time};

/// Interval of the markers, seconds.
const MARKER_INTERVAL_S: f64 = 0.2;
/// Lifetime of a marker: markers disappear if the node stops.
const MARKER_LIFETIME: Duration = Duration { sec: 0, nanosec: 500_000_000 };

impl NodeCore {
    /// Adds a new plan, and markers at their interval.
    pub(super) fn add_plan_and_markers(
        &mut self,
        now_s: f64,
        decision: Option<&Decision>,
        outgoing: &mut Outgoing,
    ) {
        let (Some(navigator), Some(map), Some(decision)) =
            (&self.navigator, &self.inputs.map, decision)
        else {
            return;
        };
        let header = Header { stamp: Time::from_seconds(now_s), frame_id: map.frame.clone() };
        let plans = navigator.plans();
        let new_plan = plans.get(self.published_plans..).and_then(<[_]>::last);
        outgoing.path = new_plan.map(|plan| convert::path(plan.smoothed.points(), &header));
        self.published_plans = plans.len();
        if now_s - self.markers_s >= MARKER_INTERVAL_S {
            self.markers_s = now_s;
            let counts = decision.counts.as_ref();
            let fan = counts.and_then(|_| navigator.planner().trajectory_fan(SAMPLING));
            let moving = navigator.obstacle_model().moving();
            let markers = markers(fan.as_ref(), moving, &header, MARKER_LIFETIME);
            outgoing.markers = Some(markers);
        }
    }
}
