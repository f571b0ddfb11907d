//! Attacks without any model: a cross-entropy search over the numbers of manoeuvres.
//!
//! The density that is drawn from is a mixture: normal distributions around what did best, and those that each
//! manoeuvre begins with.
//!
//! Source: Rubinstein and Kroese, The Cross-Entropy Method (2004), as O'Kelly et al. 2018 use it for rare events. Each
//! round draws manoeuvres, makes motions of them, leaves out what the gate refuses, looks at the rest beside an ego
//! that only brakes, and drives the ego against the most promising ones. What worked is drawn more often. The
//! same seed gives the same attacks.

use rayon::prelude::*;

use super::arms::{Arm, Numbers};
use super::attack::{Attack, Ground};
use super::attacker::{self, Candidate};
use super::{Consequence, Refusal, motion};
use crate::verdict::{Manoeuvre, Motion};

/// How much is tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Motions in all.
    pub candidates: usize,
    /// Rounds after each of which the search learns.
    pub rounds: usize,
    /// Closed loops in each round.
    pub drives: usize,
    /// Obstacles that are tried, those that need the least change.
    pub attackers: usize,
    /// A good driver has to survive it with this reaction time, seconds; one of [`super::DELAYS`].
    pub delay: f64,
    /// Of the random numbers.
    pub seed: u64,
}

impl Default for Effort {
    fn default() -> Self {
        Self {
            candidates: 600,
            rounds: 12,
            drives: 5,
            attackers: 6,
            delay: 0.5,
            seed: 1,
        }
    }
}

/// What a search has found.
#[derive(Debug, Default)]
pub struct Found {
    /// Everything that passed the gate and comes near to the ego.
    pub attacks: Vec<Attack>,
    /// What was refused, one reason a motion.
    pub refused: Vec<Refusal>,
    /// How many motions were tried.
    pub candidates: usize,
}

/// How far a search is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Progress {
    /// Motions that were tried.
    pub tried: usize,
    /// How many of them were refused.
    pub refused: usize,
    /// Against how many the ego was driven.
    pub driven: usize,
    /// What the best of these leads to.
    pub best: Option<Consequence>,
}

/// An attack of this cost is as good as one can be: a collision that a good driver survives.
const BEST: f64 = -3.0;

/// One of this cost is a near miss that a good driver survives; half of the rounds are spent to find better ones.
const GOOD: f64 = -2.0;

/// So many attacks with an effect are looked at in a round for whether they can be survived.
const LOOKED_AT: usize = 2;

/// So many are learned from.
const ELITE: usize = 9;

/// The share of the motions that is tried in the first round.
const FIRST: f64 = 0.35;

/// The share of later draws that goes to all arms alike.
const EXPLORE: f64 = 0.25;

/// How widely is drawn around what did well, as a share of an arm's first spread; in the nth round an nth of it.
const SPREAD: f64 = 0.5;

/// How much more often is drawn around what is better by 1.
const SHARPNESS: f64 = 2.0;

/// The search in one scenario.
struct Search<'a> {
    ground: &'a Ground<'a>,
    stop: &'a (dyn Fn() -> bool + Sync),
}

/// What was tried, and how good it was.
#[derive(Debug, Clone, Copy)]
struct Tried {
    arm: usize,
    numbers: Numbers,
    cost: f64,
}

/// What became of one draw.
struct Draw {
    arm: usize,
    numbers: Numbers,
    made: Result<Attack, Refusal>,
}

/// Searches for attacks; `only` names the one obstacle that may attack. After each round `watch` hears how far it is, and
/// says whether to go on.
#[must_use]
pub fn search_watched(
    ground: &Ground<'_>,
    effort: &Effort,
    only: Option<i64>,
    watch: &mut dyn FnMut(Progress) -> bool,
) -> Found {
    search_until(ground, effort, only, watch, &|| false)
}

/// The same, with a `stop` that is asked before every motion and every drive: once it says so, nothing more is begun.
#[must_use]
pub fn search_until(
    ground: &Ground<'_>,
    effort: &Effort,
    only: Option<i64>,
    watch: &mut dyn FnMut(Progress) -> bool,
    stop: &(dyn Fn() -> bool + Sync),
) -> Found {
    Search { ground, stop }.run(effort, only, watch)
}

impl Found {
    /// How far the search is that has found this.
    #[must_use]
    pub fn progress(&self) -> Progress {
        let driven = || self.attacks.iter().filter(|a| a.effect.is_some());
        let best = driven().min_by(|a, b| a.cost().total_cmp(&b.cost()));
        Progress {
            tried: self.candidates,
            refused: self.refused.len(),
            driven: driven().count(),
            best: best.and_then(|a| Some(a.effect.as_ref()?.consequence)),
        }
    }
}

