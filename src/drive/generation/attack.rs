//! An attack: changed motions that passed the gate, and the ego's response to them; what an attack starts from.

use std::sync::Arc;

use nearmiss_base::geometry::{Footprint, Point, Polyline, Pose};
use nearmiss_scene::scenario::prediction::{Model, ObservedHistory, Predictor};
use nearmiss_scene::scenario::{self, Obstacle, Scenario, Track};
use nearmiss_scene::verdict::Motion;

use super::{
    AttackStyle, Avoidability, Change, ClosedLoop, Consequence, Effect, Gate, JointChange,
    OpenLoopScreening, Reason, RecordedMotions, Refusal, StagedDrive,
};

/// An attack that has passed the gate.
#[derive(Debug, Clone)]
pub struct Attack {
    /// The motions requested of the attackers, in the order of the change.
    pub asked: Vec<Motion>,
    /// Their motions.
    pub change: JointChange,
    /// How near the last attacker comes to an ego that only brakes.
    pub rehearsal: OpenLoopScreening,
    /// How far the motions are from recorded ones on average, 0 where that does not matter; see
    /// [`RecordedMotions::deficit`](super::RecordedMotions::deficit).
    pub implausibility: f64,
    /// Its effect on the ego, if it was driven.
    pub effect: Option<Effect>,
    /// Whether an ideal driver survives it with the reaction time that is asked for, where that was looked for.
    pub survivable: Option<bool>,
}

/// Shared input of attacks, and the checks they must pass.
#[derive(Debug)]
pub struct AttackSetup<'a> {
    /// The scenario with the ego's motion: the original, or one with an attack by others in it.
    pub stage: &'a AttackContext<'a>,
    /// The gate that every motion must pass in it.
    pub gate: &'a Gate<'a>,
    /// The closed loop of the ego.
    pub closed_loop: &'a ClosedLoop,
}

/// An attack ends this long after its closest approach to the ego, seconds.
const OVER: f64 = 2.0;

/// Added cost of an attack that cannot be survived, or in which not every attacker is needed.
const HOPELESS: f64 = 3.2;

/// The ego is driven for so long after the attack should be nearest, seconds: it slows down before that.
const SECONDS_AFTER_ATTACK: f64 = 3.0;

/// Added cost of an attacker that comes near only from behind.
const FROM_BEHIND: f64 = 2.0;

/// Added cost of a motion unlike all recorded ones.
const STRANGE: f64 = 0.8;

/// A motion that is nowhere farther from the recorded one than this, metres, and no faster or slower than
/// [`SAME_SPEED`], is that one.
pub const SAME_PLACE: f64 = 0.1;

/// The same for speeds, m/s.
pub const SAME_SPEED: f64 = 0.1;

/// Added cost of an attack that was only screened and not driven yet.
const UNTRIED: f64 = 0.8;

