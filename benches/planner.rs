//! One planning cycle on one core: some 800 sampled trajectories among 20 obstacles, and how the cost grows with both.
//!
//! The figures to read are ratios: a cycle over the bare evaluation of as many states of polynomials, in the same run.
//! The median cycle (milliseconds), nanoseconds per candidate and per obstacle with their linear fits are printed
//! first. Then a whole drive with forecasts made anew and shared with other drives.

use std::hint::black_box;
use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use nearmiss::formats::bundled;
use nearmiss::planner::{Forecast, Planner, Polynomial, Sampling, Settings, Traffic};
use nearmiss::simulation::{Driver, Settings as Drive, TrafficMode};

#[path = "../tests/support/planned.rs"]
mod planned;

use planned::Place;

const CYCLES: usize = 61;

/// The median of some runs of `f`, seconds.
fn median(mut f: impl FnMut()) -> f64 {
    for _ in 0..5 {
        f();
    }
    let mut times: Vec<f64> = (0..CYCLES)
        .map(|_| {
            let start = Instant::now();
            f();
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[CYCLES / 2]
}

/// Along and across, value and two derivatives, at each step of each candidate.
fn polynomials(candidates: usize, steps: usize, dt: f64) -> f64 {
    let along = Polynomial::quartic([0.0, 12.0, 0.0], [9.0, 0.0], 4.0);
    let mut sum = 0.0;
    for i in 0..candidates {
        let target = 7.0 * i as f64 / candidates as f64 - 3.5;
        let across = Polynomial::quintic([0.1, 0.0, 0.0], [target, 0.0, 0.0], 4.0);
        for step in 0..=steps {
            let t = black_box(step as f64 * dt);
            let ([s, v, a], [d, d1, d2]) = (along.at(t), across.at(t));
            sum += s + v + a + d + d1 + d2;
        }
    }
    sum
}

/// Candidates of a cycle, and its median time in seconds.
fn cycle(place: &Place, settings: Settings, traffic: &Traffic) -> (usize, f64) {
    let mut planner = Planner::new(settings, &place.guide, &place.road, place.dt);
    let plan = planner.plan(&place.start, 0, traffic);
    assert_eq!(plan.emergency, None);
    let time = median(|| {
        black_box(planner.plan(black_box(&place.start), 0, traffic));
    });
    (plan.candidates, time)
}

/// Slope, value at 0 and the share of the variance that a straight line explains.
fn fit(points: &[(f64, f64)]) -> (f64, f64, f64) {
    let n = points.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let xy = mean(&|p| (p.0 - x) * (p.1 - y));
    let (xx, yy) = (mean(&|p| (p.0 - x).powi(2)), mean(&|p| (p.1 - y).powi(2)));
    (xy / xx, y - x * xy / xx, xy * xy / (xx * yy))
}

fn growth(what: &str, points: &[(f64, f64)]) {
    for (x, seconds) in points {
        let (ms, ns) = (seconds * 1e3, seconds * 1e9 / x);
        println!("  {x:4} {what}: {ms:.3} ms, {ns:.0} ns each");
    }
    let (slope, base, explained) = fit(points);
    let (ns, ms) = (slope * 1e9, base * 1e3);
    println!("  fit: {ns:.0} ns per one of the {what} and {ms:.3} ms besides, R² {explained:.4}");
}

fn report(place: &Place, usual: Settings, traffic: &Traffic) {
    let steps = usual.steps(place.dt);
    let (candidates, time) = cycle(place, usual, traffic);
    let bare = median(|| {
        black_box(polynomials(candidates, steps, place.dt));
    });
    println!(
        "{candidates} candidates of {steps} steps, 20 obstacles: median {:.3} ms; as many states of polynomials {:.3} ms, ratio {:.1}",
        time * 1e3,
        bare * 1e3,
        time / bare
    );
    // Final speeds make profiles, so that every candidate has its share of them.
    let by_candidates: Vec<(f64, f64)> = [2, 7, 17, 37]
        .map(|speeds| {
            let sampling = Sampling {
                speeds,
                offsets: 5,
                ..usual.sampling
            };
            let (count, time) = cycle(place, planned::settings(sampling), traffic);
            (count as f64, time)
        })
        .to_vec();
    growth("candidates", &by_candidates);
    let by_obstacles: Vec<(f64, f64)> = [5, 10, 20, 40]
        .map(|bodies| {
            let traffic = planned::traffic(place, steps, bodies);
            (bodies as f64, cycle(place, usual, &traffic).1)
        })
        .to_vec();
    growth("obstacles", &by_obstacles);
}

fn planner(criterion: &mut Criterion) {
    let place = planned::place();
    let usual = planned::settings(Settings::default().sampling);
    let steps = usual.steps(place.dt);
    let traffic = planned::traffic(&place, steps, 20);
    report(&place, usual, &traffic);
    let mut group = criterion.benchmark_group("planner");
    group.sample_size(20);
    let mut planner = Planner::new(usual, &place.guide, &place.road, place.dt);
    let candidates = planner.plan(&place.start, 0, &traffic).candidates;
    group.bench_function("polynomials", |b| {
        b.iter(|| polynomials(black_box(candidates), steps, place.dt));
    });
    group.bench_function("cycle", |b| {
        b.iter(|| planner.plan(black_box(&place.start), 0, &traffic));
    });
    // The same plan, without what the candidates that are not chosen would have cost.
    let mut best = Planner::new(usual, &place.guide, &place.road, place.dt).only_best();
    let (all, chosen) = (
        planner.plan(&place.start, 0, &traffic),
        best.plan(&place.start, 0, &traffic),
    );
    assert_eq!((all.states, all.cost), (chosen.states, chosen.cost));
    group.bench_function("cycle/only best", |b| {
        b.iter(|| best.plan(black_box(&place.start), 0, &traffic));
    });
    group.finish();
}

/// A drive in dense traffic, with its forecasts made anew and shared with earlier drives.
fn drives(criterion: &mut Criterion) {
    let all = bundled();
    let dense = all
        .iter()
        .filter_map(|entry| entry.read().ok())
        .filter(|scenario| !scenario.planning_problems.is_empty())
        .max_by_key(|scenario| scenario.obstacles.len());
    let scenario = dense.expect("a bundled scenario");
    let settings = Drive {
        planner: Settings::default(),
        forecast: Forecast::Lane,
        replan: 1,
        without: None,
        traffic: TrafficMode::Recorded,
        policy: None,
    };
    let problem = &scenario.planning_problems[0];
    let anew = Driver::new(&scenario, problem, &settings).expect("a driver");
    let shared = anew.clone().sharing_forecasts(&scenario);
    let mut group = criterion.benchmark_group("drive");
    group.sample_size(10);
    for (name, driver) in [("forecasts anew", &anew), ("forecasts shared", &shared)] {
        group.bench_function(name, |b| {
            b.iter(|| black_box(driver.drive(&scenario, &driver.full_span())));
        });
    }
    group.finish();
}

criterion_group!(benches, planner, drives);
criterion_main!(benches);
