//! Tests of comparisons on simulated batches: how often equal models seem to differ, and different ones are found.

use super::*;

/// Scenarios of a simulated batch, half of them collisions, and samples of each question.
const SCENARIOS: usize = 42;
const SAMPLES: u32 = 2;

/// How often each model is wrong, by scenario.
type Noise = fn(usize) -> f64;

/// The answers of two models to the same questions; every answer is wrong by chance, whatever the other ones are.
fn batch(random: &mut fastrand::Rng, noise: [Noise; 2]) -> Vec<Scored> {
    let mut scored = Vec::new();
    for (model, noise) in ["lab/a", "lab/b"].into_iter().zip(noise) {
        let way = way(Task::Safety, "cp", model);
        for n in 0..SCENARIOS {
            let collides = n.is_multiple_of(2);
            let truth = if collides {
                Label::Collision(Some(7))
            } else {
                Label::Safe
            };
            for sample in 0..SAMPLES {
                let wrong = random.f64() < noise(n);
                let mut one = one(
                    &format!("s{n}"),
                    &way,
                    Some(truth),
                    says(collides != wrong, &[]),
                );
                one.sample = sample;
                scored.push(one);
            }
        }
    }
    scored
}

/// The share of batches whose declared comparison is significant at 5 %.
fn significant(seed: u64, noise: [Noise; 2]) -> (f64, f64) {
    let asked = std::env::var("NEARMISS_SIMULATED_BATCHES");
    let batches: u32 = asked.ok().and_then(|n| n.parse().ok()).unwrap_or(200);
    let mut random = fastrand::Rng::with_seed(seed);
    let declared = Comparison {
        primary: Some(("lab/a".into(), "lab/b".into())),
        ..Comparison::default()
    };
    let found = (0..batches).filter(|_| {
        let report = Report::compared(&batch(&mut random, noise), &declared);
        let [pair] = &report.pairs[..] else {
            panic!("{:?}", report.pairs)
        };
        assert_eq!((pair.family, pair.n), (Family::Declared, 42));
        pair.corrected < 0.05
    });
    let share = found.count() as f64 / f64::from(batches);
    println!("{share:.3} of {batches} batches");
    (share, f64::from(batches))
}

#[test]
fn equal_models_seldom_differ() {
    let same: [(u64, Noise); 2] = [
        (2, |_| 0.30),
        // Some scenarios are hard for both: answers about one are alike.
        (3, |n| if n.is_multiple_of(3) { 0.75 } else { 0.05 }),
    ];
    for (seed, noise) in same {
        let (share, batches) = significant(seed, [noise; 2]);
        // Two standard errors of 5 %.
        let most = 0.05 + 2.0 * (0.05 * 0.95 / batches).sqrt();
        assert!(share <= most, "{share}");
    }
}

#[test]
fn eight_against_thirty_per_cent_of_noise_are_told_apart() {
    let (share, _) = significant(4, [|_| 0.08, |_| 0.30]);
    assert!(share >= 0.8, "{share}");
}
