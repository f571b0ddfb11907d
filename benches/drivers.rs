//! Six drivers on an encounter: verdicts, and verdicts with last moments, beside one planning cycle's worth of measures.
//!
//! The figures to read are ratios over `moments`: finding the most severe moment with each obstacle of the same scenes.
//! Absolute figures are printed first. Scenes: the bundled ones, and those in the folder that NEARMISS_SHARED names (or
//! ../shared).

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use nearmiss::formats::{Entry, bundled, find};
use nearmiss::metrics::{Context, CriticalMoment, critical_moments};
use nearmiss::scenario::Scene;
use nearmiss_drive::driver::{Field, Preventability};

fn encounters(entries: &[Entry]) -> Vec<(Scene, CriticalMoment)> {
    let scene = |entry: &Entry| {
        let scenario = entry.read().ok()?;
        let ego = entry.recorded_ego(&scenario).ok()??;
        let scene = Scene::new(scenario, ego);
        let worst = critical_moments(&Context::new(&scene)).into_iter().next()?;
        (worst.grade.number() <= 2).then_some((scene, worst))
    };
    entries.iter().filter_map(scene).collect()
}

fn judged((scene, moment): &(Scene, CriticalMoment)) -> Option<Preventability> {
    let field = Field::around(scene, moment.obstacle, moment.step)?;
    Some(Preventability::of(&field))
}

fn with_moments((scene, moment): &(Scene, CriticalMoment)) -> Option<Preventability> {
    let field = Field::around(scene, moment.obstacle, moment.step)?;
    let found = Preventability::of(&field);
    Some(found.with_last_moments(&field))
}

fn report(name: &str, all: &[(Scene, CriticalMoment)], work: impl Fn(&(Scene, CriticalMoment))) {
    let mut times: Vec<Duration> = Vec::new();
    for one in all {
        let start = Instant::now();
        work(one);
        times.push(start.elapsed());
    }
    times.sort();
    let sum: Duration = times.iter().sum();
    let count = u32::try_from(times.len().max(1)).unwrap_or(u32::MAX);
    println!(
        "{name}: {} encounters, mean {:.2?}, median {:.2?}, slowest {:.2?}",
        times.len(),
        sum / count,
        times[times.len() / 2],
        times[times.len() - 1],
    );
}

fn drivers(criterion: &mut Criterion) {
    let shared = std::env::var_os("NEARMISS_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"),
        PathBuf::from,
    );
    let mut entries = bundled().to_vec();
    if let Ok(found) = find(&[shared.join("data/from-words-to-collisions")]) {
        entries.extend(found.entries);
    }
    let all = encounters(&entries);
    report("six drivers", &all, |one| {
        black_box(judged(one));
    });
    report("with last moments", &all, |one| {
        black_box(with_moments(one));
    });
    let mut group = criterion.benchmark_group("encounters");
    group.sample_size(10);
    group.bench_function("moments", |b| {
        b.iter(|| {
            for (scene, _) in &all {
                black_box(critical_moments(&Context::new(scene)));
            }
        });
    });
    group.bench_function("drivers", |b| {
        b.iter(|| {
            for one in &all {
                black_box(judged(one));
            }
        });
    });
    group.finish();
}

criterion_group!(benches, drivers);
criterion_main!(benches);
