//! Selects an attack: the most dangerous one that a good driver survives.

use super::attack::Attack;
use super::{Avoidability, ClosedLoop};

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

/// The first of `attacks`, which are in order, that has an effect and can be avoided with a reaction time of `delay`
/// seconds; where none is, the one that can be avoided with the longest reaction time, or else the first. Nothing where
/// no attack was driven.
///
/// Being hit from behind proves nothing and is never preferred to a near miss.
#[must_use]
pub fn choose(closed: &ClosedLoop, attacks: &[Attack], delay: f64) -> Option<SelectedAttack> {
    let driven = attacks.iter().filter(|a| a.effect.is_some());
    let (effective, harmless): (Vec<&Attack>, Vec<&Attack>) = driven.partition(|a| a.has_effect());
    let mut best: Option<(usize, SelectedAttack)> = None;
    for attack in effective.into_iter().take(LOOKED_AT) {
        let chosen = look(closed, attack)?;
        if chosen.avoidability.at(delay) == Some(true) {
            return Some(chosen);
        }
        let survived = chosen.survived();
        if best.as_ref().is_none_or(|(most, _)| survived > *most) {
            best = Some((survived, chosen));
        }
    }
    match best {
        Some((_, chosen)) => Some(chosen),
        None => look(closed, harmless.first()?),
    }
}

/// Drives to the end, since searches stop when an attack seems over, and looks for ways out.
fn look(closed: &ClosedLoop, attack: &Attack) -> Option<SelectedAttack> {
    let effect = closed.effect(&attack.change).ok()?;
    Some(SelectedAttack {
        avoidability: Avoidability::search(closed, &effect),
        attack: Attack {
            effect: Some(effect),
            ..attack.clone()
        },
    })
}

impl SelectedAttack {
    /// How many of the reaction times are survived.
    fn survived(&self) -> usize {
        let all = self.avoidability.certificates.iter();
        all.filter(|(_, c)| c.avoidance().is_some()).count()
    }
}
