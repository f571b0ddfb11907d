//! Attacks without any model: a cross-entropy search over the numbers of manoeuvres.
//!
//! Source: Rubinstein and Kroese, The Cross-Entropy Method (2004), as O'Kelly et al. 2018 use it for rare events. Each
//! round draws manoeuvres, makes motions of them, leaves out what the gate refuses, looks at the rest beside an ego
//! that only brakes, and drives the ego against the most promising ones. What worked is drawn more often. The
//! same seed gives the same attacks.

use rayon::prelude::*;

use super::arms::{Arm, Numbers};
use super::attacker::{self, Candidate};
use super::{
    Change, ClosedLoop, Consequence, Effect, Gate, Reason, Refusal, Rehearsal, Stage, motion,
};
use crate::simulation::Face;
use crate::verdict::Manoeuvre;

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

/// An attack that has passed the gate.
#[derive(Debug, Clone)]
pub struct Attack {
    /// What was asked of the attacker.
    pub manoeuvre: Manoeuvre,
    /// What it does.
    pub change: Change,
    /// How near that comes to an ego that only brakes.
    pub rehearsal: Rehearsal,
    /// What the ego makes of it, where it was driven.
    pub effect: Option<Effect>,
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

/// So long after it was nearest to the ego an attack is over, seconds.
const OVER: f64 = 2.0;

/// What an attack that was not driven yet costs more: driving shows what a rehearsal only hopes.
const UNTRIED: f64 = 0.8;

/// What is searched in.
#[derive(Debug)]
pub struct Search<'a> {
    /// The original scenario with the ego's motion.
    pub stage: &'a Stage<'a>,
    /// What every motion has to pass.
    pub gate: &'a Gate<'a>,
    /// What drives the ego.
    pub closed_loop: &'a ClosedLoop,
}

/// What became of one draw.
struct Draw {
    arm: usize,
    numbers: Numbers,
    made: Result<Attack, Refusal>,
}

impl Search<'_> {
    /// Searches; `only` names the one obstacle that may attack.
    #[must_use]
    pub fn run(&self, effort: &Effort, only: Option<i64>) -> Found {
        let ranked = attacker::rank(self.stage);
        let chosen = ranked
            .iter()
            .filter(|c| only.is_none_or(|id| c.obstacle == id));
        let chosen: Vec<&Candidate> = chosen.take(effort.attackers).collect();
        let mut arms: Vec<Arm> = chosen
            .iter()
            .flat_map(|c| Arm::all(self.stage, c))
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
        let obstacle = self.stage.scenario.obstacle(arm.obstacle);
        let obstacle = obstacle.ok_or_else(|| Refusal::answer("no such obstacle"))?;
        let change = motion::of_manoeuvre(self.stage, obstacle, &manoeuvre, arm.way)?;
        let seen = Rehearsal::of(self.stage, obstacle, &change);
        let rehearsal = seen.ok_or_else(|| Refusal::answer("it never meets the ego"))?;
        Ok(Attack {
            manoeuvre,
            change: self.admitted(change, &rehearsal)?,
            rehearsal,
            effect: None,
        })
    }

    /// The change as it passes the gate. Where it would overlap somebody or leave the road only long after it was nearest
    /// to the ego, the attacker's motion ends before that: the others do not answer to it, and it is gone.
    fn admitted(&self, mut change: Change, seen: &Rehearsal) -> Result<Change, Refusal> {
        let over = seen.step + (OVER / self.stage.dt()).ceil() as i64;
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
            change.motions.retain(|(s, _)| *s < step);
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
            attack.effect = self.closed_loop.effect(&attack.change).ok();
        });
    }
}

impl Attack {
    /// How good it is, the less the better: below 0 where the ego was driven and did not get away.
    #[must_use]
    pub fn cost(&self) -> f64 {
        let Some(effect) = &self.effect else {
            return UNTRIED + self.rehearsal.cost();
        };
        match effect.consequence {
            Consequence::Collision(c) if c.with == effect.attacker && c.ego != Face::Rear => -3.0,
            Consequence::Collision(c) if c.with == effect.attacker => -0.5,
            Consequence::NearMiss => -2.0,
            Consequence::Collision(_) => 0.5,
            Consequence::NoEffect => {
                let distance = effect.distance.unwrap_or(20.0).min(20.0);
                0.5 + 0.3 * distance
            }
        }
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
