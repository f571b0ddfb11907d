//! Frames of the workbench at 200 × 60, with the update before each, beside a frame with nothing on it.
//!
//! The figures to read are ratios over `nothing` of the same group, and the times of `windows` and `pixels`. Scenarios: of the published ones the one with
//! the most obstacles and the one with the most lanelets, where `NEARMISS_SHARED` or `../shared` has them; else the
//! bundled one with the most bytes.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use nearmiss::formats::{Entry, bundled};
use nearmiss::scenario::Scenario;
use nearmiss::tui::headless::Stage;

const SIZE: (u16, u16) = (200, 60);

/// The most obstacles, and the most lanelets.
const LARGEST: [&str; 2] = [
    "from-words-to-collisions/Scenarios/collision_scenarios/ESP_Barcelona-10_44_T-1.xml",
    "commonroad-io/ARG_Carcarana-4_5_T-1.xml",
];

fn scenarios() -> Vec<Entry> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let shared = std::env::var_os("NEARMISS_SHARED").map_or(root.join("../shared"), PathBuf::from);
    let files = LARGEST.map(|name| shared.join("data").join(name));
    if files.iter().all(|file| file.is_file()) {
        return files.iter().map(|file| Entry::of_file(file)).collect();
    }
    println!(
        "skipped: the published scenarios are not at {}; a bundled one takes their place",
        shared.display()
    );
    let bytes = |e: &Entry| {
        let file = root.join("scenarios").join(format!("{}.xml", e.name));
        file.metadata().map_or(0, |m| m.len())
    };
    bundled()
        .into_iter()
        .max_by_key(bytes)
        .into_iter()
        .collect()
}

/// An answer of so many bytes at least, with claims about an obstacle in it and JSON at the end.
fn answer(bytes: usize, obstacle: i64) -> String {
    let mut text = String::from("# Analysis\n\n");
    let mut step = 0;
    while text.len() < bytes {
        text.push_str(&format!(
            "## Step {step}\n\n- **Obstacle {obstacle}** is 12.3 m ahead of the ego and to the left; its TTC is 2.5 s, \
             and the gap shrinks step by step, so that a braking vehicle `in front` would have to be avoided.\n\
             - No other obstacle matters at this step.\n\n"
        ));
        step += 1;
    }
    text + "```json\n{\"dangerous\": true,\n \"obstacles\": [1, 2]}\n```\n"
}

/// Four answers of this length, the last one shown.
fn ask_four(stage: &mut Stage, bytes: usize, obstacle: i64) {
    for name in ["lab/a", "lab/b", "lab/c", "lab/d"] {
        let place = stage.ask(name);
        stage.end(place, &answer(bytes, obstacle));
    }
}

/// Steps the clock, back at the end of the recording.
fn step(stage: &mut Stage, count: &mut u32) {
    *count += 1;
    stage.press(if (*count).is_multiple_of(30) {
        "home"
    } else {
        "right"
    });
    stage.draw();
}

fn stage(entry: &Entry) -> Stage {
    let stage = Stage::open(entry, SIZE);
    stage.unwrap_or_else(|error| panic!("{}: {error}", entry.display()))
}

/// An obstacle by its number, for answers to speak of.
fn obstacle(scenario: &Scenario) -> i64 {
    scenario.obstacles.first().map_or(1, |o| o.id)
}

/// The busiest view: all layers, paths of all near the ego, strips, four answers, and a step of the clock.
fn busiest(criterion: &mut Criterion) {
    for entry in scenarios() {
        let mut group = criterion.benchmark_group(format!("busiest {}", entry.name));
        group.sample_size(30);
        let (mut stage, mut n) = (stage(&entry), 0);
        group.bench_function("nothing", |b| b.iter(|| stage.draw_nothing()));
        stage.draw();
        group.bench_function("plain", |b| b.iter(|| step(&mut stage, &mut n)));
        // Without an ego there is nothing to ask about.
        if !stage.has_ego() {
            group.finish();
            continue;
        }
        let scenario = entry.read().unwrap_or_else(|error| panic!("{error}"));
        ask_four(&mut stage, 4_000, obstacle(&scenario));
        stage.press("n");
        group.bench_function("with_answers", |b| b.iter(|| step(&mut stage, &mut n)));
        stage.press("space m p space m p");
        println!("{} paths, {} claims", stage.paths(), stage.claims());
        group.bench_function("with_answers_and_paths", |b| {
            b.iter(|| step(&mut stage, &mut n))
        });
        group.bench_function("the_same_step", |b| b.iter(|| stage.draw()));
        stage.press("space m a");
        group.bench_function("the_whole_map", |b| b.iter(|| step(&mut stage, &mut n)));
        stage.press("space a t");
        group.bench_function("the_safety_task", |b| b.iter(|| step(&mut stage, &mut n)));
        stage.press("space a t space o c");
        group.bench_function("side_by_side", |b| b.iter(|| stage.draw()));
        group.finish();
    }
}

