//! What is in a scenario, in a few lines for people.

use std::collections::BTreeMap;
use std::ops::Range;

use super::{LONGEST_TRACK, Prediction, Scenario, Severity};

impl Scenario {
    /// What is in it: a word and what there is to say about it, a line each.
    #[must_use]
    pub fn summary(&self) -> Vec<(&'static str, String)> {
        let (network, header) = (&self.network, &self.header);
        let last = self.steps().end - 1;
        let mut lines = vec![
            (
                "format",
                format!(
                    "CommonRoad {}, {} s a step",
                    header.version, header.time_step_size
                ),
            ),
            (
                "road",
                format!(
                    "{} lanelets, {} signs, {} lights, {} intersections",
                    network.lanelets.len(),
                    network.signs.len(),
                    network.lights.len(),
                    network.intersections.len()
                ),
            ),
            ("obstacles", self.kinds()),
            (
                "duration",
                format!(
                    "{:.1} s ({last} steps)",
                    last as f64 * header.time_step_size
                ),
            ),
            (
                "planning",
                match self.planning_problems.len() {
                    0 => "no planning problem".into(),
                    1 => "1 planning problem".into(),
                    n => format!("{n} planning problems"),
                },
            ),
        ];
        if !self.tags.is_empty() {
            lines.push(("tags", self.tags.join(", ")));
        }
        for name in ["author", "affiliation", "source", "date"] {
            let said = header.attributes.get(name).filter(|s| !s.is_empty());
            lines.extend(said.map(|said| (name, said.clone())));
        }
        lines
    }

    /// The time steps at which anything is said about an obstacle; only step 0 where nothing is.
    #[must_use]
    pub fn steps(&self) -> Range<i64> {
        let tracks = self.obstacles.iter().map(|o| o.track().steps());
        let regions = self.obstacles.iter().flat_map(|o| match &o.prediction {
            Prediction::Occupancies(regions) => regions.as_slice(),
            _ => &[],
        });
        let all = tracks
            .filter(|steps| !steps.is_empty())
            .chain(regions.map(|r| r.time.from..r.time.to + 1))
            .reduce(|a, b| a.start.min(b.start)..a.end.max(b.end))
            .unwrap_or(0..1);
        all.start..all.end.min(all.start + LONGEST_TRACK + 1)
    }

    /// How many diagnostics are warnings, and how many are notes.
    #[must_use]
    pub fn warnings_and_notes(&self) -> (usize, usize) {
        let warns = |d: &&super::Diagnostic| d.severity == Severity::Warning;
        let warnings = self.diagnostics.iter().filter(warns).count();
        (warnings, self.diagnostics.len() - warnings)
    }

    fn kinds(&self) -> String {
        let mut kinds = BTreeMap::<String, usize>::new();
        for obstacle in &self.obstacles {
            let kind = format!("{} {}", obstacle.role, obstacle.kind);
            *kinds.entry(kind).or_default() += 1;
        }
        if kinds.is_empty() {
            return "none".into();
        }
        let kinds: Vec<String> = kinds
            .iter()
            .map(|(kind, count)| format!("{count} {kind}"))
            .collect();
        kinds.join(", ")
    }
}
