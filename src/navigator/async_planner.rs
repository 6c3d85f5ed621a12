//! Global planning on its own thread.
//!
//! A search of a large map takes longer than a tick. The thread plans over the obstacles of a request; meanwhile the robot
//! follows the plan it has. A plan is delivered at the tick for which it was promised, however early the thread finished,
//! so that a run can be replayed bit for bit.

use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::time::Duration;

use super::global_planner::checked_plan;
use super::{Fault, GlobalPlanner};
use crate::geometry::Point;
use crate::global::{Plan, PlanError};
use crate::map::{MovingDisc, ObstacleGrid};

/// Longest wait for an external planner at the end of a mission.
const END_WAIT: Duration = Duration::from_secs(5);

/// What to plan.
#[derive(Clone, Debug)]
pub(super) struct PlanRequest {
    /// First point of the path.
    pub start: Point,
    /// Last point of the path.
    pub goal: Point,
    /// Obstacles that are not in the map.
    pub marks: Vec<Point>,
    /// Moving obstacles that count as obstacles where they are.
    pub discs: Vec<MovingDisc>,
    /// Obstacles that may not stay.
    pub transient: Vec<MovingDisc>,
}

/// A request and its answer carry the same number.
type Answer = (u64, Result<Plan, PlanError>);

/// A planner on its own thread. It takes one request at a time; the thread ends when this is dropped.
#[derive(Debug)]
pub(super) struct AsyncPlanner<R> {
    requests: Option<Sender<(u64, PlanRequest)>>,
    answers: Receiver<Answer>,
    /// How an external planner ended; none for a planner of this process.
    ended: Option<Receiver<Result<(), PlanError>>>,
    /// Number of the last request.
    number: u64,
    /// Reason of the pending request, and the time when its plan is due, seconds.
    pending: Option<(R, f64)>,
}

impl<R> AsyncPlanner<R> {
    /// Starts the thread.
    ///
    /// # Errors
    /// When the operating system starts no thread.
    pub fn new(known: ObstacleGrid, planner: Box<dyn GlobalPlanner>) -> Result<Self, Fault> {
        let (requests, received) = channel();
        let (done, answers) = channel();
        let (end, ended) = channel();
        let ended = planner.is_external().then_some(ended);
        std::thread::Builder::new()
            .name("inbye-planner".to_owned())
            .spawn(move || {
                let mut planner = planner;
                work(&known, &mut *planner, &received, &done);
                // The planner ends also where no receiver waits.
                let _ = end.send(planner.finish());
            })
            .map_err(|error| Fault::NoThread { reason: error.to_string() })?;
        Ok(Self { requests: Some(requests), answers, ended, number: 0, pending: None })
    }

    /// Whether a request is pending.
    pub const fn is_busy(&self) -> bool {
        self.pending.is_some()
    }

    /// Requests a plan that is due at a time, seconds; [`Self::due`] returns the reason with it. Ignores a second request
    /// while one is pending.
    pub fn request(&mut self, request: PlanRequest, reason: R, due_s: f64) {
        if self.is_busy() {
            return;
        }
        self.number += 1;
        if let Some(requests) = &self.requests {
            // Where the thread has ended, the answer that is due says so.
            let _ = requests.send((self.number, request));
            self.pending = Some((reason, due_s));
        }
    }

    /// Ends the thread. Waits for an external planner; one that searches for longer than [`END_WAIT`] counts as sound.
    ///
    /// # Errors
    /// As [`GlobalPlanner::finish`].
    pub fn finish(&mut self) -> Result<(), PlanError> {
        (self.requests, self.pending) = (None, None);
        self.ended.take().map_or(Ok(()), |ended| ended.recv_timeout(END_WAIT).unwrap_or(Ok(())))
    }

    /// Drops the pending request. Its answer is dropped when it arrives: a control loop waits for no search.
    pub fn cancel(&mut self) {
        self.pending = None;
    }

    /// Returns the plan that is due. Where the thread has not finished it, `waits` sets whether to wait for it.
    pub fn due(&mut self, now_s: f64, waits: bool) -> Option<(R, Result<Plan, PlanError>)> {
        let pending = self.pending.take_if(|(_, due_s)| now_s >= *due_s)?;
        let next = || {
            if waits {
                self.answers.recv().map_err(|_| TryRecvError::Disconnected)
            } else {
                self.answers.try_recv()
            }
        };
        let mut answer = next();
        // Cancelled requests are answered first.
        while matches!(answer, Ok((number, _)) if number != self.number) {
            answer = next();
        }
        match answer {
            Ok((_, plan)) => Some((pending.0, plan)),
            Err(TryRecvError::Empty) => {
                self.pending = Some(pending);
                None
            }
            // The thread has ended: the planner panicked.
            Err(TryRecvError::Disconnected) => {
                let name = "the global planner".to_owned();
                let reason = "it panicked".to_owned();
                Some((pending.0, Err(PlanError::InvalidPlanner { name, reason })))
            }
        }
    }
}

fn work(
    known: &ObstacleGrid,
    planner: &mut dyn GlobalPlanner,
    requests: &Receiver<(u64, PlanRequest)>,
    answers: &Sender<Answer>,
) {
    for (number, request) in requests {
        let obstacles = with_unknown(known, &request);
        let ends = [request.start, request.goal];
        let plan = checked_plan(planner, &obstacles, &request.transient, ends, &mut || 0.0);
        if answers.send((number, plan)).is_err() {
            return;
        }
    }
}

