//! The effect of changed motions on the ego, how dangerous that was, and the most dangerous attack that can be survived.

use std::sync::Arc;

use strum::IntoStaticStr;

use nearmiss_scene::metrics::Impact;
use nearmiss_scene::scenario::Scenario;

use super::attack::Attack;
use super::closed_loop_screening::NEAR_MISS;
use super::{AllowedAttacks, Avoidability, ClosedLoop};
use crate::simulation::{Collision, ContactSide, PlannerError, Rollout};

/// Time steps and risk scores, 0 (collision) to 5 (negligible), of one obstacle where it is there.
pub type RiskCurve = Vec<(i64, u8)>;

/// Consequence of a change. What also happens to the ego in the baseline is not one, and neither is being hit from behind:
/// no obstacle reacts to the ego.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum Consequence {
    /// The ego and an attacker touch, or the ego drives into another obstacle with its front.
    Collision(Collision),
    /// No such contact, and the planner's process fails: the ego has no trajectory then.
    PlannerError(PlannerError),
    /// Neither, and the risk score of an attacker that is not behind the ego is 1 at most at some step, and lower than
    /// in the baseline.
    NearMiss,
    /// Neither.
    NoEffect,
}

impl Consequence {
    /// Its name in documents.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.into()
    }

    /// How bad its kind is: of a collision most.
    fn badness(&self) -> u8 {
        match self {
            Self::Collision(_) => 3,
            Self::PlannerError(_) => 2,
            Self::NearMiss => 1,
            Self::NoEffect => 0,
        }
    }

    /// Whether it is of a worse kind than another one: a collision, an error of the planner, a near miss, no
    /// effect.
    #[must_use]
    pub fn is_worse_than(&self, other: &Self) -> bool {
        self.badness() > other.badness()
    }
}

/// The ego's drive against a change, and how dangerous it was.
#[derive(Debug, Clone)]
pub struct Effect {
    /// The obstacles whose motion was changed, in the order of the change; at least one.
    pub attackers: Vec<AttackerEffect>,
    /// The place in `attackers` of the one that the ego touches, or else of the most dangerous one.
    pub main: usize,
    /// The step of the last state before the first attacker moves otherwise.
    pub from: i64,
    /// The scenario with the changed motions.
    pub scenario: Arc<Scenario>,
    /// The ego's drive in it. Beside a collision it may end off the road, or with nothing that can be driven.
    pub drive: Rollout,
    /// Its outcome.
    pub consequence: Consequence,
    /// The contact at its end that the baseline does not have, also one that is no consequence of the change.
    pub contact: Option<Collision>,
    /// How hard that contact is.
    pub impact: Option<Impact>,
    /// The lowest risk score of any obstacle in the baseline; `None` if none ever is there.
    pub anyone_before: Option<u8>,
    /// The lowest risk score of any obstacle in this drive.
    pub anyone_after: Option<u8>,
    /// Cycles that were taken over from another drive, as nothing had changed yet.
    pub taken_over: usize,
}

/// How dangerous one attacker is to the ego.
#[derive(Debug, Clone)]
pub struct AttackerEffect {
    /// The obstacle's id.
    pub obstacle: i64,
    /// The step of the last state before its motion is another one.
    pub from: i64,
    /// The last step of its motion.
    pub until: i64,
    /// Its risk scores against the baseline, with its recorded motion.
    pub before: RiskCurve,
    /// Its risk scores in this drive.
    pub after: RiskCurve,
    /// The smallest distance of its body to the ego's in this drive, metres.
    pub distance: Option<f64>,
    /// Its lowest risk score in this drive before it is rounded, see [`nearmiss_scene::metrics::UNROUNDED_RISK`].
    pub unrounded: Option<f64>,
    /// The smallest distance while it is not behind the ego, metres.
    pub distance_in_view: Option<f64>,
    /// The lowest unrounded risk score while it is not behind the ego.
    pub unrounded_in_view: Option<f64>,
    /// What the other attackers come to while this one moves as recorded; `None` where there are no others or that was
    /// not looked for, see [`super::ClosedLoop::leave_each_out`].
    pub without: Option<Consequence>,
}

impl AttackerEffect {
    /// Its lowest risk score in the baseline; `None` if it never is there.
    #[must_use]
    pub fn lowest_before(&self) -> Option<u8> {
        lowest(&self.before)
    }

    /// Its lowest risk score in this drive.
    #[must_use]
    pub fn lowest_after(&self) -> Option<u8> {
        lowest(&self.after)
    }

