//! Model-free attacks: a cross-entropy search over manoeuvre parameters.
//!
//! Samples come from a mixture: normal distributions around the best results so far, and each manoeuvre's initial
//! distribution.
//!
//! Source: Rubinstein and Kroese, The Cross-Entropy Method (2004), as O'Kelly et al. 2018 use it for rare events. Each
//! round samples manoeuvres, turns them into motions, drops those the gate refuses, screens the rest against an ego
//! that only brakes, and drives the ego against the most promising ones, first coarsely. What worked is sampled more
//! often, and what lies between an attack that cannot be survived and a harmless one is driven in any case. A search that
//! found nothing ends with small changes of what came nearest. The same seed gives the same attacks.
//!
//! The end of a search that found nothing: small changes of what came nearest.
//!
//! An evolution strategy with one parent, whose step follows its success (Rechenberg, Evolutionsstrategie, 1973): how near
//! an attacker comes depends smoothly on a manoeuvre's numbers, while what was drawn at large leaves wide gaps.

use nearmiss_scene::verdict::{Manoeuvre, Motion};
use rayon::prelude::*;

use super::attack::{Attack, AttackSetup};
use super::manoeuvre::{ManoeuvreSpace, Numbers};
use super::screening::{self, Trial};
use super::{AllowedAttacks, Effort, Progress, Refusal, SearchResult, attacker, motion};

/// An attack of this cost is as good as one can be: a collision that an ideal driver survives.
const BEST_COST: f64 = -3.0;

/// No more is asked of a collision that costs no more than this beyond it for being unlike recorded motions; so many rounds
/// after the first are spent to find a more plausible one.
const IMPLAUSIBILITY_COST: f64 = 0.35;
const PLAUSIBILITY_ROUNDS: usize = 3;

/// One of this cost is a near miss that an ideal driver survives; so many rounds after the first are spent to find better
/// ones.
const GOOD_COST: f64 = -2.0;
const COLLISION_ROUNDS: usize = 3;

/// The search ends after so many rounds in a row that found nothing better by [`MIN_IMPROVEMENT`].
const STALL_ROUNDS: usize = 8;
const MIN_IMPROVEMENT: f64 = 0.05;

/// Motions that each core tries before the progress is told.
const MOTIONS_PER_CORE: usize = 4;

/// Attacks checked for avoidability per round, and where so many could not be survived: that takes longest.
const CERTIFIED_PER_ROUND: usize = 2;
const OF_HOPELESS: usize = 1;
const HOPELESS: usize = 4;

/// Attacks against which the ego is driven again with all samples of its planner per round: it may get away.
const DRIVEN_AGAIN: usize = 4;

/// Motions between those that cannot be survived and harmless ones, which are driven in each round.
const BETWEEN: usize = 2;

/// The share of the motions that is tried in the first round.
const FIRST_ROUND_SHARE: f64 = 0.35;

/// An arm of which so many motions were tried and none passed the gate is left alone.
const MAX_FUTILE_MOTIONS: usize = 8;

/// One motion in so many is kept for the end of a search that found nothing.
const POLISHED: usize = 10;

/// How widely is drawn around what did well, as a share of an arm's first spread; in the nth round an nth of it.
const SPREAD: f64 = 0.5;

/// Searches for attacks that are allowed. `watch` receives the progress
/// whenever more motions were tried or driven, and returns whether to continue. `stop` is polled before every motion and
/// every drive: once it returns true, nothing more is started.
#[must_use]
pub fn search_until(
    ground: &AttackSetup<'_>,
    effort: &Effort,
    allowed: AllowedAttacks<'_>,
    watch: &mut dyn FnMut(Progress) -> bool,
    stop: &(dyn Fn() -> bool + Sync),
) -> SearchResult {
    let grounds = std::slice::from_ref(ground);
    let wanted = SearchRequest {
        allowed,
        near_misses: true,
        work: usize::MAX,
    };
    search_on(grounds, effort, wanted, watch, stop)
}