/// The map with the obstacles of a request.
fn with_unknown(known: &ObstacleGrid, request: &PlanRequest) -> ObstacleGrid {
    let mut all = known.clone();
    let frame = *all.frame();
    for mark in &request.marks {
        if let Some(cell) = frame.cell_of(mark) {
            all.set(cell, true);
        }
    }
    for disc in &request.discs {
        all.fill_disc(&disc.center(), disc.radius);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::global::Settings;
    use crate::map::GridFrame;
    use crate::navigator::{NavigatorSettings, RoutePlanner};
    use crate::robot::Footprint;

    fn on_open_ground(planner: Box<dyn GlobalPlanner>) -> AsyncPlanner<u32> {
        let frame = GridFrame::new(60, 40, 0.1, Pose::default()).expect("a valid size");
        AsyncPlanner::new(ObstacleGrid::filled(frame, false), planner).expect("a thread")
    }

    fn async_planner() -> AsyncPlanner<u32> {
        let footprint = Footprint::round(0.3).expect("a valid radius");
        let settings = NavigatorSettings::default();
        let route_planner = RoutePlanner::new(&footprint, &settings, Settings::default(), 0.1);
        on_open_ground(Box::new(route_planner))
    }

    fn request(discs: Vec<MovingDisc>) -> PlanRequest {
        PlanRequest {
            start: Point::new(1.0, 2.0),
            goal: Point::new(5.0, 2.0),
            marks: vec![],
            discs,
            transient: vec![],
        }
    }

    const DISC: MovingDisc = MovingDisc { x: 3.0, y: 1.8, radius: 0.5, vx: 0.0, vy: 0.0 };

    #[test]
    fn planner_that_panicked_is_an_invalid_planner_at_each_request() {
        struct Panics;
        impl GlobalPlanner for Panics {
            fn plan(
                &mut self,
                _: &ObstacleGrid,
                _: &[MovingDisc],
                _: Point,
                _: Point,
                _: &mut dyn FnMut() -> f64,
            ) -> Result<Plan, PlanError> {
                panic!("as a planner of the user's own")
            }

            fn least_radius_m(&self) -> f64 {
                0.3
            }
        }
        let mut planner = on_open_ground(Box::new(Panics));
        for due_s in [1.0, 2.0] {
            planner.request(request(vec![]), 7, due_s);
            let (_, plan) = planner.due(due_s, true).expect("an answer is due");
            assert!(matches!(plan, Err(PlanError::InvalidPlanner { .. })), "{plan:?}");
        }
    }

    #[test]
    fn plan_is_delivered_when_due_and_not_before() {
        let mut planner = async_planner();
        planner.request(request(vec![]), 7, 1.0);
        planner.request(request(vec![]), 8, 0.0);
        assert!(planner.is_busy());
        assert!(planner.due(0.9, true).is_none() && planner.is_busy());
        let (reason, plan) = planner.due(1.0, true).expect("a plan is due");
        assert_eq!((reason, planner.is_busy()), (7, false));
        let straight_m = plan.expect("a path").smoothed.length_m();
        // The next answer is that of the next request, with its obstacle.
        planner.request(request(vec![DISC]), 9, 2.0);
        let (reason, plan) = planner.due(2.0, true).expect("a plan is due");
        assert_eq!(reason, 9);
        assert!(plan.expect("a detour").smoothed.length_m() > straight_m + 0.1);
    }

    #[test]
    fn cancelled_plan_is_not_delivered_for_the_next_request() {
        let mut planner = async_planner();
        planner.request(request(vec![DISC]), 1, 1.0);
        planner.cancel();
        assert!(planner.due(5.0, true).is_none());
        planner.request(request(vec![]), 2, 1.0);
        let (reason, plan) = planner.due(1.0, true).expect("a plan is due");
        let length_m = plan.expect("a path").smoothed.length_m();
        assert!(reason == 2 && length_m < 4.1, "{reason}, {length_m}");
    }

    /// A planner whose requests and answers a test handles in place of a thread.
    fn without_thread(
        requests: Sender<(u64, PlanRequest)>,
        answers: Receiver<Answer>,
    ) -> AsyncPlanner<i32> {
        AsyncPlanner { requests: Some(requests), answers, ended: None, number: 0, pending: None }
    }

    /// No answer comes, as during a search of a large map.
    #[test]
    fn cancelling_does_not_wait_for_the_thread() {
        let (requests, _received) = channel();
        let (_done, answers) = channel();
        let mut planner = without_thread(requests, answers);
        for reason in 0..3 {
            planner.request(request(vec![]), reason, 1.0);
            planner.cancel();
            assert!(!planner.is_busy() && planner.due(5.0, false).is_none());
        }
    }

    #[test]
    fn answers_to_cancelled_requests_are_dropped_however_late_they_are() {
        let (requests, received) = channel();
        let (done, answers) = channel();
        let mut planner = without_thread(requests, answers);
        planner.request(request(vec![DISC]), 1, 1.0);
        planner.cancel();
        planner.request(request(vec![]), 2, 1.0);
        let answer = |number| {
            let place = Point::new(5.0, 2.0);
            (number, Err(PlanError::GoalOutsideMap { place, why: String::new() }))
        };
        let numbers: Vec<u64> = received.try_iter().map(|(number, _)| number).collect();
        done.send(answer(numbers[0])).expect("a receiver");
        assert!(planner.due(1.0, false).is_none() && planner.is_busy());
        done.send(answer(numbers[1])).expect("a receiver");
        assert!(planner.due(1.0, false).is_some_and(|(reason, _)| reason == 2));
    }

    #[test]
    fn without_waiting_the_plan_is_delivered_later() {
        let mut planner = async_planner();
        planner.request(request(vec![]), 3, 0.0);
        let mut tries = 0_u64;
        while planner.due(0.0, false).is_none() {
            tries += 1;
            assert!(planner.is_busy() && tries < u64::MAX);
            std::thread::yield_now();
        }
        assert!(!planner.is_busy());
    }
}
