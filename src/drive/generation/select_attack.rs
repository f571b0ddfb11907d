//! Selects an attack: the most dangerous one that a good driver survives.

use super::attack::Attack;
use super::{Avoidability, ClosedLoop, Consequence, Effect};

/// An attack with the proof that it can be survived, or that this was searched for.
#[derive(Debug, Clone)]
pub struct SelectedAttack {
    /// The attack; the ego was driven against it.
    pub attack: Attack,
    /// Whether a good driver avoids it.
    pub avoidability: Avoidability,
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
/// fails again. That says nothing about a good driver, so no way out is looked for.
///
/// Being hit from behind proves nothing and is never preferred to a near miss.
#[must_use]
pub fn choose<'a>(
    closed: &ClosedLoop,
    attacks: impl IntoIterator<Item = &'a Attack>,
    delay: f64,
) -> Option<SelectedAttack> {
    let known = attacks.into_iter().filter(|a| a.effect.is_some());
    let (breaking, others): (Vec<&Attack>, Vec<&Attack>) =
        known.partition(|a| a.effect.as_ref().is_some_and(Effect::breaks_planner));
    let (effective, harmless): (Vec<&Attack>, Vec<&Attack>) =
        others.into_iter().partition(|a| a.has_effect());
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
        let chosen = look(closed, attack)?;
        if chosen.avoidability.at(delay) == Some(true) {
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
    })
}

/// Looks for ways out.
fn look(closed: &ClosedLoop, attack: Attack) -> Option<SelectedAttack> {
    Some(SelectedAttack {
        avoidability: Avoidability::search(closed, attack.effect.as_ref()?),
        attack,
    })
}

impl SelectedAttack {
    /// How many of the reaction times are survived.
    fn survived(&self) -> usize {
        let all = self.avoidability.certificates.iter();
        all.filter(|(_, c)| c.avoidance().is_some()).count()
    }

    /// How good it is, the more the better: a collision with an attacker that a good driver avoids with a reaction time
    /// of `delay` seconds, such a near miss, an effect that is not avoided, none.
    pub(super) fn rank(&self, delay: f64) -> Rank {
        let avoided = self.avoidability.at(delay) == Some(true);
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
    /// No good driver was found to avoid it.
    Hopeless,
    /// A near miss that a good driver avoids.
    NearMiss,
    /// The planner's process fails.
    PlannerError,
    /// A collision that a good driver avoids: the best there is.
    Collision,
}