/// What a search looks for, and how long.
#[derive(Debug, Clone, Copy)]
pub(super) struct SearchRequest<'a> {
    /// Which attacks may be used.
    pub allowed: AllowedAttacks<'a>,
    /// Whether near misses also end it early, not only collisions.
    pub near_misses: bool,
    /// No further round begins after so much work, see [`super::Effect::work`].
    pub work: usize,
}

/// The same on several grounds at once: what does well on one of them is sampled more often.
pub(super) fn search_on(
    grounds: &[AttackSetup<'_>],
    effort: &Effort,
    wanted: SearchRequest<'_>,
    watch: &mut dyn FnMut(Progress) -> bool,
    stop: &(dyn Fn() -> bool + Sync),
) -> SearchResult {
    let mut search = Search {
        grounds,
        wanted,
        stop,
        arms: Vec::new(),
        places: Vec::new(),
        asked: Vec::new(),
        tried: Vec::new(),
        found: SearchResult::default(),
    };
    for (place, ground) in grounds.iter().enumerate() {
        let others = ground.stage.others.map(|(others, _)| &others.change);
        let attacks = |id: i64| others.is_some_and(|others| others.obstacles().any(|o| o == id));
        let ranked = attacker::rank(ground.stage);
        let chosen = ranked
            .iter()
            .filter(|c| c.reaches && !attacks(c.obstacle) && wanted.allowed.allow(ground.stage, c));
        let arms = chosen
            .take(effort.attackers.div_ceil(grounds.len()))
            .flat_map(|c| ManoeuvreSpace::all(ground.stage, c))
            .filter(|arm| wanted.allowed.allow_manoeuvre(arm.kind));
        search.arms.extend(arms);
        search.places.resize(search.arms.len(), place);
    }
    if !search.arms.is_empty() {
        search.asked.resize(search.arms.len(), 0);
        search.run(effort, watch);
    }
    let mut found = search.found;
    found.attacks = search.tried.into_iter().map(|t| t.attack).collect();
    found.sort();
    found
}

/// The search in one scenario.
struct Search<'a> {
    grounds: &'a [AttackSetup<'a>],
    wanted: SearchRequest<'a>,
    stop: &'a (dyn Fn() -> bool + Sync),
    arms: Vec<ManoeuvreSpace>,
    /// The ground of each arm.
    places: Vec<usize>,
    /// Motions of each arm that were tried.
    asked: Vec<usize>,
    tried: Vec<Trial>,
    found: SearchResult,
}