    /// How dangerous it is: the less, the more.
    fn safety(&self) -> (f64, f64) {
        let most = f64::INFINITY;
        (
            self.unrounded.unwrap_or(most),
            self.distance.unwrap_or(most),
        )
    }
}

impl Effect {
    /// What its drive took, in about milliseconds of one core, but the same on every machine: a cycle takes longer with
    /// more obstacles, whose motions are predicted, and with more candidates. Cycles that were taken over take nothing.
    #[must_use]
    pub fn work(&self) -> usize {
        let planned = self.drive.cycles.iter().skip(self.taken_over);
        let candidates: usize = planned.clone().map(|c| c.plan.candidates).sum();
        let cycle = match self.drive.external {
            // A process takes as long as it likes.
            Some(_) => 1.0,
            None => 0.2 + 0.03 * self.scenario.obstacles.len() as f64,
        };
        (planned.count() as f64 * cycle + 0.9e-3 * candidates as f64) as usize
    }

    /// The attacker that the ego touches, or else the most dangerous one.
    #[must_use]
    pub fn main(&self) -> &AttackerEffect {
        &self.attackers[self.main]
    }

    /// The effect of one of its obstacles.
    #[must_use]
    pub fn on_attacker(&self, obstacle: i64) -> Option<&AttackerEffect> {
        self.attackers.iter().find(|a| a.obstacle == obstacle)
    }

    /// Whether the motion of an obstacle was changed.
    #[must_use]
    pub fn is_attacker(&self, obstacle: i64) -> bool {
        self.on_attacker(obstacle).is_some()
    }

    /// The ids of the attackers.
    pub fn ids(&self) -> impl Iterator<Item = i64> + '_ {
        self.attackers.iter().map(|a| a.obstacle)
    }

    /// The lowest risk score of an attacker in the baseline; `None` if none ever is there.
    #[must_use]
    pub fn lowest_before(&self) -> Option<u8> {
        let all = self.attackers.iter();
        all.filter_map(AttackerEffect::lowest_before).min()
    }

    /// The lowest risk score of an attacker in this drive.
    #[must_use]
    pub fn lowest_after(&self) -> Option<u8> {
        let all = self.attackers.iter();
        all.filter_map(AttackerEffect::lowest_after).min()
    }

    /// The smallest distance of an attacker's body to the ego's in this drive, metres.
    #[must_use]
    pub fn distance(&self) -> Option<f64> {
        let all = self.attackers.iter().filter_map(|a| a.distance);
        all.min_by(f64::total_cmp)
    }

    /// Whether the planner's process fails in the drive.
    #[must_use]
    pub fn breaks_planner(&self) -> bool {
        matches!(self.consequence, Consequence::PlannerError(_))
    }

    /// The step after which, before the next one, bodies touch that are apart at both.
    #[must_use]
    pub fn touched_after_step(&self) -> Option<i64> {
        let between = self.contact.filter(|contact| contact.between);
        between.map(|contact| contact.step - 1)
    }

    /// Whether it is an attacker that the ego touches.
    #[must_use]
    pub fn hits_attacker(&self) -> bool {
        self.contact.is_some_and(|c| self.is_attacker(c.with))
    }

    /// Whether an obstacle drives into the ego's rear with the front: that proves little, since no obstacle reacts to
    /// the ego.
    #[must_use]
    pub fn is_hit_from_behind(&self) -> bool {
        self.contact.as_ref().is_some_and(hits_from_behind)
    }

    /// Whether each of several attackers is needed: without it, the others come to something less bad. `None` of a single
    /// one, and where that was not looked for.
    #[must_use]
    pub fn needs_all(&self) -> Option<bool> {
        let mut all = self.attackers.iter();
        all.try_fold(true, |needed, attacker| {
            let without = attacker.without?;
            Some(needed && self.consequence.is_worse_than(&without))
        })
    }

    /// The place of the attacker that counts most: the one that the ego touches, or else the most dangerous one.
    pub(super) fn place_of_main(attackers: &[AttackerEffect], contact: Option<Collision>) -> usize {
        let touched = contact.and_then(|c| attackers.iter().position(|a| a.obstacle == c.with));
        let order = |a: &AttackerEffect, b: &AttackerEffect| {
            let (a, b) = (a.safety(), b.safety());
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        };
        let all = attackers.iter().enumerate();
        let nearest = all.min_by(|(_, a), (_, b)| order(a, b));
        touched.or(nearest.map(|(i, _)| i)).unwrap_or(0)
    }
}

