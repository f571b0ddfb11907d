//! What makes an answer doubtful by itself, and obstacles that its scene does not have.

use super::JudgeOutcome;
use super::answer::Answer;
use nearmiss_scene::judge;
use nearmiss_scene::scenario::Scenario;
use nearmiss_scene::verdict::{Parsed, Verdict};

impl Answer {
    /// Ids in the verdict that no obstacle of the scenario has, each once.
    #[must_use]
    pub fn unknown_obstacles(&self, scenario: &Scenario) -> Vec<i64> {
        let mut named: Vec<i64> = match &self.judged {
            JudgeOutcome::Verdict(Parsed { verdict, .. }) => {
                let critical = verdict.critical.iter().flatten().map(|o| o.id);
                critical
                    .chain(verdict.obstacles.iter().map(|o| o.id))
                    .collect()
            }
            JudgeOutcome::Other(reading) => reading.said.named(),
            JudgeOutcome::Missing(_) => Vec::new(),
        };
        named.retain(|id| scenario.obstacle(*id).is_none());
        named.sort_unstable();
        named.dedup();
        named
    }

    /// What makes it doubtful, in words: contradictions, and obstacles that it names twice or that the scene does not have.
    #[must_use]
    pub fn flags(&self, scenario: &Scenario) -> Vec<String> {
        let unknown = self.unknown_obstacles(scenario);
        match self.verdict() {
            Some(_) if self.model == judge::MODEL => Vec::new(),
            Some(verdict) => {
                let known = Verdict {
                    unknown,
                    ..verdict.clone()
                };
                known.flags()
            }
            None => unknown.into_iter().map(Verdict::names_unknown).collect(),
        }
    }

    /// Keeps with its verdict which obstacles the scene does not have.
    pub(super) fn note_unknown(&mut self, scenario: &Scenario) {
        let unknown = self.unknown_obstacles(scenario);
        if let JudgeOutcome::Verdict(parsed) = &mut self.judged {
            parsed.verdict.unknown = unknown;
        }
    }
}
