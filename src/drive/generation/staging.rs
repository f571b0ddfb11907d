//! Attacks by one obstacle after the other: each further attacker is staged in the scenario with the motions of those
//! before it.
//!
//! The first attacker is searched for in the scenario as it was recorded. Where one alone reaches no collision that an ideal
//! driver survives, the attacks that came nearest to the ego without a collision stay on, and another attacker is searched
//! for beside each of them: against the ego as it drives under that attack. The ego is driven against all motions at once.
//!
//! Where a search finds nothing that an ideal driver survives, others follow with new random numbers. In every second one
//! attackers keep the limits of people also where they need not: among all that a vehicle can do, what a person does is
//! found late.
//!
//! Fewer attackers are preferred: another one is taken only if the outcome is of a better rank (a survivable collision
//! before a survivable near miss, before one that is not survived) and if without any one of the attackers the others come
//! to a less bad outcome.

use super::effect::Rank;
use super::search::{SearchRequest, search_on};
use super::{
    AllowedAttacks, Attack, AttackContext, AttackSetup, AttackStyle, Effect, Effort, Gate,
    Progress, SearchEvent, SearchResult, SelectedAttack, Selection, StagedDrive, VariantGenerator,
    choose,
};
use nearmiss_scene::scenario::{Ego, Scenario};

/// Attacks beside which another attacker is searched for, at most.
const BASES: usize = 3;

/// No further round begins after so much work, see [`Effect::work`]: in one search, and in all.
const MOST_WORK: usize = 6_000;
const MOST_WORK_OF_ALL: usize = 11_000;

/// What a further attacker joins: the attack that goes on, if there is one, and the ego's drive under it.
struct Base {
    others: Option<(Attack, StagedDrive)>,
    ego: Ego,
}

/// Searches for attackers one after the other.
pub(super) fn search(
    workshop: &VariantGenerator,
    effort: &Effort,
    allowed: AllowedAttacks<'_>,
    watch: &mut dyn FnMut(SearchEvent) -> bool,
) -> Selection {
    let mut best = Selection::default();
    let mut bases = vec![Base {
        others: None,
        ego: workshop.ego.clone(),
    }];
    for attackers in 1..=effort.together.max(1) {
        let tried = best.found.progress();
        let watch = &mut |event| match event {
            SearchEvent::Round(now) => watch(SearchEvent::Round(tried.and(now))),
            SearchEvent::Certifying => watch(SearchEvent::Certifying),
        };
        let effort = match attackers {
            1 => *effort,
            _ => effort.further(),
        };
        let rank = best.rank(effort.delay);
        let found = round(workshop, &bases, &effort, allowed, rank, watch);
        let goes_on = watch(SearchEvent::Certifying);
        if goes_on {
            let first = best.chosen.is_none();
            let attacks = found.attacks.iter();
            let hopeful = attacks.filter(|attack| first || at_most(attack) > rank);
            let chosen = choose(&workshop.closed, hopeful, effort.delay, allowed.severe());
            best.take(workshop, chosen, effort.delay);
        }
        let more = best.rank(effort.delay) < Rank::Collision && attackers < effort.together;
        bases = if goes_on && more {
            Base::most_promising(workshop, &found.attacks)
        } else {
            Vec::new()
        };
        best.found.merge(found);
        if bases.is_empty() {
            break;
        }
    }
    best
}

/// Searches for one more attacker beside those of each base, where `rank` is reached already: again with new random
/// numbers until something is found that an ideal driver survives, or too much work was done.
fn round(
    workshop: &VariantGenerator,
    bases: &[Base],
    effort: &Effort,
    allowed: AllowedAttacks<'_>,
    rank: Rank,
    watch: &mut dyn FnMut(SearchEvent) -> bool,
) -> SearchResult {
    let mut found = SearchResult::default();
    let mut stopped = false;
    for (n, effort) in effort.searches().enumerate() {
        let left = MOST_WORK_OF_ALL.saturating_sub(found.work);
        let survived = found.attacks.iter().any(|a| a.survivable == Some(true));
        // A cancelled driver ends a search without a word.
        if survived || stopped || left == 0 || workshop.closed.driver().is_cancelled() {
            break;
        }
        let wanted = SearchRequest {
            allowed,
            near_misses: rank < Rank::NearMiss,
            work: left.min(MOST_WORK),
        };
        let before = found.progress();
        let mut go_on = |progress| {
            stopped |= !watch(SearchEvent::Round(before.and(progress)));
            !stopped
        };
        let style = match n % 2 {
            0 => workshop.style(),
            _ => AttackStyle::Human,
        };
        found.merge(pass(workshop, style, bases, &effort, wanted, &mut go_on));
    }
    found
}

