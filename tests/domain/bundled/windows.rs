//! Tests of windows, coverage and samples.

use nearmiss::corpus::{
    Candidate, Cell, Coverage, IndexOptions, IndexedWindow, Manoeuvre, Sampler, WindowEgo,
    WorstMoment, for_each_window, worst_moments,
};
use nearmiss::formats::bundled;
use nearmiss::metrics::{MEASURES, Thresholds};

fn windows(name: &str) -> Vec<IndexedWindow> {
    let entry = bundled()
        .into_iter()
        .find(|e| e.name.contains(name))
        .unwrap();
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap();
    let options = IndexOptions {
        length: 2.0,
        stride: 1.0,
        radius: 50.0,
        measures: MEASURES.iter().filter(|m| m.id == "distance").collect(),
    };
    let mut found = Vec::new();
    let mut take = |window| found.push(window);
    for_each_window(&scenario, ego, &options, Thresholds::shipped(), &mut take);
    found
}

fn recorded(name: &str) -> Vec<Manoeuvre> {
    let windows = windows(name);
    let of_ego = windows.iter().filter(|w| w.ego == WindowEgo::Recorded);
    of_ego.map(|w| w.manoeuvre).collect()
}

#[test]
fn bundled_scenarios_have_the_manoeuvres_that_they_are_named_after() {
    for (name, manoeuvre) in [
        ("CutIn", Manoeuvre::CutIn),
        ("HardBraking", Manoeuvre::Following),
        ("Pedestrian", Manoeuvre::Crossing),
        ("RedLight", Manoeuvre::Crossing),
        ("Overtaking", Manoeuvre::Oncoming),
    ] {
        let found = recorded(name);
        assert!(found.contains(&manoeuvre), "{name}: {found:?}");
    }
}

#[test]
fn windows_are_of_both_directions_of_a_pair_and_within_the_recording() {
    let all = windows("Merge");
    let recorded = all.iter().any(|w| w.ego == WindowEgo::Recorded);
    let others = all.iter().any(|w| matches!(w.ego, WindowEgo::Obstacle(_)));
    assert!(recorded && others);
    for window in &all {
        assert!(window.steps.0 <= window.steps.1);
        assert!((window.steps.0..=window.steps.1).contains(&window.worst_step));
        assert!(window.severity <= 5);
        let distance = window.values[0].unwrap();
        assert_eq!(distance == 0.0, window.severity == 0, "{window:?}");
    }
}

fn candidate(cell: &str, scenario: u32, window: u32) -> Candidate {
    Candidate {
        path: format!("{scenario}.xml"),
        window: format!("{scenario} {window}"),
        cell: vec![cell.to_string()],
    }
}

#[test]
fn a_sample_covers_every_cell_whatever_the_order() {
    let mut all = Vec::new();
    for scenario in 0..40 {
        all.push(candidate("common", scenario, 1));
        all.push(candidate("common", scenario, 2));
    }
    all.push(candidate("rare", 3, 3));
    let draw = |order: &[Candidate], seed| {
        let mut sampler = Sampler::new(seed, 6);
        order.iter().for_each(|c| sampler.offer(c.clone(), ()));
        sampler.draw()
    };
    let drawn = draw(&all, 7);
    assert_eq!(drawn.len(), 6);
    let rare: Vec<_> = drawn
        .iter()
        .filter(|d| d.candidate.cell[0] == "rare")
        .collect();
    assert_eq!((rare.len(), rare[0].windows, rare[0].drawn), (1, 1, 1));
    let mut paths: Vec<_> = drawn.iter().map(|d| d.candidate.path.clone()).collect();
    paths.sort();
    paths.dedup();
    assert_eq!(paths.len(), 6, "each scenario once");
    all.reverse();
    assert_eq!(draw(&all, 7), drawn);
    assert_ne!(draw(&all, 8), drawn);
}

#[test]
fn coverage_counts() {
    let mut coverage = Coverage::default();
    let cell = Cell {
        manoeuvre: "cut_in".into(),
        road: "highway".into(),
    };
    coverage.add(cell.clone(), 0);
    coverage.add(cell.clone(), 9);
    assert_eq!(coverage.rows().next(), Some((&cell, &[1, 0, 0, 0, 0, 1])));
    assert_eq!(coverage.totals(), [1, 0, 0, 0, 0, 1]);
    assert_eq!(coverage.largest(), 1);
}

#[test]
fn worst_moments_are_those_of_the_index() {
    for name in ["CutIn", "HardBraking", "Overtaking", "Merge", "JamTail"] {
        let entry = bundled().into_iter().find(|e| e.name.contains(name));
        let scenario = entry.unwrap().read().unwrap();
        let moments = worst_moments(
            &scenario,
            &scenario.possible_egos(),
            50.0,
            Thresholds::shipped(),
        );
        assert!(!moments.is_empty(), "{name}");
        let severity = |m: &WorstMoment| m.moment.grade.number();
        assert!(moments.is_sorted_by_key(severity), "{name}: {moments:?}");
        let windows = windows(name);
        let worst = |ego: i64| {
            let of_ego = windows.iter().filter(|w| w.ego == WindowEgo::Obstacle(ego));
            of_ego.map(|w| w.severity).min()
        };
        for one in &moments {
            assert_eq!(Some(severity(one)), worst(one.ego), "{name}: {one:?}");
            let here = windows.iter().find(|w| {
                w.ego == WindowEgo::Obstacle(one.ego)
                    && w.obstacle == one.moment.obstacle
                    && w.severity == severity(one)
                    && w.worst_step == one.moment.step
            });
            assert!(here.is_some(), "{name}: {one:?} is in no window");
            // Each pair once.
            let twin =
                |m: &&WorstMoment| (m.ego, m.moment.obstacle) == (one.moment.obstacle, one.ego);
            let apart = |t: &WorstMoment| (t.moment.step - one.moment.step).abs() >= 100;
            assert!(moments.iter().find(twin).is_none_or(apart));
        }
        // What is left out is not worse.
        let least = windows.iter().filter(|w| w.ego != WindowEgo::Recorded);
        assert_eq!(
            Some(severity(&moments[0])),
            least.map(|w| w.severity).min(),
            "{name}"
        );
    }
}