impl AttackSetup<'_> {
    /// The obstacle with this id.
    ///
    /// # Errors
    /// It does not exist.
    pub fn obstacle(&self, id: i64) -> Result<&Obstacle, Refusal> {
        let found = self.stage.scenario.obstacle(id);
        found.ok_or_else(|| Refusal::answer(format!("no obstacle {id} in the scenario")))
    }

    /// The attack with a motion beside those of the others, if it meets the ego and passes the gate. The ego is not
    /// driven yet.
    ///
    /// # Errors
    /// The first reason why not.
    pub fn attack(&self, asked: Motion, change: Change) -> Result<Attack, Refusal> {
        let obstacle = self.obstacle(change.obstacle)?;
        let rehearsal = OpenLoopScreening::evaluate(self.stage, obstacle, &change)
            .ok_or_else(|| Refusal::answer("never present together with the ego"))?;
        let change = self.admitted(change, &rehearsal)?;
        if is_as_recorded(obstacle, &change) {
            return Err(Refusal::whole_motion(Reason::Unchanged));
        }
        let recorded = self.stage.recorded.as_deref();
        let implausibility = recorded.map_or(0.0, |recorded| recorded.deficit(&change.motions));
        let alone = Attack {
            asked: vec![asked],
            change: change.into(),
            rehearsal,
            implausibility,
            effect: None,
            survivable: None,
        };
        match self.stage.others {
            Some((others, _)) => others.joined_by(alone),
            None => Ok(alone),
        }
    }

    /// Drives the ego against an attack, until that should be over.
    pub fn drive(&self, attack: &mut Attack) {
        attack.effect = self.effect(&attack.change, self.enough(attack));
    }

    /// The same with an ego whose planner has fewer samples: for a search that drives against many attacks and the best
    /// of them again.
    /// Returns what that took, see [`Effect::work`].
    pub(super) fn drive_coarsely(&self, attack: &mut Attack) -> usize {
        let (before, until) = (self.before(), self.enough(attack));
        let effect = self
            .closed_loop
            .coarse_effect_until(&attack.change, before, until);
        attack.effect = effect.ok();
        attack.effect.as_ref().map_or(0, Effect::work)
    }

    /// The step after which nothing is expected of an attack any more.
    fn enough(&self, attack: &Attack) -> i64 {
        let others = self.stage.others.map(|(others, _)| others.rehearsal.step);
        let nearest = attack.rehearsal.step.max(others.unwrap_or(i64::MIN));
        nearest + (SECONDS_AFTER_ATTACK / self.stage.dt()).ceil() as i64
    }

    /// Drives the ego against it to the end, and looks whether each attacker is needed, the drivers `preventable_by` avoid
    /// it, and an ideal driver survives it with a reaction time of `delay` seconds. Returns what that took, see
    /// [`Effect::work`].
    pub fn survive(&self, attack: &mut Attack, delay: f64, preventable_by: &[&str]) -> usize {
        attack.effect = self.effect(&attack.change, i64::MAX);
        let mut work = attack.effect.as_ref().map_or(0, Effect::work);
        let has_effect = attack.has_effect();
        let Some(effect) = attack.effect.as_mut().filter(|_| has_effect) else {
            return work;
        };
        let left_out = self.closed_loop.leave_each_out(effect, &attack.change);
        let is_needed = left_out.is_ok() && effect.needs_all() != Some(false);
        if is_needed && !effect.is_preventable_by(self.closed_loop, preventable_by) {
            attack.survivable = Some(false);
        } else if is_needed {
            let certificate = Avoidability::with(self.closed_loop, effect, delay);
            attack.survivable = Some(certificate.avoidance().is_some());
            work += certificate.searched().work();
        }
        work
    }

    fn effect(&self, change: &JointChange, until: i64) -> Option<Effect> {
        let effect = self.closed_loop.effect_until(change, self.before(), until);
        effect.ok()
    }

    /// The drive whose cycles are taken over while nothing has changed.
    fn before(&self) -> &StagedDrive {
        let recorded = self.closed_loop.baseline().staged();
        self.stage.others.map_or(recorded, |(_, drive)| drive)
    }

    /// The step after which an attack is over.
    pub(super) fn over(&self, seen: &OpenLoopScreening) -> i64 {
        seen.step + (OVER / self.stage.dt()).ceil() as i64
    }

    /// The change as it passes the gate. Where it would overlap an obstacle or leave the road only long after it was
    /// nearest to the ego, the attacker's motion ends before that: the others do not answer to it, and it is gone.
    fn admitted(&self, mut change: Change, seen: &OpenLoopScreening) -> Result<Change, Refusal> {
        let over = self.over(seen);
        loop {
            let refusal = match self.gate.passes(&change, None) {
                Ok(_) => return Ok(change),
                Err(refusal) => refusal,
            };
            let late = refusal.step.filter(|step| *step > over);
            let Some(step) =
                late.filter(|_| matches!(refusal.reason, Reason::Overlap(_) | Reason::OffRoad))
            else {
                return Err(refusal);
            };
            let before = change.motions.len();
            change.motions.retain(|(s, _)| *s < step);
            if change.motions.len() == before {
                return Err(refusal);
            }
        }
    }
}

/// Whether an obstacle moves as recorded, but for what cannot be seen.
fn is_as_recorded(obstacle: &Obstacle, change: &Change) -> bool {
    let track = obstacle.track();
    change.motions.iter().all(|(step, motion)| {
        track.at(*step).is_some_and(|recorded| {
            let moved = (motion.pose.position - recorded.pose.position).norm();
            moved <= SAME_PLACE && (motion.velocity - recorded.velocity).abs() <= SAME_SPEED
        })
    })
}

impl Attack {
    /// Of each attacker the requested motion and the change.
    pub fn acts(&self) -> impl Iterator<Item = (&Motion, &Change)> {
        self.asked.iter().zip(self.change.changes())
    }

    /// How hard its contact is, for comparisons: the more, the harder; less than nothing without a contact that counts.
    #[must_use]
    pub fn severity(&self) -> f64 {
        match &self.effect {
            Some(effect) if matches!(effect.consequence, Consequence::Collision(_)) => {
                effect.impact.map_or(0.0, |impact| impact.rank)
            }
            _ => -1.0,
        }
    }