/// One search beside each base, by attackers of a style.
fn pass(
    workshop: &VariantGenerator,
    style: AttackStyle,
    bases: &[Base],
    effort: &Effort,
    wanted: SearchRequest<'_>,
    watch: &mut dyn FnMut(Progress) -> bool,
) -> SearchResult {
    let stages: Vec<(AttackContext<'_>, Gate<'_>)> = { bases.iter() }
        .filter_map(|base| {
            let scenario = base.scenario(workshop);
            let others = base.others.as_ref().map(|(attack, drive)| (attack, drive));
            let stage = workshop
                .stage_with(scenario, &base.ego, others)?
                .of_style(style);
            Some((stage, workshop.gate_with(scenario, &base.ego)))
        })
        .collect();
    let grounds = stages.iter().map(|(stage, gate)| AttackSetup {
        stage,
        gate,
        closed_loop: &workshop.closed,
    });
    let grounds: Vec<AttackSetup<'_>> = grounds.collect();
    let stop = || workshop.closed.driver().is_cancelled();
    search_on(&grounds, effort, wanted, watch, &stop)
}

/// The best rank that an attack may have once it is looked at.
fn at_most(attack: &Attack) -> Rank {
    let effect = attack.effect.as_ref();
    match effect.filter(|_| attack.has_effect() && !attack.is_idle()) {
        None => Rank::Harmless,
        Some(_) if attack.survivable == Some(false) => Rank::Hopeless,
        // A near miss may become a collision when it is driven to the end.
        Some(_) => Rank::Collision,
    }
}

impl Base {
    /// The scenario with the motions of the others.
    fn scenario<'a>(&'a self, workshop: &'a VariantGenerator) -> &'a Scenario {
        match &self.others {
            Some((_, drive)) => drive.scenario(),
            None => workshop.closed.scenario(),
        }
    }

    /// Of attacks in order those that came nearest without a collision, each by another obstacle or of another kind.
    fn most_promising(workshop: &VariantGenerator, attacks: &[Attack]) -> Vec<Self> {
        let mut bases = Vec::new();
        let mut kinds = Vec::new();
        for attack in attacks {
            let kind: Vec<_> = { attack.acts() }
                .map(|(asked, change)| (change.obstacle, asked.name()))
                .collect();
            let collides = |effect: &Effect| effect.contact.is_some();
            let usable = attack.effect.as_ref().is_some_and(|e| !collides(e));
            if !usable || kinds.contains(&kind) {
                continue;
            }
            // Driven to the end it may still collide.
            let Ok(drive) = workshop.closed.staged(&attack.change) else {
                continue;
            };
            if drive.collides() {
                continue;
            }
            kinds.push(kind);
            bases.push(Self {
                ego: drive.ego(workshop.closed.driver()),
                others: Some((attack.clone(), drive)),
            });
            if bases.len() == BASES {
                break;
            }
        }
        bases
    }
}

impl Selection {
    fn rank(&self, delay: f64) -> Rank {
        let chosen = self.chosen.as_ref();
        chosen.map_or(Rank::Harmless, |chosen| chosen.rank(delay))
    }

    /// Takes an attack if it is of a better rank than what was taken before; the first one in any case.
    fn take(&mut self, workshop: &VariantGenerator, found: Option<SelectedAttack>, delay: f64) {
        let rank = self.rank(delay);
        let found = found.filter(|found| {
            let better = self.chosen.is_none() || found.rank(delay) > rank;
            // Each motion passed beside those before it; now all are asked beside all others.
            better
                && workshop
                    .gate()
                    .check_joint(&found.attack.change, None)
                    .is_ok()
        });
        if found.is_some() {
            self.chosen = found;
        }
    }
}