/// Whether the ego's rear is hit by the other's front.
fn hits_from_behind(contact: &Collision) -> bool {
    contact.ego == ContactSide::Rear && contact.other == ContactSide::Front
}

/// Whether an attacker comes dangerously near, a risk score of [`NEAR_MISS`] at most and lower than it ever has in the
/// drive `before` the change, while its middle is not behind the ego's rear. Of drives the scenario and the ego's.
pub(super) fn comes_near(
    attackers: &[AttackerEffect],
    (recorded, before): (&Scenario, &Rollout),
    (changed, after): (&Scenario, &Rollout),
) -> bool {
    let (was_behind, is_behind) = (behind(recorded, before), behind(changed, after));
    attackers.iter().any(|attacker| {
        let id = attacker.obstacle;
        let was = attacker
            .before
            .iter()
            .filter(|(step, _)| was_behind(id, *step) != Some(true))
            .map(|(_, score)| *score)
            .min();
        attacker.after.iter().any(|(step, score)| {
            *score <= NEAR_MISS
                && was.is_none_or(|was| *score < was)
                && is_behind(id, *step) != Some(true)
        })
    })
}

/// Whether the middle of an obstacle is behind the ego's rear at a step; nothing where one of them is absent.
pub(super) fn behind(scenario: &Scenario, drive: &Rollout) -> impl Fn(i64, i64) -> Option<bool> {
    let track = drive.track();
    let length = drive.limits.length;
    move |id, step| {
        let own = track.at(step)?;
        let other = scenario.obstacle(id)?.motion_at(step)?;
        Some(own.pose.to_local(&other.pose.position).x < -length / 2.0)
    }
}

/// Whether a contact shows something of the ego: an attacker touches it, but for its rear, or it drives into another
/// obstacle.
pub(super) fn is_telling(contact: &Collision, attackers: &[AttackerEffect]) -> bool {
    let by_attacker = attackers.iter().any(|a| a.obstacle == contact.with);
    !hits_from_behind(contact) && (by_attacker || contact.ego == ContactSide::Front)
}

fn lowest(curve: &RiskCurve) -> Option<u8> {
    curve.iter().map(|(_, score)| *score).min()
}

/// An attack with the proof that it can be survived, or that this was searched for.
#[derive(Debug, Clone)]
pub struct SelectedAttack {
    /// The attack; the ego was driven against it.
    pub attack: Attack,
    /// Whether an ideal driver avoids it.
    pub avoidability: Avoidability,
    /// Whether the drivers that are wished avoid it.
    pub is_as_wished: bool,
}

/// How many attacks are looked at, at most: a search that finds no way out takes long.
const LOOKED_AT: usize = 8;

/// Of those that are known not to be survived in time, so many: one of them may be survived with a shorter reaction time.
const OF_HOPELESS: usize = 2;

/// Of those of which nothing is known, none is looked at after so many without a way out.
const HOPELESS: usize = 3;

/// So many attacks that broke the planner are driven again.
const BREAKING: usize = 3;

