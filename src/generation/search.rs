//! Attacks without any model: a cross-entropy search over the numbers of manoeuvres.
//!
//! Source: Rubinstein and Kroese, The Cross-Entropy Method (2004), as O'Kelly et al. 2018 use it for rare events. Each
//! round draws manoeuvres, makes motions of them, leaves out what the gate refuses, looks at the rest beside an ego
//! that only brakes, and drives the ego against the most promising ones. What worked is drawn more often. The
//! same seed gives the same attacks.

use rayon::prelude::*;

use super::arms::{Arm, Numbers};
use super::attack::{Attack, Ground};
use super::attacker::{self, Candidate};
use super::{Refusal, motion};
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
    /// Of the random numbers.
    pub seed: u64,
}

impl Default for Effort {
    fn default() -> Self {
        Self {
            candidates: 200,
            rounds: 6,
            drives: 5,
            attackers: 6,
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

/// The share of what an arm tried that it learns from.
const ELITE: f64 = 0.25;

/// A share of the draws that goes to all arms alike, in every round.
const EXPLORE: f64 = 0.3;

/// How much more often an arm is drawn that is better by 1.
const SHARPNESS: f64 = 2.0;

/// The search in one scenario.
struct Search<'a> {
    ground: &'a Ground<'a>,
}

/// What became of one draw.
struct Draw {
    arm: usize,
    numbers: Numbers,
    made: Result<Attack, Refusal>,
}

/// Searches for attacks; `only` names the one obstacle that may attack.
#[must_use]
pub fn search(ground: &Ground<'_>, effort: &Effort, only: Option<i64>) -> Found {
    Search { ground }.run(effort, only)
}

impl Search<'_> {
    fn run(&self, effort: &Effort, only: Option<i64>) -> Found {
        let ranked = attacker::rank(self.ground.stage);
        let chosen = ranked
            .iter()
            .filter(|c| only.is_none_or(|id| c.obstacle == id));
        let chosen: Vec<&Candidate> = chosen.take(effort.attackers).collect();
        let mut arms: Vec<Arm> = chosen
            .iter()
            .flat_map(|c| Arm::all(self.ground.stage, c))
            .collect();
        let mut random = fastrand::Rng::with_seed(effort.seed);
        let mut found = Found::default();
        if arms.is_empty() {
            return found;
        }
        let each = (effort.candidates / effort.rounds.max(1)).max(1);
        let mut past: Vec<(usize, Numbers, f64)> = Vec::new();
        for round in 0..effort.rounds {
            let count = if round + 1 == effort.rounds {
                effort.candidates - each * round
            } else {
                each
            };
            let asked: Vec<(usize, Manoeuvre, Numbers)> = pick(&arms, count, round, &mut random)
                .into_iter()
                .map(|arm| {
                    let (manoeuvre, numbers) = arms[arm].sample(&mut random);
                    (arm, manoeuvre, numbers)
                })
                .collect();
            let draws: Vec<Draw> = asked
                .into_par_iter()
                .map(|(arm, manoeuvre, numbers)| Draw {
                    arm,
                    numbers,
                    made: self.make(&arms[arm], manoeuvre),
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
            for (arm, numbers, attack) in tried {
                let cost = attack.cost();
                arms[arm].best = arms[arm].best.min(cost);
                past.push((arm, numbers, cost));
                found.attacks.push(attack);
            }
            for (place, arm) in arms.iter_mut().enumerate() {
                arm.learn(&elite(&past, place));
            }
        }
        found.attacks.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
        found
    }

    fn make(&self, arm: &Arm, manoeuvre: Manoeuvre) -> Result<Attack, Refusal> {
        let obstacle = self.ground.obstacle(arm.obstacle)?;
        let change = motion::of_manoeuvre(self.ground.stage, obstacle, &manoeuvre, arm.way)?;
        self.ground.attack(Motion::Manoeuvre(manoeuvre), change)
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
            self.ground.drive(attack);
        });
    }
}

/// Which arm each draw is of: in the first round all alike, later mostly those that did well.
fn pick(arms: &[Arm], count: usize, round: usize, random: &mut fastrand::Rng) -> Vec<usize> {
    if round == 0 {
        return (0..count).map(|i| i % arms.len()).collect();
    }
    let best = arms.iter().map(|arm| arm.best);
    let best = best.fold(f64::INFINITY, f64::min);
    let weight = |arm: &Arm| match arm.best.is_finite() {
        true => (SHARPNESS * (best - arm.best)).exp(),
        false => 0.0,
    };
    let total: f64 = arms.iter().map(weight).sum();
    (0..count)
        .map(|_| {
            if total <= 0.0 || random.f64() < EXPLORE {
                return random.usize(..arms.len());
            }
            let mut left = random.f64() * total;
            for (place, arm) in arms.iter().enumerate() {
                left -= weight(arm);
                if left <= 0.0 {
                    return place;
                }
            }
            arms.len() - 1
        })
        .collect()
}

/// The numbers of the best that an arm has tried.
fn elite(past: &[(usize, Numbers, f64)], arm: usize) -> Vec<Numbers> {
    let mut of_arm: Vec<&(usize, Numbers, f64)> = past.iter().filter(|p| p.0 == arm).collect();
    of_arm.sort_by(|a, b| a.2.total_cmp(&b.2));
    let count = (of_arm.len() as f64 * ELITE).ceil() as usize;
    of_arm.iter().take(count).map(|p| p.1).collect()
}
