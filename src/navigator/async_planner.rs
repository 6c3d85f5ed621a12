//! Planning beside the control loop: asked for at one tick, taken at a later one.
//!
//! A search of a large map takes longer than a tick has. It runs on a thread of its own, over obstacles that it was told
//! of; meanwhile the robot follows the plan it has. So that a run can be replayed bit for bit, a plan is taken at the
//! tick for which it was promised, however soon the thread was done with it.

use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

use super::{Fault, RoutePlanner};
use crate::geometry::Point;
use crate::global::{Plan, PlanError};
use crate::map::ObstacleGrid;

/// What a plan is asked for.
#[derive(Clone, Debug)]
pub(super) struct PlanRequest {
    /// Where it begins.
    pub start: Point,
    /// Where it ends.
    pub goal: Point,
    /// Places of obstacles that the map does not show.
    pub marks: Vec<Point>,
    /// Discs, centre and radius in metres, that count as obstacles too.
    pub discs: Vec<(Point, f64)>,
}

/// A planner on a thread of its own. It takes one order at a time; the thread ends when this is dropped.
#[derive(Debug)]
pub(super) struct AsyncPlanner<R> {
    orders: Sender<PlanRequest>,
    plans: Receiver<Result<Plan, PlanError>>,
    pending: Option<Pending<R>>,
}

/// An order on its way.
#[derive(Debug)]
struct Pending<R> {
    reason: R,
    due_s: f64,
}

impl<R> AsyncPlanner<R> {
    /// Starts the thread.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn new(known: ObstacleGrid, planner: RoutePlanner) -> Result<Self, Fault> {
        let (orders, taken) = channel();
        let (done, plans) = channel();
        std::thread::Builder::new()
            .name("inbye-planner".to_owned())
            .spawn(move || work(&known, planner, &taken, &done))
            .map_err(|error| Fault::NoThread {
                reason: error.to_string(),
            })?;
        Ok(Self {
            orders,
            plans,
            pending: None,
        })
    }

    /// Whether an order is on its way.
    pub const fn is_busy(&self) -> bool {
        self.pending.is_some()
    }

    /// Hands over an order whose plan is to be taken from a time on, for a reason that is given back with it. One more
    /// while another is on its way is passed over.
    pub fn ask(&mut self, order: PlanRequest, reason: R, due_s: f64) {
        if !self.is_busy() && self.orders.send(order).is_ok() {
            self.pending = Some(Pending { reason, due_s });
        }
    }

    /// Drops what is on its way: its plan, when it comes, is nobody's.
    pub fn forget(&mut self) {
        if self.pending.take().is_some() {
            // The thread answers each order once; the next answer belongs to the next order.
            let _ = self.plans.recv();
        }
    }

    /// The plan on its way, if it is due. Where it is not there yet, `waits` says whether to wait for it.
    pub fn due(&mut self, now_s: f64, waits: bool) -> Option<(R, Result<Plan, PlanError>)> {
        let pending = self.pending.take_if(|pending| now_s >= pending.due_s)?;
        let answer = if waits {
            self.plans.recv().map_err(|_| TryRecvError::Disconnected)
        } else {
            self.plans.try_recv()
        };
        match answer {
            Ok(plan) => Some((pending.reason, plan)),
            Err(TryRecvError::Empty) => {
                self.pending = Some(pending);
                None
            }
            Err(TryRecvError::Disconnected) => None,
        }
    }
}

fn work(
    known: &ObstacleGrid,
    mut planner: RoutePlanner,
    orders: &Receiver<PlanRequest>,
    plans: &Sender<Result<Plan, PlanError>>,
) {
    for order in orders {
        let obstacles = with_unknown(known, &order);
        let plan = planner.plan(&obstacles, order.start, order.goal, &mut || 0.0);
        if plans.send(plan).is_err() {
            return;
        }
    }
}

/// The map with what it does not show.
fn with_unknown(known: &ObstacleGrid, order: &PlanRequest) -> ObstacleGrid {
    let mut all = known.clone();
    let frame = *all.frame();
    for mark in &order.marks {
        if let Some(cell) = frame.cell_of(mark) {
            all.set(cell, true);
        }
    }
    for (center, radius_m) in &order.discs {
        all.fill_disc(center, *radius_m);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::global::Settings;
    use crate::map::GridFrame;
    use crate::navigator::NavigatorSettings;
    use crate::robot::Footprint;

    fn background() -> AsyncPlanner<u32> {
        let frame = GridFrame::new(60, 40, 0.1, Pose::default()).expect("a sound size");
        let known = ObstacleGrid::new(frame, vec![false; frame.len()]);
        let footprint = Footprint::round(0.3).expect("a sound radius");
        let settings = NavigatorSettings::default();
        let planner = RoutePlanner::new(&footprint, &settings, Settings::default(), 0.1);
        AsyncPlanner::new(known, planner).expect("a thread")
    }

    fn order(discs: Vec<(Point, f64)>) -> PlanRequest {
        PlanRequest {
            start: Point::new(1.0, 2.0),
            goal: Point::new(5.0, 2.0),
            marks: vec![],
            discs,
        }
    }

    #[test]
    fn a_plan_is_taken_when_it_is_due_and_not_before() {
        let mut background = background();
        background.ask(order(vec![]), 7, 1.0);
        background.ask(order(vec![]), 8, 0.0);
        assert!(background.is_busy());
        assert!(background.due(0.9, true).is_none() && background.is_busy());
        let (reason, plan) = background.due(1.0, true).expect("it was promised");
        assert_eq!((reason, background.is_busy()), (7, false));
        let straight_m = plan.expect("a way").smoothed.length_m();
        // What is asked for next is answered next, with what stands in the way.
        background.ask(order(vec![(Point::new(3.0, 1.8), 0.5)]), 9, 2.0);
        let (reason, plan) = background.due(2.0, true).expect("it was promised");
        assert_eq!(reason, 9);
        assert!(plan.expect("a way round").smoothed.length_m() > straight_m + 0.1);
    }

    #[test]
    fn a_forgotten_plan_is_not_taken_for_the_next_one() {
        let mut background = background();
        background.ask(order(vec![(Point::new(3.0, 1.8), 0.5)]), 1, 1.0);
        background.forget();
        assert!(background.due(5.0, true).is_none());
        background.ask(order(vec![]), 2, 1.0);
        let (reason, plan) = background.due(1.0, true).expect("it was promised");
        let length_m = plan.expect("a way").smoothed.length_m();
        assert!(reason == 2 && length_m < 4.1, "{reason}, {length_m}");
    }

    #[test]
    fn one_that_does_not_wait_gets_the_plan_later() {
        let mut background = background();
        background.ask(order(vec![]), 3, 0.0);
        let mut tries = 0_u64;
        while background.due(0.0, false).is_none() {
            tries += 1;
            assert!(background.is_busy() && tries < u64::MAX);
            std::thread::yield_now();
        }
        assert!(!background.is_busy());
    }
}
