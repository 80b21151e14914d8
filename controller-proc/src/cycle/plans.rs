//! Requests of a cycle to the planner, and their answers.

use super::Cycle;
use crate::planning::{ANSWER_TICKS, PlanAnswer, PlanRequest, Planner};

/// A request for a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlanAsked {
    /// Its number, from 1 up.
    pub id: u64,
    /// Tick at which it was made.
    pub tick: u64,
}

impl Cycle {
    /// The request that waits for its answer.
    pub fn plan_request(&self) -> Option<PlanRequest> {
        self.controllers.arm.plan_request().cloned()
    }

    /// Number and tick of that request.
    pub fn plan_asked(&self) -> Option<PlanAsked> {
        let asked = |request: &PlanRequest| PlanAsked {
            id: request.id,
            tick: request.tick,
        };
        self.controllers.arm.plan_request().map(asked)
    }

    /// Copies that request into one that [`Cycle::empty_plan_request`] made. Allocates
    /// nothing.
    pub fn copy_plan_request(&self, into: &mut PlanRequest) {
        if let Some(request) = self.controllers.arm.plan_request() {
            into.copy_from(request);
        }
    }

    /// A request with room for any of this arm.
    pub fn empty_plan_request(&self) -> PlanRequest {
        self.controllers.arm.empty_plan_request()
    }

    /// Takes the answer to a request out of `slot`; the next update uses it. An answer to be
    /// dropped is left in the slot: memory is not freed in a cycle.
    pub fn answer_plan(&mut self, slot: &mut Option<PlanAnswer>) {
        self.controllers.arm.answer_plan(slot);
    }

    /// Answers the request that is due at `tick` with `planner`, as a process in lockstep
    /// does.
    pub fn plan_with(&mut self, planner: &mut Planner, tick: u64) {
        let due = |asked: PlanAsked| tick >= asked.tick + ANSWER_TICKS;
        if self.plan_asked().is_some_and(due)
            && let Some(request) = self.plan_request()
        {
            self.answer_plan(&mut Some(planner.answer(&request)));
        }
    }
}