impl Search<'_> {
    fn run(
        &self,
        effort: &Effort,
        only: Option<i64>,
        watch: &mut dyn FnMut(Progress) -> bool,
    ) -> Found {
        let ranked = attacker::rank(self.ground.stage);
        let chosen = ranked
            .iter()
            .filter(|c| only.is_none_or(|id| c.obstacle == id));
        let chosen: Vec<&Candidate> = chosen.take(effort.attackers).collect();
        let arms: Vec<Arm> = chosen
            .iter()
            .flat_map(|c| Arm::all(self.ground.stage, c))
            .collect();
        let mut random = fastrand::Rng::with_seed(effort.seed);
        let mut found = Found::default();
        if arms.is_empty() {
            return found;
        }
        let first = (effort.candidates as f64 * FIRST).round() as usize;
        let rounds = effort.rounds.max(1);
        let mut past: Vec<Tried> = Vec::new();
        for round in 0..rounds {
            let count = match round {
                0 if rounds > 1 => first,
                _ => {
                    let left = effort.candidates.saturating_sub(found.candidates);
                    left / (rounds - round)
                }
            };
            let asked = draw(&arms, &past, count, round, &mut random);
            let draws: Vec<Draw> = asked
                .into_par_iter()
                .map(|(arm, mut numbers)| Draw {
                    arm,
                    made: self.make(&arms[arm], arms[arm].manoeuvre(&mut numbers)),
                    numbers,
                })
                .collect();
            found.candidates += draws.len();
            let mut tried: Vec<(usize, Numbers, Attack)> = Vec::new();
            for draw in draws {
                match draw.made {
                    Ok(attack) => tried.push((draw.arm, draw.numbers, attack)),
                    Err(refusal) => found.refused.push(refusal),
                }
            }
            self.drive(&mut tried, effort.drives);
            self.look(&mut tried, effort.delay);
            for (arm, numbers, attack) in tried {
                past.push(Tried {
                    arm,
                    numbers,
                    cost: attack.cost(),
                });
                found.attacks.push(attack);
            }
            past.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            // What was not looked at may be one that nobody survives.
            let survived = found.attacks.iter().filter(|a| a.survivable == Some(true));
            let best = survived.map(Attack::cost).fold(f64::INFINITY, f64::min);
            let goes_on = watch(found.progress()) && !(self.stop)();
            if !goes_on || best <= BEST || best <= GOOD && 2 * round >= rounds {
                break;
            }
        }
        found.attacks.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
        found
    }

    fn make(&self, arm: &Arm, manoeuvre: Manoeuvre) -> Result<Attack, Refusal> {
        if (self.stop)() {
            return Err(Refusal::answer("the search was stopped"));
        }
        let obstacle = self.ground.obstacle(arm.obstacle)?;
        let change = motion::of_manoeuvre(self.ground.stage, obstacle, &manoeuvre, arm.way)?;
        self.ground.attack(Motion::Manoeuvre(manoeuvre), change)
    }

    /// Looks whether a good driver survives what the ego did not, the most dangerous first.
    fn look(&self, tried: &mut [(usize, Numbers, Attack)], delay: f64) {
        tried.sort_by(|a, b| a.2.cost().total_cmp(&b.2.cost()));
        let effective = tried.iter_mut().map(|t| &mut t.2);
        let effective = effective.filter(|a| a.has_effect()).take(LOOKED_AT);
        for attack in effective {
            if (self.stop)() {
                break;
            }
            self.ground.survive(attack, delay);
            if attack.cost() <= BEST {
                break;
            }
        }
    }

    /// Drives the ego against the most promising attacks, not more than half of them by one arm.
    fn drive(&self, tried: &mut [(usize, Numbers, Attack)], drives: usize) {
        tried.sort_by(|a, b| a.2.cost().total_cmp(&b.2.cost()));
        let mut taken: Vec<usize> = Vec::new();
        let mut chosen: Vec<&mut Attack> = Vec::new();
        for (arm, _, attack) in tried.iter_mut() {
            let same = taken.iter().filter(|a| *a == arm).count();
            if chosen.len() < drives && same < drives.div_ceil(2) {
                taken.push(*arm);
                chosen.push(attack);
            }
        }
        chosen.into_par_iter().for_each(|attack| {
            if !(self.stop)() {
                self.ground.drive(attack);
            }
        });
    }
}

/// What is to be tried: in the first round of all arms alike, later mostly around what did well, ever closer.
fn draw(
    arms: &[Arm],
    past: &[Tried],
    count: usize,
    round: usize,
    random: &mut fastrand::Rng,
) -> Vec<(usize, Numbers)> {
    let elite = elite(past);
    let best = elite.first().map_or(0.0, |t| t.cost);
    let weights: Vec<f64> = { elite.iter() }
        .map(|t| (SHARPNESS * (best - t.cost)).exp())
        .collect();
    let total: f64 = weights.iter().sum();
    let spread = SPREAD / round.max(1) as f64;
    (0..count)
        .map(|i| {
            if elite.is_empty() || random.f64() < EXPLORE {
                let arm = if round == 0 {
                    i % arms.len()
                } else {
                    random.usize(..arms.len())
                };
                return (arm, arms[arm].sample(random));
            }
            let mut left = random.f64() * total;
            let chosen = weights.iter().position(|w| {
                left -= w;
                left <= 0.0
            });
            let parent = elite[chosen.unwrap_or(0)];
            (
                parent.arm,
                arms[parent.arm].around(&parent.numbers, spread, random),
            )
        })
        .collect()
}

/// The best of those that were tried, which are in order; of no arm more than a few.
fn elite(past: &[Tried]) -> Vec<&Tried> {
    let mut elite: Vec<&Tried> = Vec::new();
    for tried in past {
        let same = elite.iter().filter(|t| t.arm == tried.arm).count();
        if elite.len() < ELITE && same < ELITE / 3 {
            elite.push(tried);
        }
    }
    elite
}
