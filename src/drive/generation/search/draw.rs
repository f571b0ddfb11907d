//! Which motions a round tries.

use crate::generation::manoeuvre_space::{ManoeuvreSpace, Numbers};
use crate::generation::surrogate::Trial;

/// The share of later draws that goes to all arms alike.
const EXPLORE: f64 = 0.4;

/// How much more often is drawn around what is better by 1.
const SHARPNESS: f64 = 2.0;

/// What is to be tried: in the first round of all `live` arms alike, later mostly around what did well, within a share
/// of its spread.
pub(super) fn draw(
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
