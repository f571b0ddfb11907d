//! Planning problems in a part of a scenario: where and when they begin, and which goals are left.

use crate::scenario::{
    Ego, Goal, LaneletNetwork, PlanningProblem, Position, Quantity, State, StateField, Steps,
};
use nearmiss_base::geometry::angle_between;

use super::area::Near;
use super::time::Cut;

/// The planning problems that are kept, and what is said of the others.
pub(super) struct Problems<'a> {
    cut: &'a Cut,
    near: Option<&'a Near>,
    /// The ego in the time that is kept, by new steps.
    ego: Option<&'a Ego>,
    network: &'a LaneletNetwork,
    /// A sentence for each problem that begins elsewhere or is gone.
    pub said: Vec<String>,
}

impl<'a> Problems<'a> {
    pub fn new(
        cut: &'a Cut,
        near: Option<&'a Near>,
        ego: Option<&'a Ego>,
        network: &'a LaneletNetwork,
    ) -> Self {
        Self {
            cut,
            near,
            ego,
            network,
            said: Vec::new(),
        }
    }

    pub fn kept(&mut self, all: &[PlanningProblem]) -> Vec<PlanningProblem> {
        let mut kept = Vec::new();
        for problem in all {
            match self.problem(problem, all.len() == 1) {
                Ok(problem) => kept.push(problem),
                Err(why) => {
                    let id = problem.id;
                    self.said
                        .push(format!("planning problem {id} is left out: {why}"));
                }
            }
        }
        kept
    }

    /// The problem, or why it is gone.
    fn problem(
        &mut self,
        problem: &PlanningProblem,
        alone: bool,
    ) -> Result<PlanningProblem, String> {
        let steps = self.cut.steps();
        let started = problem.initial.time.from;
        if started > *steps.end() {
            return Err(format!("it starts at step {started}"));
        }
        let begins = started.max(*steps.start());
        let mut initial = problem.initial.clone();
        if started < begins {
            let ego = self.ego.filter(|ego| alone || ego.id == problem.id);
            let there = ego
                .and_then(|ego| departing(&initial, ego, self.cut.numbered(begins), self.cut.dt));
            initial = there.ok_or_else(|| {
                format!(
                    "it starts at step {started}, and no ego tells where it is at step {begins}"
                )
            })?;
        } else {
            initial.time = Steps {
                from: self.cut.numbered(initial.time.from),
                to: self.cut.numbered(initial.time.to),
            };
        }
        let start = initial.middle();
        if let (Some(near), Some(start)) = (self.near, start)
            && !near.holds(&start)
        {
            return Err("it starts outside the area".into());
        }
        let left = |goal| self.goal(goal, started, begins);
        let goals: Vec<Goal> = problem.goals.iter().filter_map(left).collect();
        if goals.is_empty() && !problem.goals.is_empty() {
            return Err("its goal is outside".into());
        }
        if started < begins {
            self.said.push(format!(
                "planning problem {} starts with the ego at step {begins}",
                problem.id
            ));
        }
        Ok(PlanningProblem {
            id: problem.id,
            initial,
            goals,
        })
    }

    /// The goal of a problem that begins at a step; nothing where its time is over then, or where it is outside.
    fn goal(&self, goal: &Goal, started: i64, begins: i64) -> Option<Goal> {
        let mut kept = goal.clone();
        if started < begins {
            if goal.time.to <= begins {
                return None;
            }
            kept.time.from = goal.time.from.max(begins);
        }
        kept.time.from = self.cut.numbered(kept.time.from);
        kept.time.to = self.cut.numbered(kept.time.to);
        if let Some(near) = self.near {
            let left = |position: &Position| near.position(position, self.network);
            kept.positions = goal.positions.iter().filter_map(left).collect();
            if kept.positions.is_empty() && !goal.positions.is_empty() {
                return None;
            }
        }
        Some(kept)
    }
}

/// A start with the ego at a step, of `dt` seconds; nothing where it is not there.
fn departing(start: &State, ego: &Ego, step: i64, dt: f64) -> Option<State> {
    let motion = ego.track.at(step)?;
    let heading = motion.pose.heading;
    let next = ego.track.at(step + 1);
    let turned = next.map_or(0.0, |next| angle_between(heading, next.pose.heading));
    let exact = |value: f64| Some(Quantity::Exact(value));
    // What else was said would not be true of this step; these two a start has to say.
    let more = [
        (StateField::YawRate, turned / dt),
        (StateField::SlipAngle, 0.0),
    ];
    let said = more
        .into_iter()
        .filter(|(field, _)| start.quantity(*field).is_some());
    Some(State {
        position: Some(Position::Point(motion.pose.position)),
        orientation: exact(heading),
        velocity: exact(motion.velocity),
        acceleration: start.acceleration.and(exact(motion.acceleration)),
        more: said.map(|(f, value)| (f, Quantity::Exact(value))).collect(),
        ..State::at(Steps::exact(step))
    })
}
