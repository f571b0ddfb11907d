//! How long before the published collisions the judge sees them, with floors, and how it holds where it was not chosen.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use nearmiss::evaluation::{Candidate, Confusion, Labelled, Lead, Scored, Setting};
use nearmiss::formats::find;
use nearmiss::judge::Criterion;
use nearmiss::metrics::Thresholds;
use nearmiss::scenario::Scene;
use nearmiss::scenario::prediction::ObservedHistory;

use crate::support::program::skipped;

const LEADS: [f64; 5] = [0.2, 0.5, 1.0, 1.5, 2.0];

/// The published scenarios, collisions and safe ones in turns; nothing, and a word about it, where they are not here.
fn published() -> Option<&'static [Scene]> {
    static ALL: OnceLock<Vec<Scene>> = OnceLock::new();
    let shared = std::env::var_os("NEARMISS_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"),
        PathBuf::from,
    );
    let folder = shared.join("data/from-words-to-collisions");
    if !folder.is_dir() {
        skipped(
            "the published scenarios are not here; NEARMISS_SHARED can name the folder that holds data/",
        );
        return None;
    }
    let read = || {
        let open = |entry: nearmiss::formats::Entry| {
            let scenario = entry.read().unwrap();
            let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
            Scene::new(Arc::clone(&scenario), ego)
        };
        find(&[folder])
            .unwrap()
            .entries
            .into_iter()
            .map(open)
            .collect()
    };
    Some(ALL.get_or_init(read))
}

fn labelled(scenes: &[Scene]) -> Vec<Labelled<'_>> {
    scenes.iter().map(|s| Labelled::new(s, None)).collect()
}

/// Counts of each candidate at each lead, whomever a yes names; and those where it has to name who collides.
fn counts(cases: &[Labelled<'_>], candidates: &[Candidate]) -> [Vec<Vec<Confusion>>; 2] {
    let leads = LEADS.map(Lead::Seconds);
    let leads: Vec<Lead> = [Lead::Paper].into_iter().chain(leads).collect();
    let setting = Setting {
        leads: leads.clone(),
        history: 10,
        radius: 30.0,
        candidates: candidates.to_vec(),
        thresholds: Arc::new(Thresholds::shipped().clone()),
        every_window: false,
    };
    let ask = |case: &Labelled<'_>| setting.ask(&case.scene.scenario.header.benchmark_id, case);
    let answers = setting.join(cases.iter().map(ask));
    let of = |yes: fn(&Scored) -> Option<bool>| {
        let row = answers.iter().map(|of| &of.leads);
        row.map(|leads| {
            leads
                .iter()
                .map(|at| Confusion::from_scored(at, yes))
                .collect()
        })
        .collect()
    };
    [of(Scored::dangerous), of(Scored::positive)]
}

fn f1(c: &Confusion) -> f64 {
    c.f1().unwrap()
}

#[test]
fn collisions_are_seen_long_before_and_few_others() {
    let Some(scenes) = published() else { return };
    let mut candidates = vec![Candidate::REFERENCE];
    let horizons = [1.0, 1.5, 2.0, 2.5, 3.0];
    candidates.extend(Candidate::named("reference/constant-velocity", &horizons).unwrap());
    let [counts, strict] = counts(&labelled(scenes), &candidates);
    // Until 0.5 s before, its yes names who collides, with a score of 0 or 1.
    for (c, floor) in strict[0].iter().zip([0.95, 0.95, 0.93]) {
        assert!(f1(c) >= floor, "{c:?}");
    }
    for (candidate, row) in candidates.iter().zip(&counts) {
        let row: Vec<String> = row
            .iter()
            .map(|c| format!("{:.3} ({:.2})", f1(c), c.precision().unwrap_or_default()))
            .collect();
        println!(
            "{:<28} {:.1} s  F1 (precision): {}",
            candidate.name,
            candidate.criterion.horizon,
            row.join("  ")
        );
    }
    let reference = &counts[0];
    // At the paper's windows, then 0.2 s, 0.5 s, 1 s, 1.5 s, 2 s before.
    let floors = [0.95, 0.95, 0.95, 0.93, 0.90, 0.65];
    for (place, (c, floor)) in reference.iter().zip(floors).enumerate() {
        assert!(f1(c) >= floor, "lead {place}: {c:?}");
        assert!(c.precision().unwrap() >= 0.85, "lead {place}: {c:?}");
        assert_eq!(c.negatives(), 30);
        assert!(c.positives() >= 29, "{c:?}");
        // Better than constant velocity at whichever horizon suits it best at this lead.
        let best = counts[1..]
            .iter()
            .map(|row| f1(&row[place]))
            .fold(0.0, f64::max);
        assert!(
            f1(c) >= best,
            "lead {place}: {c:?}, constant velocity {best:.3}"
        );
    }
}

/// The greatest probability of contact at each lead, by horizon.
struct Curves {
    country: String,
    collides: bool,
    at: Vec<Vec<Option<f64>>>,
}

const HORIZONS: [f64; 5] = [1.0, 1.5, 2.0, 2.5, 3.0];
const THRESHOLDS: [f64; 7] = [0.1, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5];

fn curves(case: &Labelled<'_>) -> Curves {
    let probability = |horizon: f64, lead: f64| {
        let past = ObservedHistory::from_window(case.scene, &case.window(Lead::Seconds(lead), 10)?);
        let criterion = Criterion {
            horizon,
            ..Criterion::REFERENCE
        };
        let most = criterion.prospects(&past, Some(30.0));
        Some(most.first().map_or(0.0, |p| p.probability))
    };
    let at = HORIZONS.map(|horizon| LEADS.map(|lead| probability(horizon, lead)).to_vec());
    Curves {
        country: case.scene.scenario.header.benchmark_id[..3].to_string(),
        collides: case.label.collides(),
        at: at.to_vec(),
    }
}

/// Counts at each lead with one choice.
fn with_choice<'a>(
    cases: impl Iterator<Item = &'a Curves>,
    horizon: usize,
    threshold: f64,
) -> Vec<Confusion> {
    let mut found = vec![Confusion::default(); LEADS.len()];
    for case in cases {
        for (lead, c) in found.iter_mut().enumerate() {
            if let Some(p) = case.at[horizon][lead] {
                c.count(p >= threshold, case.collides);
            }
        }
    }
    found
}

