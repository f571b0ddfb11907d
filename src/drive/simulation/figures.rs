//! Figures of a drive: comfort, time to the goal, and what came near.

use std::sync::Arc;

use strum::{IntoStaticStr, VariantArray};

use super::{Collision, ContactSide, Outcome, Rollout, Settings};
use crate::planner::{Broken, Feasibility};
use nearmiss_scene::metrics::{Series, measure};
use nearmiss_scene::scenario::{PlanningProblem, Scenario, Scene};
use nearmiss_scene::traffic_rules::RuleReport;

/// Which body drove into which, after the sides that touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum CollisionKind {
    /// The ego's front touches: it ran into the obstacle.
    RanInto,
    /// The obstacle's front touches the ego's rear: the ego was rear-ended, in recorded traffic by an obstacle that
    /// does not see it.
    RearEnded,
    /// Neither: a side of the ego, or its rear by another side than the front.
    Side,
}

nearmiss_record::named!(CollisionKind);

impl Collision {
    /// Which body drove into which.
    #[must_use]
    pub fn kind(&self) -> CollisionKind {
        match (self.ego, self.other) {
            (ContactSide::Front, _) => CollisionKind::RanInto,
            (ContactSide::Rear, ContactSide::Front) => CollisionKind::RearEnded,
            _ => CollisionKind::Side,
        }
    }
}

/// What of a drive is beyond the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeyondVehicle {
    /// Steps at which a limit is broken.
    pub steps: usize,
    /// The first of them, with the limit that is broken most there, relative to its value.
    pub first: Broken,
    /// Of all steps the limit that is broken most.
    pub worst: Broken,
}

impl std::fmt::Display for BeyondVehicle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (steps, worst) = (self.steps, &self.worst);
        let plural = if steps == 1 { "" } else { "s" };
        let (name, unit) = (worst.bound.name(), worst.bound.unit());
        write!(
            f,
            "{steps} step{plural} beyond the vehicle, worst: {name} {:.2} {unit} at step {}, at most {:.2}",
            worst.value, worst.step, worst.most
        )
    }
}

/// Risk scores at which an obstacle counts as a near miss: 1, or 0 without a contact at a step.
const NEAR_MISS: u8 = 1;

impl Rollout {
    /// Absolute values of the change of acceleration from step to step, m/s³: mean and largest; `None` for fewer than
    /// three states.
    #[must_use]
    pub fn jerk(&self) -> Option<(f64, f64)> {
        let pairs = self.states.windows(2).skip(1);
        // The first state is the scenario's: what a planner makes of its acceleration is no jerk of the planner.
        let jerks = pairs.map(|pair| (pair[1].1.acceleration - pair[0].1.acceleration).abs());
        let jerks: Vec<f64> = jerks.map(|change| change / self.dt).collect();
        let most = jerks.iter().copied().max_by(f64::total_cmp)?;
        Some((jerks.iter().sum::<f64>() / jerks.len() as f64, most))
    }

    /// The strongest braking, m/s²; 0 without braking.
    #[must_use]
    pub fn largest_deceleration(&self) -> f64 {
        let states = self.states.iter();
        states.map(|(_, s)| -s.acceleration).fold(0.0, f64::max)
    }

    /// Seconds from the start to the goal; `None` for a drive that does not reach it.
    #[must_use]
    pub fn seconds_to_goal(&self) -> Option<f64> {
        let steps = self.states.len().saturating_sub(1);
        matches!(self.outcome, Outcome::Goal(_)).then(|| steps as f64 * self.dt)
    }

    /// The steps of the drive that the vehicle cannot do; `None` where it can do all.
    #[must_use]
    pub fn beyond_vehicle(&self) -> Option<BeyondVehicle> {
        let broken = self.undrivable();
        let first_step = broken.first()?.step;
        let worst = |among: &mut dyn Iterator<Item = &Broken>| {
            // Of equals the first.
            let all = among.copied();
            all.reduce(|a, b| if b.excess() > a.excess() { b } else { a })
        };
        let mut steps: Vec<i64> = broken.iter().map(|one| one.step).collect();
        steps.dedup();
        Some(BeyondVehicle {
            steps: steps.len(),
            first: worst(&mut broken.iter().filter(|one| one.step == first_step))?,
            worst: worst(&mut broken.iter())?,
        })
    }

    /// What of the drive the vehicle cannot do, in order; empty where it can do all.
    #[must_use]
    pub fn undrivable(&self) -> Vec<Broken> {
        let first = self.states.first().map_or(0, |(step, _)| *step);
        let states: Vec<_> = self.states.iter().map(|(_, state)| *state).collect();
        match Feasibility::new(self.limits, self.dt).states(first, &states) {
            Ok(_) => Vec::new(),
            Err(error) => error.0,
        }
    }

    /// Obstacles whose risk score is 1 or 0 at some step of the drive, without the one that is touched at its end.
    #[must_use]
    pub fn near_misses(
        &self,
        scenario: &Arc<Scenario>,
        problem: &PlanningProblem,
        settings: &Settings,
    ) -> Vec<i64> {
        let scene = self.scene(scenario, problem, settings);
        let series = Series::compute(&scene, measure("risk").into_iter().collect());
        let near = |id: &i64| {
            let mut readings = series.row("risk", *id).iter();
            let is_near = readings.any(|r| r.value().is_some_and(|v| v as u8 <= NEAR_MISS));
            is_near && !self.touches(*id)
        };
        let ids = scene.scenario.obstacles.iter().map(|o| o.id);
        ids.filter(near).collect()
    }

    /// Which rules of the road applied, and which were broken. They are not judged where a step ends that the vehicle
    /// cannot do: speed and place there are none that the ego could have.
    #[must_use]
    pub fn rules(
        &self,
        scenario: &Arc<Scenario>,
        problem: &PlanningProblem,
        settings: &Settings,
    ) -> RuleReport {
        let report = RuleReport::from_scene(&self.scene(scenario, problem, settings));
        // An acceleration is that of the step behind a state or of the one before it.
        let broken = self.undrivable();
        let steps = broken.iter().flat_map(|one| [one.step, one.step + 1]);
        report.unjudged_at(&steps.collect(), "the ego moves there as no vehicle can")
    }

    /// The scene of the drive, without the obstacle whose place the ego takes.
    fn scene(
        &self,
        scenario: &Arc<Scenario>,
        problem: &PlanningProblem,
        settings: &Settings,
    ) -> Scene {
        let scenario = match settings.without {
            Some(gone) => {
                let mut others = Scenario::clone(scenario);
                others.obstacles.retain(|o| o.id != gone);
                Arc::new(others)
            }
            None => Arc::clone(scenario),
        };
        Scene::new(scenario, self.ego(problem, settings))
    }
}