    /// Whether the others come to as much without one of its attackers.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        let needed = self.effect.as_ref().and_then(Effect::needs_all);
        needed == Some(false)
    }

    /// The attack of these obstacles and another one together; neither effect holds for it.
    fn joined_by(&self, other: Self) -> Result<Self, Refusal> {
        let (many, more) = (self.asked.len() as f64, other.asked.len() as f64);
        let sum = many * self.implausibility + more * other.implausibility;
        let mut change = self.change.clone();
        for one in other.change.changes() {
            let joined = change.with(one.clone());
            change = joined.map_err(|why| Refusal::whole_motion(Reason::Obstacle(why)))?;
        }
        Ok(Self {
            asked: self.asked.iter().cloned().chain(other.asked).collect(),
            change,
            implausibility: sum / (many + more),
            ..other
        })
    }

    /// Whether the ego, where it was driven, was touched by an attacker or nearly so, and not just hit from behind.
    #[must_use]
    pub fn has_effect(&self) -> bool {
        let effect = self.effect.as_ref();
        effect.is_some_and(|effect| match effect.consequence {
            Consequence::Collision(_) | Consequence::NearMiss => true,
            // Neither touched nor nearly so.
            Consequence::PlannerError(_) | Consequence::NoEffect => false,
        })
    }

    /// How good it looks before it is driven, the less the better.
    #[must_use]
    pub fn hoped(&self) -> f64 {
        UNTRIED + self.rehearsal.cost() + self.strangeness()
    }

    /// What is added to the cost of a motion unlike recorded ones: less than a collision is better than a
    /// near miss.
    fn strangeness(&self) -> f64 {
        STRANGE * (1.0 - (-self.implausibility).exp())
    }

    /// How good it is, the less the better: below 0 where the ego was driven and did not get away.
    #[must_use]
    pub fn cost(&self) -> f64 {
        match self.effect {
            Some(_) => self.harmlessness() + self.strangeness(),
            None => self.hoped(),
        }
    }

    /// The same however plausible it is.
    #[must_use]
    pub fn harmlessness(&self) -> f64 {
        let Some(effect) = &self.effect else {
            return UNTRIED + self.rehearsal.cost();
        };
        let hopeless = if self.survivable == Some(false) || self.is_idle() {
            HOPELESS
        } else {
            0.0
        };
        hopeless
            + match effect.consequence {
                Consequence::Collision(_) => -3.0,
                Consequence::NearMiss => -2.0,
                // A little better than none: a search for collisions is not to be about errors.
                Consequence::PlannerError(_) => 0.25,
                // All of them have to come near.
                Consequence::NoEffect => {
                    let far = |distance: Option<f64>, risk: Option<f64>| {
                        let distance = distance.unwrap_or(20.0).min(20.0);
                        let risk = risk.unwrap_or(5.0);
                        0.5 + 0.1 * distance + 0.5 * (risk - 1.0).max(0.0)
                    };
                    let all = effect.attackers.iter().map(|attacker| {
                        let at_all = far(attacker.distance, attacker.unrounded);
                        let in_view = far(attacker.distance_in_view, attacker.unrounded_in_view);
                        in_view.min(at_all + FROM_BEHIND)
                    });
                    all.sum::<f64>() / effect.attackers.len().max(1) as f64
                }
            }
    }
}

/// The scenario with the ego's motion in it.
#[derive(Debug)]
pub struct AttackContext<'a> {
    /// The original scenario, or one with an attack by others in it.
    pub scenario: &'a Scenario,
    /// The ego's body.
    pub footprint: &'a Footprint,
    /// The ego's motion while no further obstacle attacks it.
    pub ego: &'a Track,
    /// The way of the ego's centre, straight on beyond its ends.
    pub line: Polyline,
    /// First and last step of the ego.
    pub steps: std::ops::RangeInclusive<i64>,
    /// The attack by others that goes on in the scenario, if there is one, and the ego's drive against it.
    pub others: Option<(&'a Attack, &'a StagedDrive)>,
    /// How attackers move.
    pub style: AttackStyle,
    /// Recorded motions that attacks are to be like; `None` where that does not matter.
    pub recorded: Option<Arc<RecordedMotions>>,
}

/// Points of a way are at least this far apart, metres: an obstacle that stands has no direction.
const SPACING: f64 = 0.3;

/// The ego's way goes on straight for so long, metres.
const STRAIGHT_EXTENSION: f64 = 60.0;

/// How far ahead lanes are followed for ways, seconds at [`LEAST_SPEED`] or more.
const LOOKAHEAD_SECONDS: f64 = 12.0;