fn mean(counts: &[Confusion]) -> f64 {
    counts.iter().map(f1).sum::<f64>() / counts.len() as f64
}

/// The choice with the best mean F1 on some cases.
fn best<'a>(cases: impl Iterator<Item = &'a Curves> + Clone) -> (usize, f64, f64) {
    let mut best = (0, 0.0, -1.0);
    for horizon in 0..HORIZONS.len() {
        for threshold in THRESHOLDS {
            let mean = mean(&with_choice(cases.clone(), horizon, threshold));
            if mean > best.2 {
                best = (horizon, threshold, mean);
            }
        }
    }
    best
}

#[test]
fn horizon_and_threshold_hold_where_they_were_not_chosen() {
    let Some(scenes) = published() else { return };
    let all: Vec<Curves> = labelled(scenes).iter().map(curves).collect();
    let (horizon, threshold, fitted) = best(all.iter());
    println!(
        "best on all 60: {} s, {threshold}: mean F1 {fitted:.3}",
        HORIZONS[horizon]
    );
    let reference = Criterion::REFERENCE;
    let place = HORIZONS
        .iter()
        .position(|h| *h == reference.horizon)
        .unwrap();
    let kept = with_choice(all.iter(), place, reference.threshold);
    println!("kept: mean F1 {:.3}", mean(&kept));
    assert!(mean(&kept) >= fitted - 0.03, "far from the best");

    let abroad =
        |c: &Curves| usize::from(["BEL", "ESP", "GRC", "ITA"].contains(&c.country.as_str()));
    type Split<'a> = (&'a str, usize, Box<dyn Fn(usize, &Curves) -> usize + 'a>);
    let splits: [Split<'_>; 3] = [
        ("halves", 2, Box::new(|at, _| at % 2)),
        ("fifths", 5, Box::new(|at, _| at % 5)),
        ("countries", 2, Box::new(|_, c| abroad(c))),
    ];
    for (split, folds, fold_of) in splits {
        let mut held = vec![Confusion::default(); LEADS.len()];
        for fold in 0..folds {
            let own = |at: &(usize, &Curves)| fold_of(at.0, at.1) == fold;
            let rest = all.iter().enumerate().filter(|at| !own(at)).map(|(_, c)| c);
            let (horizon, threshold, fitted) = best(rest);
            let tested = all.iter().enumerate().filter(own).map(|(_, c)| c);
            let counts = with_choice(tested, horizon, threshold);
            println!(
                "{split}, {fold}: {} s, {threshold}: chosen with mean F1 {fitted:.3}, held out {:.3}",
                HORIZONS[horizon],
                mean(&counts)
            );
            for (sum, c) in held.iter_mut().zip(&counts) {
                sum.true_positives += c.true_positives;
                sum.false_positives += c.false_positives;
                sum.false_negatives += c.false_negatives;
                sum.true_negatives += c.true_negatives;
            }
        }
        let row: Vec<String> = held
            .iter()
            .map(|c| format!("{:.3} ({:.2})", f1(c), c.precision().unwrap_or_default()))
            .collect();
        println!(
            "held out, {folds} folds, F1 (precision): {}",
            row.join("  ")
        );
        assert!(f1(&held[0]) >= 0.93, "{held:?}");
        assert!(mean(&held) >= fitted - 0.08, "{held:?}");
        assert!(
            held.iter().all(|c| c.precision().unwrap() >= 0.8),
            "{held:?}"
        );
    }
}