/// The first of `attacks`, which are in order, that has an effect, needs all of its attackers, and can be avoided with a
/// reaction time of `delay` seconds; where none is, the one that can be avoided with the longest reaction time, or else
/// the first. Nothing where no attack was driven.
///
/// An attack under which the planner's process fails is preferred to all but a collision that can be avoided, if it
/// fails again. That says nothing about an ideal driver, so no way out is looked for.
///
/// Being hit from behind proves nothing and is never preferred to a near miss. Those that the wished drivers avoid
/// come before all others.
///
/// Where it is to be severe, the hardest contacts come first of those that are as well survived.
#[must_use]
pub fn choose<'a>(
    closed: &ClosedLoop,
    attacks: impl IntoIterator<Item = &'a Attack>,
    delay: f64,
    allowed: AllowedAttacks<'_>,
) -> Option<SelectedAttack> {
    let preventable_by = allowed.preventable_by();
    let known = attacks.into_iter().filter(|a| a.effect.is_some());
    let (breaking, others): (Vec<&Attack>, Vec<&Attack>) =
        known.partition(|a| a.effect.as_ref().is_some_and(Effect::breaks_planner));
    let (mut effective, harmless): (Vec<&Attack>, Vec<&Attack>) =
        others.into_iter().partition(|a| a.has_effect());
    let is_wished = |attack: &Attack| {
        let effect = attack.effect.as_ref();
        effect.is_some_and(|effect| effect.is_preventable_by(closed, preventable_by))
    };
    if allowed.severe() {
        effective.sort_by(|a, b| {
            let survived = |attack: &Attack| attack.survivable != Some(true);
            survived(a)
                .cmp(&survived(b))
                .then(b.severity().total_cmp(&a.severity()))
        });
    }
    if !preventable_by.is_empty() {
        effective.sort_by_cached_key(|attack| !is_wished(attack));
    }
    let mut broken = None;
    let mut breaks = || {
        let first = || first_that_breaks(closed, &breaking);
        broken.get_or_insert_with(first).clone()
    };
    let mut best: Option<(usize, SelectedAttack)> = None;
    let needed = effective.into_iter().filter(|a| !a.is_idle());
    let mut hopeless = 0;
    let mut looked = 0;
    for attack in needed {
        if looked == LOOKED_AT {
            break;
        }

        let enough = match attack.survivable {
            Some(true) => false,
            Some(false) => hopeless >= OF_HOPELESS,
            None => hopeless >= HOPELESS,
        };
        if enough {
            continue;
        }
        looked += 1;
        let attack = driven(closed, attack)?;
        // The search drove with fewer samples.
        if attack.is_idle() || !attack.has_effect() {
            continue;
        }
        let mut chosen = look(closed, attack)?;
        chosen.is_as_wished = is_wished(&chosen.attack);
        if chosen.avoidability.at(delay) == Some(true) && chosen.is_as_wished {
            return match chosen.rank(delay) {
                Rank::Collision => Some(chosen),
                _ => breaks().or(Some(chosen)),
            };
        }
        hopeless += 1;
        let survived = chosen.survived();
        if best.as_ref().is_none_or(|(most, _)| survived > *most) {
            best = Some((survived, chosen));
        }
    }
    match breaks().or(best.map(|(_, chosen)| chosen)) {
        Some(chosen) => Some(chosen),
        None => look(closed, driven(closed, harmless.first()?)?),
    }
}

/// The attack driven to the end, since searches stop when one seems over.
fn driven(closed: &ClosedLoop, attack: &Attack) -> Option<Attack> {
    let mut effect = closed.effect(&attack.change).ok()?;
    closed.leave_each_out(&mut effect, &attack.change).ok()?;
    Some(Attack {
        effect: Some(effect),
        ..attack.clone()
    })
}

/// The first attack under which the planner's process fails again.
fn first_that_breaks(closed: &ClosedLoop, attacks: &[&Attack]) -> Option<SelectedAttack> {
    let mut again = attacks.iter().take(BREAKING).filter_map(|attack| {
        let effect = closed.effect(&attack.change).ok()?;
        effect.breaks_planner().then(|| Attack {
            effect: Some(effect),
            ..(*attack).clone()
        })
    });
    let attack = again.next()?;
    Some(SelectedAttack {
        attack,
        avoidability: Avoidability::not_looked_for(),
        is_as_wished: true,
    })
}

/// Looks for ways out.
fn look(closed: &ClosedLoop, attack: Attack) -> Option<SelectedAttack> {
    Some(SelectedAttack {
        avoidability: Avoidability::search(closed, attack.effect.as_ref()?),
        attack,
        is_as_wished: true,
    })
}

impl SelectedAttack {
    /// How many of the reaction times are survived.
    fn survived(&self) -> usize {
        let all = self.avoidability.certificates.iter();
        all.filter(|(_, c)| c.avoidance().is_some()).count()
    }

    /// How good it is, the more the better: a collision with an attacker that an ideal driver avoids with a reaction time
    /// of `delay` seconds, such a near miss, an effect that is not avoided, none.
    pub(super) fn rank(&self, delay: f64) -> Rank {
        let avoided = self.is_as_wished && self.avoidability.at(delay) == Some(true);
        let effect = self.attack.effect.as_ref();
        match effect.map(|effect| effect.consequence) {
            None | Some(Consequence::NoEffect) => Rank::Harmless,
            Some(Consequence::PlannerError(_)) => Rank::PlannerError,
            Some(_) if !avoided => Rank::Hopeless,
            Some(Consequence::Collision(_)) => Rank::Collision,
            Some(Consequence::NearMiss) => Rank::NearMiss,
        }
    }
}

/// How good a selected attack is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Rank {
    /// The ego gets away.
    Harmless,
    /// No ideal driver was found to avoid it.
    Hopeless,
    /// A near miss that an ideal driver avoids.
    NearMiss,
    /// The planner's process fails.
    PlannerError,
    /// A collision that an ideal driver avoids: the best there is.
    Collision,
}