/// An obstacle that stands may take the ways of one that drives so fast, m/s.
const LEAST_SPEED: f64 = 8.0;

/// Ways are followed no farther than this, metres: no vehicle drives so far within a scenario's seconds.
pub(super) const MAX_WAY_LENGTH: f64 = 5000.0;

/// Seconds that are looked at to tell which lane an obstacle follows.
const MEMORY: f64 = 1.0;

impl<'a> AttackContext<'a> {
    /// The stage with the ego's motion; `None` if the ego never moves. Attackers have all of their capability.
    #[must_use]
    pub fn new(scenario: &'a Scenario, footprint: &'a Footprint, ego: &'a Track) -> Option<Self> {
        let range = ego.steps();
        let places = ego.iter().map(|(_, m)| m.pose.position);
        let mut points = thinned(places);
        let (_, last) = ego.iter().last()?;
        points.push(last.pose.position + last.pose.forward() * STRAIGHT_EXTENSION);
        Some(Self {
            scenario,
            footprint,
            ego,
            line: Polyline::new(points)?,
            steps: range.start..=range.end - 1,
            others: None,
            style: AttackStyle::Limit,
            recorded: None,
        })
    }

    /// The same for attackers of a style.
    #[must_use]
    pub fn of_style(self, style: AttackStyle) -> Self {
        Self { style, ..self }
    }

    /// Seconds between two steps.
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.scenario.dt()
    }

    /// The step that is `seconds` after step 0, the nearest one.
    #[must_use]
    pub fn step_at(&self, seconds: f64) -> i64 {
        (seconds / self.dt()).round() as i64
    }

    /// The ego's motion at a step; beyond its ends as at the end.
    #[must_use]
    pub fn ego_at(&self, step: i64) -> Option<&scenario::Motion> {
        self.ego
            .at(step.clamp(*self.steps.start(), *self.steps.end()))
    }

    /// The ways that an obstacle may take from `step` on, the recorded one first: lines that begin where its centre is.
    ///
    /// The recorded way goes on along the lanes where the recording ends; the others follow the lanes.
    #[must_use]
    pub fn ways(&self, obstacle: &Obstacle, step: i64) -> Vec<Polyline> {
        let Some(end) = obstacle.track().steps().last() else {
            return Vec::new();
        };
        let driven = obstacle.track().iter().filter(|(s, _)| *s >= step);
        let mut recorded = thinned(driven.map(|(_, m)| m.pose.position));
        let on = self.lanes(obstacle, end);
        if let (Some(first), Some(from)) = (on.first(), recorded.last().copied()) {
            recorded.extend(thinned(first.iter().copied()).into_iter().filter(|p| {
                // The point beside the last one is not part of the remaining path.
                (p - from).norm() > SPACING
            }));
        }
        let mut ways: Vec<Polyline> = Polyline::new(recorded).into_iter().collect();
        let others = self.lanes(obstacle, step).into_iter();
        ways.extend(others.filter_map(|points| Polyline::new(thinned(points.into_iter()))));
        ways
    }

    /// The ways along lanes from where an obstacle is at a step, likeliest first.
    fn lanes(&self, obstacle: &Obstacle, step: i64) -> Vec<Vec<Point>> {
        let memory = (MEMORY / self.dt()).round() as i64;
        let past = ObservedHistory::of_traffic(self.scenario, step - memory..=step, None);
        let Some(seen) = past.others().iter().find(|o| o.who.id == obstacle.id) else {
            return Vec::new();
        };
        let mut courses = Predictor::new(&past, Model::AlongLanes)
            .predict(seen, LOOKAHEAD_SECONDS)
            .courses;
        courses.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        let reach = (LOOKAHEAD_SECONDS * seen.motion.velocity)
            .clamp(LOOKAHEAD_SECONDS * LEAST_SPEED, MAX_WAY_LENGTH);
        let along = |pose: &dyn Fn(f64) -> Pose| -> Vec<Point> {
            let pieces = (reach / 1.0) as usize;
            (0..=pieces).map(|s| pose(s as f64).position).collect()
        };
        courses
            .iter()
            .map(|c| along(&|s| c.path.pose_at(s)))
            .collect()
    }
}

/// Points without those that are too near to the one before.
fn thinned(points: impl Iterator<Item = Point>) -> Vec<Point> {
    let mut kept: Vec<Point> = Vec::new();
    for p in points {
        if kept.last().is_none_or(|last| (p - last).norm() >= SPACING) {
            kept.push(p);
        }
    }
    kept
}