impl Search<'_> {
    fn run(&mut self, effort: &Effort, watch: &mut dyn FnMut(Progress) -> bool) {
        let mut random = fastrand::Rng::with_seed(effort.seed);
        let first = (effort.candidates as f64 * FIRST_ROUND_SHARE).round() as usize;
        let rounds = effort.rounds.max(1);
        // The rest is for what came nearest.
        let in_rounds = effort.candidates - effort.candidates / POLISHED;
        let (mut lowest, mut since) = (f64::INFINITY, 0);
        for round in 0..rounds {
            let count = match round {
                0 if rounds > 1 => first,
                _ => {
                    let left = in_rounds.saturating_sub(self.found.candidates);
                    left / (rounds - round)
                }
            };
            let spread = SPREAD / round.max(1) as f64;
            let goes_on = self.draw(count, round == 0, spread, &mut random, watch)
                && self.drive(effort.drives, spread, watch);
            if !goes_on {
                break;
            }
            self.look(effort.delay);
            // A motion that was not looked at may be one that cannot be survived.
            let survived = self.attacks().filter(|a| a.survivable == Some(true));
            let (mut best, mut least) = (f64::INFINITY, f64::INFINITY);
            for attack in survived {
                best = best.min(attack.harmlessness());
                least = least.min(attack.cost());
            }
            let goes_on = watch(self.found.so_far(self.attacks())) && !(self.stop)();
            let found = { self.attacks() }.filter(|a| a.effect.is_some());
            let now = found.map(Attack::cost).fold(f64::INFINITY, f64::min);
            since = if now < lowest - MIN_IMPROVEMENT {
                0
            } else {
                since + 1
            };
            lowest = lowest.min(now);
            let severe = self.wanted.allowed.severe();
            let enough = !severe && least <= BEST_COST + IMPLAUSIBILITY_COST
                || !severe && best <= BEST_COST && round >= PLAUSIBILITY_ROUNDS
                || self.wanted.near_misses && best <= GOOD_COST && round >= COLLISION_ROUNDS
                || since > STALL_ROUNDS
                || self.found.work >= self.wanted.work;
            if !goes_on {
                return;
            }
            if enough {
                break;
            }
        }
        self.polish(effort, &mut random, watch);
    }

    /// Whether an attack was found that an ideal driver survives.
    fn is_survived(&self) -> bool {
        self.attacks().any(|a| a.survivable == Some(true))
    }

    fn ground(&self, arm: usize) -> &'_ AttackSetup<'_> {
        &self.grounds[self.places[arm]]
    }

    fn attacks(&self) -> impl Iterator<Item = &Attack> {
        self.tried.iter().map(|t| &t.attack)
    }

    /// Attacks that no ideal driver was found to survive.
    fn hopeless(&self) -> usize {
        let hopeless = |a: &&Attack| a.survivable == Some(false);
        self.attacks().filter(hopeless).count()
    }

    /// The arms that are worth another motion; all, where none is.
    fn live(&self) -> Vec<usize> {
        let passed = |arm: usize| self.tried.iter().any(|t| t.arm == arm);
        let all = 0..self.arms.len();
        let live: Vec<usize> = { all.clone() }
            .filter(|&arm| self.asked[arm] < MAX_FUTILE_MOTIONS || passed(arm))
            .collect();
        if live.is_empty() { all.collect() } else { live }
    }

    /// Draws motions, and keeps those that pass the gate; says whether to continue.
    fn draw(
        &mut self,
        count: usize,
        first: bool,
        spread: f64,
        random: &mut fastrand::Rng,
        watch: &mut dyn FnMut(Progress) -> bool,
    ) -> bool {
        let elite = screening::elite(&self.arms, &self.tried);
        let mut asked = screening::between(&self.arms, &self.tried, BETWEEN.min(count));
        let between = asked.len();
        let more = count - asked.len();
        let live = self.live();
        asked.extend(draw(&self.arms, &live, &elite, more, first, spread, random));
        self.make_all(&asked, between, watch)
    }

    /// Makes motions, and keeps those that pass the gate; the first `between` of them are driven in any case. Says
    /// whether to continue.
    fn make_all(
        &mut self,
        asked: &[(usize, Numbers)],
        between: usize,
        watch: &mut dyn FnMut(Progress) -> bool,
    ) -> bool {
        let mut place = 0;
        for some in asked.chunks(MOTIONS_PER_CORE * rayon::current_num_threads()) {
            let made: Vec<(usize, Numbers, Result<Attack, Refusal>)> = some
                .par_iter()
                .map(|(arm, numbers)| {
                    let (arm, mut numbers) = (*arm, *numbers);
                    let manoeuvre = self.arms[arm].manoeuvre(&mut numbers);
                    (arm, numbers, self.make(arm, manoeuvre))
                })
                .collect();
            self.found.candidates += made.len();
            for (arm, numbers, made) in made {
                let is_between = place < between;
                place += 1;
                self.asked[arm] += 1;
                match made {
                    Ok(attack) => self.tried.push(Trial {
                        arm,
                        numbers,
                        attack,
                        is_between,
                    }),
                    Err(refusal) => self.found.refused.push(refusal),
                }
            }
            if !watch(self.found.so_far(self.attacks())) {
                return false;
            }
        }
        true
    }

    fn make(&self, arm: usize, manoeuvre: Manoeuvre) -> Result<Attack, Refusal> {
        let (arm, ground) = (&self.arms[arm], self.ground(arm));
        if (self.stop)() {
            return Err(Refusal::answer("the search was stopped"));
        }
        let kind = manoeuvre.kind.name();
        let attempt = || {
            let obstacle = ground.obstacle(arm.obstacle)?;
            let change = motion::of_manoeuvre(ground.stage, obstacle, &manoeuvre, arm.way)?;
            let begin = change.motions.first().map_or(0, |(step, _)| *step);
            let allowed = self.wanted.allowed;
            if !allowed.allow_begin(ground.stage, arm.obstacle, begin) {
                return Err(Refusal::answer("its attack begins elsewhere than wished"));
            }
            ground.attack(Motion::Manoeuvre(manoeuvre), change)
        };
        attempt().map_err(|refusal: Refusal| refusal.about(arm.obstacle, Some(kind)))
    }

    /// Drives the ego against what is most promising; says whether to continue.
    fn drive(
        &mut self,
        drives: usize,
        apart: f64,
        watch: &mut dyn FnMut(Progress) -> bool,
    ) -> bool {
        let chosen = screening::promising(&self.arms, &self.tried, drives, apart);
        self.drive_all(chosen, watch)
    }

    /// Drives the ego against these of what was tried; says whether to continue.
    fn drive_all(
        &mut self,
        mut chosen: Vec<usize>,
        watch: &mut dyn FnMut(Progress) -> bool,
    ) -> bool {
        chosen.sort_unstable();
        for some in chosen.chunks(rayon::current_num_threads().max(1)) {
            let all = self.tried.iter_mut().enumerate();
            let chosen: Vec<&mut Trial> = all
                .filter(|(i, _)| some.contains(i))
                .map(|(_, tried)| tried)
                .collect();
            let (grounds, places) = (self.grounds, &self.places);
            let stop = self.stop;
            let work = chosen.into_par_iter().map(|tried| {
                if stop() {
                    0
                } else {
                    grounds[places[tried.arm]].drive_coarsely(&mut tried.attack)
                }
            });
            self.found.work += work.sum::<usize>();
            if !watch(self.found.so_far(self.attacks())) {
                return false;
            }
        }
        true
    }

    /// Looks whether an ideal driver survives what the ego did not, the most dangerous first.
    fn look(&mut self, delay: f64) {
        let preventable_by = self.wanted.allowed.preventable_by();
        let most = if self.hopeless() >= HOPELESS {
            OF_HOPELESS
        } else {
            CERTIFIED_PER_ROUND
        };
        let mut effective: Vec<&mut Trial> = { self.tried.iter_mut() }
            .filter(|t| t.attack.has_effect() && t.attack.survivable.is_none())
            .filter(|t| !t.attack.is_idle())
            .collect();
        effective.sort_by(|a, b| a.attack.cost().total_cmp(&b.attack.cost()));
        let mut looked = 0;
        for tried in effective.into_iter().take(DRIVEN_AGAIN) {
            if (self.stop)() || looked == most {
                break;
            }
            let ground = &self.grounds[self.places[tried.arm]];
            self.found.work += ground.survive(&mut tried.attack, delay, preventable_by);
            // With all samples the ego may get away.
            looked += usize::from(tried.attack.survivable.is_some());
            if tried.attack.harmlessness() <= BEST_COST {
                break;
            }
        }
    }
}