/// A planned ego: stepping through its cycles with and without the planner's layer, and with the panel beside it.
fn planned(criterion: &mut Criterion) {
    let drives = |entry: &Entry| {
        let scenario = entry.read();
        scenario.is_ok_and(|scenario| !scenario.planning_problems.is_empty())
    };
    let bundled = bundled().into_iter().filter(|e| e.name.contains("CutIn"));
    for entry in scenarios().into_iter().chain(bundled).filter(drives) {
        let mut group = criterion.benchmark_group(format!("planned {}", entry.name));
        group.sample_size(30);
        let (mut stage, mut n) = (stage(&entry), 0);
        group.bench_function("nothing", |b| b.iter(|| stage.draw_nothing()));
        group.bench_function("recorded_ego", |b| b.iter(|| step(&mut stage, &mut n)));
        if let Err(error) = stage.drive() {
            println!("skipped: {}: {error}", entry.display());
            group.finish();
            continue;
        }
        stage.show_planner(false);
        group.bench_function("without_the_layer", |b| b.iter(|| step(&mut stage, &mut n)));
        stage.show_planner(true);
        group.bench_function("with_the_layer", |b| b.iter(|| step(&mut stage, &mut n)));
        stage.press("space e w");
        group.bench_function("with_layer_and_panel", |b| {
            b.iter(|| step(&mut stage, &mut n))
        });
        group.finish();
    }
}

/// A long answer: at rest, while it grows, and the update of a chunk alone.
fn streaming(criterion: &mut Criterion) {
    let Some(entry) = scenarios().into_iter().next() else {
        return;
    };
    let mut group = criterion.benchmark_group("200 kB answer");
    group.sample_size(20);
    let mut stage = stage(&entry);
    group.bench_function("nothing", |b| b.iter(|| stage.draw_nothing()));
    group.bench_function("without_an_answer", |b| b.iter(|| stage.draw()));
    let scenario = entry.read().unwrap_or_else(|error| panic!("{error}"));
    let text = answer(200_000, obstacle(&scenario));
    let first = stage.ask("lab/a");
    stage.arrive(first, &text);
    group.bench_function("a_chunk", |b| b.iter(|| stage.arrive(first, " a")));
    stage.end(first, &text);
    println!("{} claims", stage.claims());
    group.bench_function("at_rest", |b| b.iter(|| stage.draw()));
    let second = stage.ask("lab/b");
    stage.arrive(second, &text);
    group.bench_function("growing", |b| {
        b.iter(|| {
            stage.arrive(second, " gap");
            stage.draw();
        })
    });
    group.finish();
}

/// Thousands of scenarios in the list: going through it, and typing a filter.
fn thousands(criterion: &mut Criterion) {
    let Some(entry) = bundled().into_iter().next() else {
        return;
    };
    let mut group = criterion.benchmark_group("2000 scenarios");
    group.sample_size(20);
    let mut stage = stage(&entry);
    group.bench_function("nothing", |b| b.iter(|| stage.draw_nothing()));
    let name = |i: usize| format!("f{}/DEU_Town{i:04}-1_1_T-1.xml", i % 7);
    let entries = (0..2_000).map(|i| Entry::of_file(Path::new(&name(i))));
    stage.list(entries.collect());
    group.bench_function("frame", |b| b.iter(|| stage.draw()));
    group.bench_function("filter_and_frame", |b| {
        b.iter(|| {
            stage.press("/ t o w n 1 2");
            stage.draw();
            assert!((1..2_000).contains(&stage.listed()));
            stage.press("esc");
        })
    });
    group.finish();
}

/// Stepping through windows of the safety task for the first time: what the loop does from a key to its frame. The
/// built-in judge works beside it, and is not counted.
fn windows(criterion: &mut Criterion) {
    for entry in scenarios() {
        if !stage(&entry).has_ego() {
            continue;
        }
        let mut group = criterion.benchmark_group(format!("windows {}", entry.name));
        group.sample_size(20);
        let begin = || {
            let mut stage = stage(&entry);
            stage.press("space a t home");
            stage.draw();
            stage
        };
        let mut at = begin();
        group.bench_function("first_step", |b| {
            b.iter_custom(|times| {
                let mut took = Duration::ZERO;
                for _ in 0..times {
                    let mut begun = Instant::now();
                    if !at.step() {
                        at = begin();
                        begun = Instant::now();
                        at.step();
                    }
                    at.draw();
                    took += begun.elapsed();
                    at.compute();
                }
                took
            })
        });
        group.finish();
    }
}

/// A step with the map as an image of 200 × 60 cells of 10 × 20 pixels: painted and encoded for kitty. Ten of them a
/// second are playback in real time: times ten, the figure is the part of a core that it takes.
fn pixels(criterion: &mut Criterion) {
    for entry in scenarios() {
        let mut group = criterion.benchmark_group(format!("pixels {}", entry.name));
        group.sample_size(20);
        // Beside the map there are its frame, the timeline, and a line above and below.
        let mut stage = Stage::open(&entry, (SIZE.0 + 2, SIZE.1 + 12))
            .unwrap_or_else(|error| panic!("{}: {error}", entry.display()));
        stage.press("tab z");
        let mut n = 0;
        group.bench_function("cells", |b| b.iter(|| step(&mut stage, &mut n)));
        for (name, compressed) in [("image", false), ("compressed", true)] {
            stage.show_pixels((10, 20), compressed);
            group.bench_function(name, |b| b.iter(|| step(&mut stage, &mut n)));
        }
        group.finish();
    }
}

criterion_group!(
    benches, busiest, planned, streaming, thousands, windows, pixels
);
criterion_main!(benches);
