//! All measures of whole scenes, beside the exact distance alone over the same scenes.
//!
//! The figures to read are ratios: `all` over `distance`, both from prepared scenes to a full series on one core.
//! The absolute figures (whole set, a row, the median scene) are printed first. Scenes: the bundled ones, and those
//! in the folder that NEARMISS_SHARED names (or ../shared).

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use nearmiss::formats::{Entry, bundled, find};
use nearmiss::metrics::{Context, MEASURES, Measure, Series, measure};
use nearmiss::scenario::Scene;

fn scenes(entries: &[Entry]) -> Vec<Scene> {
    let scene = |entry: &Entry| {
        let scenario = entry.read().expect("a scenario");
        let ego = entry.recorded_ego(&scenario).expect("readable")?;
        Some(Scene::new(scenario, ego))
    };
    entries.iter().filter_map(scene).collect()
}

fn all() -> Vec<&'static Measure> {
    MEASURES.iter().collect()
}

fn values(scene: &Scene, measures: Vec<&'static Measure>) -> usize {
    let series = Series::compute(scene, measures);
    series.obstacles().len() + series.steps().count()
}

/// A copy that shares nothing, so that no road is prepared.
fn fresh(scene: &Scene) -> Scene {
    let mut copy = scene.clone();
    copy.scenario = std::sync::Arc::new((*scene.scenario).clone());
    copy
}

fn report(name: &str, scenes: &[Scene]) {
    let mut times: Vec<Duration> = Vec::new();
    let mut rows = 0;
    for scene in scenes {
        let scene = fresh(scene);
        let start = Instant::now();
        let series = black_box(Series::compute(&scene, all()));
        times.push(start.elapsed());
        let there = |id: i64| {
            series
                .row("distance", id)
                .iter()
                .filter(|r| r.value().is_some())
                .count()
        };
        rows += series
            .obstacles()
            .iter()
            .map(|&id| there(id))
            .sum::<usize>();
    }
    times.sort();
    let total: Duration = times.iter().sum();
    println!(
        "{name}: {} scenes, {rows} rows, {} measures: {total:.1?}, {:.2?} a row, median scene {:.2?}, slowest {:.2?}",
        scenes.len(),
        MEASURES.len(),
        total / u32::try_from(rows.max(1)).unwrap_or(u32::MAX),
        times[times.len() / 2],
        times[times.len() - 1],
    );
    let routes: Duration = scenes
        .iter()
        .map(|scene| {
            let scene = fresh(scene);
            let start = Instant::now();
            let context = Context::new(&scene);
            let _ = black_box(context.road());
            start.elapsed()
        })
        .sum();
    println!("  {:16} alone {routes:.1?}", "(routes)");
    for m in MEASURES {
        let time: Duration = scenes
            .iter()
            .map(|scene| {
                let scene = fresh(scene);
                let start = Instant::now();
                black_box(Series::compute(&scene, vec![m]));
                start.elapsed()
            })
            .sum();
        println!("  {:16} alone {time:.1?}", m.id);
    }
}

fn measures(criterion: &mut Criterion) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let shared = std::env::var_os("NEARMISS_SHARED").map_or(root.join("../shared"), PathBuf::from);
    let mut sets = vec![("bundled", scenes(&bundled()))];
    let published = shared.join("data/from-words-to-collisions");
    if published.is_dir() {
        sets.push((
            "shared",
            scenes(&find(&[published]).expect("scenarios").entries),
        ));
    }
    for (name, scenes) in sets {
        report(name, &scenes);
        let mut group = criterion.benchmark_group(format!("measures/{name}"));
        group.sample_size(10);
        let distance = measure("distance").expect("a measure");
        group.bench_function("distance", |b| {
            b.iter(|| {
                scenes
                    .iter()
                    .map(|s| values(black_box(s), vec![distance]))
                    .sum::<usize>()
            })
        });
        group.bench_function("all", |b| {
            b.iter(|| {
                scenes
                    .iter()
                    .map(|s| values(black_box(s), all()))
                    .sum::<usize>()
            })
        });
        group.finish();
    }
}

criterion_group!(benches, measures);
criterion_main!(benches);