/// The share of later draws that goes to all arms alike.
const EXPLORE: f64 = 0.4;

/// How much more often is drawn around what is better by 1.
const SHARPNESS: f64 = 2.0;

/// What is to be tried: in the first round of all `live` arms alike, later mostly around what did well, within a share
/// of its spread.
fn draw(
    arms: &[ManoeuvreSpace],
    live: &[usize],
    elite: &[(f64, &Trial)],
    count: usize,
    first: bool,
    spread: f64,
    random: &mut fastrand::Rng,
) -> Vec<(usize, Numbers)> {
    let best = elite.first().map_or(0.0, |(cost, _)| *cost);
    let weights: Vec<f64> = { elite.iter() }
        .map(|(cost, _)| (SHARPNESS * (best - cost)).exp())
        .collect();
    let total: f64 = weights.iter().sum();
    (0..count)
        .map(|i| {
            if elite.is_empty() || random.f64() < EXPLORE {
                let arm = live[if first {
                    i % live.len()
                } else {
                    random.usize(..live.len())
                }];
                return (arm, arms[arm].sample(random));
            }
            let mut left = random.f64() * total;
            let chosen = weights.iter().position(|w| {
                left -= w;
                left <= 0.0
            });
            let (_, parent) = elite[chosen.unwrap_or(0)];
            let around = arms[parent.arm].around(&parent.numbers, spread, random);
            (parent.arm, around)
        })
        .collect()
}

