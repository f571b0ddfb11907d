//! Example answers on two bundled scenarios, written for this program and by no model: for a tour without a network.

use nearmiss_ask::prompts::Techniques;
use nearmiss_formats::{EgoSelection, bundled};
use nearmiss_scene::scenario::Scene;
use nearmiss_scene::verdict::Task;
use nearmiss_store::Run;
use nearmiss_study::paper::{Recorded, run_of};

/// A scenario, who "answers", whether the scenario is a collision, and the answer.
const EXAMPLES: [(&str, &str, bool, &str); 4] = [
    (
        "ZAM_HardBraking-1_1_T-1",
        "example/example-a",
        true,
        include_str!("../../scenarios/examples/hard-braking-a.md"),
    ),
    (
        "ZAM_HardBraking-1_1_T-1",
        "example/example-b",
        true,
        include_str!("../../scenarios/examples/hard-braking-b.md"),
    ),
    (
        "ZAM_Merge-1_1_T-1",
        "example/example-a",
        false,
        include_str!("../../scenarios/examples/merge-a.md"),
    ),
    (
        "ZAM_Merge-1_1_T-1",
        "example/example-b",
        false,
        include_str!("../../scenarios/examples/merge-b.md"),
    ),
];

/// The examples as runs that were imported at `now_ms`.
#[must_use]
pub fn example_runs(now_ms: i64) -> Vec<Run> {
    let entries = bundled();
    let run = |(scenario, model, collision, text): &(&str, &str, bool, &str)| {
        let entry = entries.iter().find(|entry| entry.name == *scenario)?;
        let read = entry.read().ok()?;
        let ego = EgoSelection::Beside.resolve(entry, &read).ok()??;
        let hash = read.hash.to_string();
        let answer = Recorded {
            scenario: (*scenario).to_string(),
            collision: *collision,
            task: Task::Collision,
            frame: "ego",
            techniques: Techniques::ALL,
            model: (*model).to_string(),
            text: (*text).to_string(),
            file: "an example of nearmiss".into(),
            context: None,
        };
        Some(run_of(&answer, &hash, &Scene::new(read, ego), now_ms))
    };
    EXAMPLES.iter().filter_map(run).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_has_a_wrong_claim_and_one_a_wrong_risk_score() {
        let runs = example_runs(1);
        assert_eq!(runs.len(), EXAMPLES.len());
        let wrong = |run: &&Run| run.ending.claims.claims_wrong.is_some_and(|n| n > 0);
        // The risk score is a claim as well.
        assert_eq!(runs.iter().filter(wrong).count(), 2);
        let says = |run: &Run| {
            let verdict = run.ending.verdict.as_ref().and_then(|said| said.verdict());
            verdict.map(|v| (v.dangerous, v.worst().map(|o| (o.id, o.risk_score))))
        };
        let said: Vec<_> = runs.iter().map(says).collect();
        let expected = [
            Some((true, Some((301, 0)))),
            Some((false, Some((301, 2)))),
            Some((false, Some((301, 3)))),
            Some((false, Some((301, 1)))),
        ];
        assert_eq!(said, expected);
    }
}
