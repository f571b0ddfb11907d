//! Benchmarks road queries (lanelet lookup, routes, reach) against a brute-force scan of the same map.
//!
//! The figures to read are ratios: the tree over the scan of all lanelets, projection through the tree over
//! the scan of all segments, the drivable area over building it. The map is a grid of streets made here.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use nearmiss::geometry::{Footprint, Point, Polyline, Pose, ReferencePath, Shape, contains};
use nearmiss::scenario::{Bound, Lanelet, LaneletNetwork, LineMarking};

/// Lanelets along one side of the grid.
const BLOCKS: i64 = 22;

/// A grid of gently waving streets, two lanes each: 968 lanelets with 20 points a border.
fn network() -> LaneletNetwork {
    let mut lanelets = Vec::new();
    for row in 0..BLOCKS {
        for column in 0..BLOCKS {
            for lane in 0..2 {
                let id = (row * BLOCKS + column) * 2 + lane;
                let border = |offset: f64| {
                    let point = |i: i32| {
                        let x = 50.0 * column as f64 + 50.0 * f64::from(i) / 19.0;
                        Point::new(x, 40.0 * row as f64 + 3.0 * (x / 30.0).sin() + offset)
                    };
                    Bound {
                        points: (0..20).map(point).collect(),
                        heights: Vec::new(),
                        marking: LineMarking::Unknown,
                    }
                };
                let right = 3.5 * lane as f64;
                let neighbour = |step: i64, edge: i64| {
                    let known = column != edge;
                    known.then_some(id + 2 * step).into_iter().collect()
                };
                lanelets.push(Lanelet {
                    id,
                    left: border(right + 3.5),
                    right: border(right),
                    predecessors: neighbour(-1, 0),
                    successors: neighbour(1, BLOCKS - 1),
                    adjacent_left: None,
                    adjacent_right: None,
                    stop_line: None,
                    types: Vec::new(),
                    users_one_way: Vec::new(),
                    users_bidirectional: Vec::new(),
                    signs: Vec::new(),
                    lights: Vec::new(),
                });
            }
        }
    }
    LaneletNetwork::new(lanelets, vec![], vec![], vec![])
}

/// Points spread over the map.
fn places(count: i32) -> Vec<Point> {
    let share = |i: i32, base: f64| (f64::from(i) * base).fract();
    (0..count)
        .map(|i| {
            Point::new(
                1100.0 * share(i, 0.754_877_666),
                880.0 * share(i, 0.569_840_291),
            )
        })
        .collect()
}

fn scan(network: &LaneletNetwork, p: &Point) -> usize {
    let places = network.lanelets.iter().enumerate();
    places
        .filter(|(i, l)| network.bounds_of(*i).contains(p) && contains(&l.ring(), p))
        .count()
}

fn lanelets(criterion: &mut Criterion) {
    let (network, points) = (network(), places(1000));
    let mut group = criterion.benchmark_group("lanelets at 1000 points");
    group.bench_function("scan", |b| {
        b.iter(|| {
            points
                .iter()
                .map(|p| scan(&network, black_box(p)))
                .sum::<usize>()
        })
    });
    group.bench_function("tree", |b| {
        b.iter(|| {
            points
                .iter()
                .map(|p| network.lanelets_at(black_box(p)).len())
                .sum::<usize>()
        })
    });
    group.bench_function("building the tree", |b| {
        let fresh = || LaneletNetwork::new(network.lanelets.clone(), vec![], vec![], vec![]);
        b.iter_batched(
            fresh,
            |n| n.lanelets_at(black_box(&points[0])).len(),
            criterion::BatchSize::LargeInput,
        )
    });
    group.finish();
}

fn projection(criterion: &mut Criterion) {
    let curve = |i: i32| Point::new(f64::from(i), 40.0 * (f64::from(i) / 60.0).sin());
    let line = Polyline::new((0..1500).map(curve)).expect("points");
    let path = ReferencePath::new(line.points().iter().copied()).expect("a path");
    let points: Vec<Point> = (0..1000)
        .map(|i| {
            let s = f64::from(i) * path.length() / 1000.0;
            let at = path.pose_at(s);
            at.to_world(&Point::new(0.0, f64::from(i % 7) - 3.0))
        })
        .collect();
    let mut group = criterion.benchmark_group("projection of 1000 points");
    group.bench_function("scan of the polyline", |b| {
        b.iter(|| {
            points
                .iter()
                .map(|p| line.project(black_box(p)).s)
                .sum::<f64>()
        })
    });
    group.bench_function("whole path", |b| {
        let s = |p| path.project(black_box(p)).map_or(0.0, |at| at.s);
        b.iter(|| points.iter().map(s).sum::<f64>())
    });
    group.bench_function("near a hint", |b| {
        b.iter(|| {
            let mut s = 0.0;
            for p in &points {
                s = path.project_near(black_box(p), s, 5.0).map_or(s, |at| at.s);
            }
            s
        })
    });
    group.bench_function("back to the plane", |b| {
        b.iter(|| {
            (0..1000)
                .map(|i| path.at(black_box(f64::from(i))).curvature)
                .sum::<f64>()
        })
    });
    group.bench_function("building the path", |b| {
        b.iter(|| ReferencePath::new(line.points().iter().copied()).map(|p| p.length()))
    });
    group.finish();
}

fn drivable(criterion: &mut Criterion) {
    let network = network();
    let road = network.drivable_area(None);
    let car = Footprint::new(Shape::rectangle(4.5, 1.8)).expect("a shape");
    let poses: Vec<Pose> = places(1000)
        .iter()
        .map(|p| {
            // Most candidates of a planner are on the road, some touch its border.
            let row = (p.y / 40.0).floor() * 40.0;
            Pose::new(
                p.x,
                row + 3.0 * (p.x / 30.0).sin() + p.y % 7.0,
                0.1 * (p.x / 30.0).cos(),
            )
        })
        .collect();
    let mut group = criterion.benchmark_group("1000 boxes on the road");
    group.bench_function("lanelets under their middles, by scan", |b| {
        b.iter(|| {
            poses
                .iter()
                .map(|p| scan(&network, &p.position))
                .sum::<usize>()
        })
    });
    group.bench_function("drivable area", |b| {
        b.iter(|| {
            poses
                .iter()
                .filter(|p| road.covers(&car.at(black_box(**p))))
                .count()
        })
    });
    group.bench_function("building the area", |b| {
        b.iter(|| network.drivable_area(None))
    });
    group.bench_function("building the lane graph", |b| {
        b.iter(|| network.lane_graph(None))
    });
    group.finish();
}

criterion_group!(benches, lanelets, projection, drivable);
criterion_main!(benches);