/// What came nearest by so many arms is changed, and so often.
const PARENTS: usize = 2;
const GENERATIONS: usize = 6;

/// Motions that are driven in a generation, of at most so many that are asked for: some do not pass the gate.
const CHILDREN: usize = 4;
const ASKED: usize = 12;

/// What costs more is too far off for small changes.
const MAX_COST_TO_REFINE: f64 = 2.0;

/// The first step, as a share of an arm's spread; what it becomes after a success and a failure.
const STEP: f64 = 0.3;
const LONGER: f64 = 1.3;
const SHORTER: f64 = 0.6;

impl Search<'_> {
    /// Changes what came nearest, until an ideal driver survives an attack or enough was done.
    fn polish(
        &mut self,
        effort: &Effort,
        random: &mut fastrand::Rng,
        watch: &mut dyn FnMut(Progress) -> bool,
    ) {
        for mut parent in self.parents() {
            let mut step = STEP;
            for _ in 0..GENERATIONS {
                if self.is_survived() || self.found.work >= self.wanted.work {
                    return;
                }
                let left = effort.candidates.saturating_sub(self.found.candidates);
                let children = self.children(parent, step, left, random, watch);
                if !self.drive_all(children.clone(), watch) || (self.stop)() {
                    return;
                }
                self.look(effort.delay);
                let cost = |&i: &usize| self.tried[i].attack.cost();
                let best = children
                    .into_iter()
                    .min_by(|a, b| cost(a).total_cmp(&cost(b)));
                match best.filter(|best| cost(best) < cost(&parent)) {
                    Some(best) => (parent, step) = (best, step * LONGER),
                    None => step *= SHORTER,
                }
            }
        }
    }

    /// What came nearest without an effect, one of an arm.
    fn parents(&self) -> Vec<usize> {
        let tried = self.tried.iter().enumerate();
        let mut near: Vec<(usize, f64)> = tried
            .filter(|(_, t)| t.attack.effect.is_some() && !t.attack.has_effect())
            .map(|(i, t)| (i, t.attack.cost()))
            .filter(|(_, cost)| *cost <= MAX_COST_TO_REFINE)
            .collect();
        near.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut parents: Vec<usize> = Vec::new();
        for (i, _) in near {
            let arm = self.tried[i].arm;
            if parents.len() < PARENTS && parents.iter().all(|&p| self.tried[p].arm != arm) {
                parents.push(i);
            }
        }
        parents
    }

    /// Places of new motions a step from `parent`, for which no more than `left` are tried.
    fn children(
        &mut self,
        parent: usize,
        step: f64,
        left: usize,
        random: &mut fastrand::Rng,
        watch: &mut dyn FnMut(Progress) -> bool,
    ) -> Vec<usize> {
        let (arm, numbers) = (self.tried[parent].arm, self.tried[parent].numbers);
        let first = self.tried.len();
        for _ in 0..ASKED.min(left) / CHILDREN {
            let asked: Vec<(usize, Numbers)> = (0..CHILDREN)
                .map(|_| (arm, self.arms[arm].around(&numbers, step, random)))
                .collect();
            let goes_on = self.make_all(&asked, 0, watch);
            if !goes_on || self.tried.len() >= first + CHILDREN {
                break;
            }
        }
        (first..self.tried.len()).take(CHILDREN).collect()
    }
}
