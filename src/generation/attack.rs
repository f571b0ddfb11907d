//! An attack: a changed motion that passed the gate, and the ego's response to it.

use super::{
    AttackContext, Avoidability, Change, ClosedLoop, Consequence, Effect, Gate, OpenLoopScreening,
    Reason, Refusal,
};
use crate::scenario::Obstacle;
use crate::verdict::Motion;

/// An attack that has passed the gate.
#[derive(Debug, Clone)]
pub struct Attack {
    /// The motion requested of the attacker.
    pub asked: Motion,
    /// Its motion.
    pub change: Change,
    /// How near that comes to an ego that only brakes.
    pub rehearsal: OpenLoopScreening,
    /// How far it is from recorded motions, 0 where that does not matter; see [`RecordedMotions::deficit`](super::RecordedMotions::deficit).
    pub implausibility: f64,
    /// Its effect on the ego, if it was driven.
    pub effect: Option<Effect>,
    /// Whether a good driver survives it with the reaction time that is asked for, where that was looked for.
    pub survivable: Option<bool>,
}

/// Shared input of attacks, and the checks they must pass.
#[derive(Debug)]
pub struct AttackSetup<'a> {
    /// The original scenario with the ego's motion.
    pub stage: &'a AttackContext<'a>,
    /// The gate that every motion must pass.
    pub gate: &'a Gate<'a>,
    /// The closed loop of the ego.
    pub closed_loop: &'a ClosedLoop,
}

/// An attack ends this long after its closest approach to the ego, seconds.
const OVER: f64 = 2.0;

/// Added cost of an attack that cannot be survived.
const HOPELESS: f64 = 3.2;

/// The ego is driven for so long after the attack should be nearest, seconds: it slows down before that.
const ENOUGH: f64 = 3.0;

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

    /// The attack with a motion, if that meets the ego and passes the gate. The ego is not driven yet.
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
        Ok(Attack {
            asked,
            implausibility: recorded.map_or(0.0, |recorded| recorded.deficit(&change.motions)),
            change,
            rehearsal,
            effect: None,
            survivable: None,
        })
    }

    /// Drives the ego against an attack, until that should be over.
    pub fn drive(&self, attack: &mut Attack) {
        let until = attack.rehearsal.step + (ENOUGH / self.stage.dt()).ceil() as i64;
        attack.effect = self.closed_loop.effect_until(&attack.change, until).ok();
    }

    /// Drives the ego against it to the end, and looks whether a good driver survives it with a reaction time of
    /// `delay` seconds.
    pub fn survive(&self, attack: &mut Attack, delay: f64) {
        attack.effect = self.closed_loop.effect(&attack.change).ok();
        if let Some(effect) = attack.effect.as_ref().filter(|_| attack.has_effect()) {
            attack.survivable = Some(Avoidability::with(self.closed_loop, effect, delay));
        }
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
    /// Whether the ego, where it was driven, was touched by the attacker or nearly so, and not just hit from behind.
    #[must_use]
    pub fn has_effect(&self) -> bool {
        self.effect.as_ref().is_some_and(|e| match e.consequence {
            Consequence::Collision(_) => e.hits_attacker() && !e.is_hit_from_behind(),
            Consequence::NearMiss => true,
            Consequence::NoEffect => false,
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
        let hopeless = match self.survivable {
            Some(false) => HOPELESS,
            _ => 0.0,
        };
        hopeless
            + match effect.consequence {
                Consequence::Collision(_) if effect.is_hit_from_behind() => -0.5,
                Consequence::Collision(c) if c.with == effect.attacker => -3.0,
                Consequence::NearMiss => -2.0,
                Consequence::Collision(_) => 0.5,
                Consequence::NoEffect => {
                    let distance = effect.distance.unwrap_or(20.0).min(20.0);
                    0.5 + 0.1 * distance + 0.5 * (effect.unrounded.unwrap_or(5.0) - 1.0).max(0.0)
                }
            }
    }
}
