//! The lowest risk score of a recording decides about it.

use nearmiss::judge::{judge_collision, judge_recording};
use nearmiss::metrics::{Context, MEASURES, Series, Thresholds};
use nearmiss::scenario::Scene;

/// The scores of a series, which is another way to the same numbers.
fn lowest(scene: &Scene) -> Option<(u8, i64)> {
    let context = Context::new(scene);
    let risk = MEASURES.iter().filter(|m| m.id == "risk").collect();
    let series = Series::from_context(&context, risk);
    let mut found: Vec<(u8, i64)> = Vec::new();
    for &id in series.obstacles() {
        let row = series.row("risk", id);
        let values = row.iter().filter_map(|r| r.value());
        found.extend(
            values
                .map(|score| score as u8)
                .min()
                .map(|score| (score, id)),
        );
    }
    found.into_iter().min()
}

#[test]
fn the_lowest_score_of_the_recording_decides() {
    let mut decisions = [0, 0];
    for entry in nearmiss::formats::bundled() {
        let scenario = entry.read().unwrap();
        let Some(ego) = entry.recorded_ego(&scenario).unwrap() else {
            continue;
        };
        let scene = Scene::new(scenario, ego);
        let judgement = judge_recording(&scene, Thresholds::shipped());
        let verdict = judgement.verdict;
        let (score, _) = lowest(&scene).unwrap_or((5, 0));
        assert_eq!(verdict.dangerous, score <= 1, "{}", entry.name);
        decisions[usize::from(verdict.dangerous)] += 1;
        if let Some(worst) = verdict.worst() {
            assert_eq!(worst.risk_score, score, "{}", entry.name);
        }
        let critical = verdict.danger();
        let grave = verdict.obstacles.iter().filter(|o| o.risk_score <= 1);
        assert_eq!(critical.len(), grave.count(), "{}", entry.name);
        assert_eq!(judgement.decisive_step.is_some(), verdict.dangerous);
        // A collision is of the highest risk.
        let collides = judge_collision(&scene, Thresholds::shipped());
        assert!(verdict.dangerous || !collides.verdict.dangerous);
    }
    assert!(decisions.iter().all(|count| *count > 0), "{decisions:?}");
}
