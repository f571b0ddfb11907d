//! Verdicts: a judge's statement about a scene as structured data, parsing it from an answer, and what makes it doubtful.

mod answer_schema;
mod critical;
mod decision;
mod lenient;
mod parse;
mod parsed_answer;
mod trajectory;
mod values;

pub use answer_schema::{CollisionAnswer, RecordingAnswer, SafetyAnswer, schema, schema_with_ids};
pub use critical::CriticalObstacle;
pub use lenient::{ReasonedAnswer, object_in, reasons_first};
pub use parse::{NoVerdict, ParseQuality, Parsed, Reading, parse, read};
pub use parsed_answer::ParsedAnswer;
pub use trajectory::{
    AttackerChoice, Manoeuvre, ManoeuvreKind, Moment, Motion, NewMotion, TrajectoryAnswer,
    Waypoint, WaypointAnswer,
};

use std::collections::HashSet;

use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use strum::{IntoStaticStr, VariantArray};

/// The task of a judge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Task {
    /// Does the ego collide in the recorded scene?
    Collision,
    /// Will the ego's body touch another body within a horizon?
    Safety,
    /// Is the whole recording safe or of high risk?
    Recording,
    /// Whose motion could be changed so that it endangers the ego?
    Attacker,
    /// How would that obstacle have to move?
    Trajectory,
}

nearmiss_record::named!(Task, "task");

impl Task {
    /// Those that are answered with yes or no.
    pub const VERDICTS: [Self; 3] = [Self::Collision, Self::Safety, Self::Recording];

    /// The highest risk score that makes a recording one of high risk: extreme. It is that of the paper, which takes
    /// obstacles of score 0 and 1 for dangerous.
    pub const HIGH_RISK: u8 = 1;

    /// The names of some tasks, for help and errors: `collision, safety or recording`.
    #[must_use]
    pub fn names(tasks: &[Self]) -> String {
        let names: Vec<&str> = tasks.iter().map(|task| task.name()).collect();
        match names.split_last() {
            Some((last, [])) => (*last).to_string(),
            Some((last, first)) => format!("{} or {last}", first.join(", ")),
            None => String::new(),
        }
    }

    /// Whether what is true about its question is the same whatever the window: it is about all recorded steps.
    #[must_use]
    pub fn is_about_all_steps(self) -> bool {
        matches!(self, Self::Collision | Self::Recording)
    }

    /// The key of an answer that holds the decision: yes or no, or which obstacle.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Collision => "collision",
            Self::Safety => "safety_critical",
            Self::Recording => "high_risk",
            Self::Attacker => "attacker",
            Self::Trajectory => "obstacle",
        }
    }
}

/// One obstacle in a verdict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ObstacleRisk {
    /// Its id in the scenario.
    pub id: i64,
    /// 0 (collision) to 5 (negligible).
    #[schemars(range(min = 0, max = 5))]
    pub risk_score: u8,
    /// Why, in a sentence.
    #[serde(default)]
    pub reason: String,
    /// The score that the model wrote, where the group that it put the obstacle in says otherwise and counts. It is
    /// not asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(skip)]
    pub written_score: Option<u8>,
}

impl ObstacleRisk {
    /// The score as the model wrote it; the one of its group where it wrote none.
    #[must_use]
    pub fn stated_score(&self) -> u8 {
        self.written_score.unwrap_or(self.risk_score)
    }
}

/// A judge's verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// The task: one of [`Task::VERDICTS`].
    pub task: Task,
    /// Yes: a collision, safety-critical, or of high risk.
    pub dangerous: bool,
    /// The obstacles that matter, most dangerous first as far as the judge says.
    pub obstacles: Vec<ObstacleRisk>,
    /// Why, in a few sentences.
    pub justification: String,
    /// The critical obstacles, most critical first: in the safety task those expected to touch the ego within the
    /// horizon, in the collision task those that touch it, in the recording task those of extreme risk at some time. `None` where the answer has no such list, as the paper's.
    pub critical: Option<Vec<CriticalObstacle>>,
    /// The stated probability that the answer to the question is yes, 0 to 1.
    pub probability: Option<f64>,
    /// The probability of a yes by the log probabilities of the tokens with which the answer decides, 0 to 1. It is
    /// not in the answer's text; `None` where the server gave no log probabilities.
    pub token_probability: Option<f64>,
    /// Obstacles that it names and the scene does not have, as it was found when it arrived; empty where that was not looked for.
    pub unknown: Vec<i64>,
}

impl Verdict {
    /// The obstacle with the lowest risk score; the first one among equals.
    #[must_use]
    pub fn worst(&self) -> Option<&ObstacleRisk> {
        self.obstacles.iter().min_by_key(|o| o.risk_score)
    }

    /// The obstacle that matters most, and its risk score where it has one: the first critical one of a yes, else
    /// [`Self::worst`].
    #[must_use]
    pub fn foremost(&self) -> Option<(i64, Option<u8>)> {
        let critical = self.critical.as_ref().filter(|_| self.dangerous);
        let first = critical.and_then(|all| all.first()).map(|c| {
            let listed = self.obstacles.iter().find(|o| o.id == c.id);
            (c.id, listed.map(|o| o.risk_score))
        });
        first.or_else(|| self.worst().map(|o| (o.id, Some(o.risk_score))))
    }

    /// Yes or no in the words of the task.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match (self.task, self.dangerous) {
            (Task::Collision, true) => "collision",
            (Task::Collision, false) => "no collision",
            (Task::Recording, true) => "high risk",
            (Task::Recording, false) => "safe",
            (_, true) => "safety-critical",
            (_, false) => "not critical",
        }
    }
}

impl Serialize for Verdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("task", &self.task)?;
        map.serialize_entry(self.task.key(), &self.dangerous)?;
        map.serialize_entry("obstacles", &self.obstacles)?;
        // Answers that do not say these are written as they always were.
        if let Some(critical) = &self.critical {
            map.serialize_entry("critical_obstacles", critical)?;
        }
        if let Some(probability) = &self.probability {
            map.serialize_entry("probability", probability)?;
        }
        if let Some(probability) = &self.token_probability {
            map.serialize_entry("token_probability", probability)?;
        }
        if !self.unknown.is_empty() {
            map.serialize_entry("unknown_obstacles", &self.unknown)?;
        }
        map.serialize_entry("justification", &self.justification)?;
        map.end()
    }
}

#[derive(Deserialize)]
struct Form {
    task: Task,
    collision: Option<bool>,
    safety_critical: Option<bool>,
    high_risk: Option<bool>,
    obstacles: Vec<ObstacleRisk>,
    justification: String,
    critical_obstacles: Option<Vec<CriticalObstacle>>,
    probability: Option<f64>,
    token_probability: Option<f64>,
    #[serde(default)]
    unknown_obstacles: Vec<i64>,
}

impl<'de> Deserialize<'de> for Verdict {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let form = Form::deserialize(deserializer)?;
        let dangerous = match form.task {
            Task::Collision => form.collision,
            Task::Safety => form.safety_critical,
            Task::Recording => form.high_risk,
            Task::Attacker | Task::Trajectory => {
                return Err(serde::de::Error::custom("the task has no yes or no"));
            }
        };
        Ok(Self {
            task: form.task,
            dangerous: dangerous.ok_or_else(|| serde::de::Error::missing_field(form.task.key()))?,
            obstacles: form.obstacles,
            justification: form.justification,
            critical: form.critical_obstacles,
            probability: form.probability,
            token_probability: form.token_probability,
            unknown: form.unknown_obstacles,
        })
    }
}

/// From this probability on the answer is yes, as prompts say it.
const YES: f64 = 0.5;

impl Verdict {
    /// What contradicts its yes or no: its probability, or the obstacles that it calls critical.
    #[must_use]
    pub fn contradictions(&self) -> Vec<String> {
        let word = self.word();
        let mut found = Vec::new();
        if let Some(p) = self.probability.filter(|p| (*p >= YES) != self.dangerous) {
            found.push(format!("says {word} with a probability of {p:.2}"));
        }
        let critical = self.critical.as_deref();
        if self.dangerous && critical.is_some_and(<[_]>::is_empty) {
            found.push(format!("says {word} and calls no obstacle critical"));
        }
        let mut likely = critical
            .unwrap_or_default()
            .iter()
            .filter(|one| one.probability.is_none_or(|p| p >= YES));
        if let Some(one) = likely.next().filter(|_| !self.dangerous) {
            found.push(format!(
                "says {word} and calls obstacle {} critical",
                one.id
            ));
        }
        found
    }

    /// Obstacles that it grades twice, or calls critical twice.
    #[must_use]
    pub fn named_twice(&self) -> Vec<i64> {
        let graded: Vec<i64> = self.obstacles.iter().map(|one| one.id).collect();
        let critical: Vec<i64> = self.critical.iter().flatten().map(|one| one.id).collect();
        let mut twice: Vec<i64> = [graded, critical]
            .iter()
            .flat_map(|ids| again(ids))
            .collect();
        twice.sort_unstable();
        twice.dedup();
        twice
    }

    /// All of that, with the obstacles that the scene does not have, in words.
    #[must_use]
    pub fn flags(&self) -> Vec<String> {
        let mut flags = self.contradictions();
        flags.extend(
            self.named_twice()
                .iter()
                .map(|id| format!("names obstacle {id} twice")),
        );
        flags.extend(self.unknown.iter().copied().map(Self::names_unknown));
        flags
    }

    /// The words for an obstacle that the scene does not have.
    #[must_use]
    pub fn names_unknown(id: i64) -> String {
        format!("names obstacle {id}, which is not in the scene")
    }
}

/// Those that stand in a list already.
fn again(ids: &[i64]) -> Vec<i64> {
    let mut seen = HashSet::new();
    ids.iter().copied().filter(|id| !seen.insert(*id)).collect()
}

impl Verdict {
    /// The obstacles that it names as the danger: the critical ones of a yes. An answer without a list of critical
    /// obstacles, such as those recorded with the paper, names them by its risk scores.
    #[must_use]
    pub fn danger(&self) -> Vec<i64> {
        match &self.critical {
            Some(critical) if self.dangerous => critical.iter().map(|c| c.id).collect(),
            Some(_) => Vec::new(),
            None => self.danger_by_scores(),
        }
    }

    /// The paper's rule: those that collide or are of extreme risk, the scores 0 and 1. Where a yes gives no obstacle
    /// so low a score, as for a collision that is predicted for later, those with score 2.
    fn danger_by_scores(&self) -> Vec<i64> {
        let lowest = self.obstacles.iter().map(|o| o.risk_score).min();
        let most = match lowest {
            Some(PREDICTED) if self.dangerous => PREDICTED,
            _ => EXTREME,
        };
        let named = self.obstacles.iter().filter(|o| o.risk_score <= most);
        named.map(|o| o.id).collect()
    }
}

/// The risk scores of extreme risk, and the highest one of a collision that is only predicted.
const EXTREME: u8 = 1;

const PREDICTED: u8 = 2;

#[cfg(test)]
mod naming_tests {
    use super::{CriticalObstacle, ObstacleRisk, Task, Verdict};

    fn verdict(dangerous: bool, scores: &[(i64, u8)], critical: Option<&[i64]>) -> Verdict {
        let risk = |&(id, risk_score): &(i64, u8)| ObstacleRisk {
            id,
            risk_score,
            reason: String::new(),
            written_score: None,
        };
        let of = |ids: &[i64]| ids.iter().copied().map(CriticalObstacle::new).collect();
        Verdict {
            task: Task::Safety,
            dangerous,
            obstacles: scores.iter().map(risk).collect(),
            justification: String::new(),
            critical: critical.map(of),
            probability: None,
            token_probability: None,
            unknown: Vec::new(),
        }
    }

    #[test]
    fn a_yes_names_its_critical_obstacles_whatever_their_scores() {
        let scores = [(7, 4), (8, 1)];
        assert_eq!(verdict(true, &scores, Some(&[7])).danger(), [7]);
        assert_eq!(verdict(true, &scores, Some(&[])).danger(), [0; 0]);
        assert_eq!(verdict(false, &scores, Some(&[7])).danger(), [0; 0]);
        assert_eq!(
            verdict(true, &scores, Some(&[7, 9])).foremost(),
            Some((7, Some(4)))
        );
        assert_eq!(
            verdict(false, &scores, Some(&[7])).foremost(),
            Some((8, Some(1)))
        );
    }

    #[test]
    fn without_a_list_the_risk_scores_name() {
        assert_eq!(verdict(true, &[(7, 2), (8, 1)], None).danger(), [8]);
        assert_eq!(verdict(true, &[(7, 2), (8, 3)], None).danger(), [7]);
        assert_eq!(verdict(false, &[(7, 2), (8, 3)], None).danger(), [0; 0]);
        assert_eq!(verdict(false, &[(7, 1)], None).danger(), [7]);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::{CriticalObstacle, *};

    #[test]
    fn there_and_back_with_and_without_probabilities() {
        let mut verdict = Verdict {
            task: Task::Safety,
            dangerous: true,
            obstacles: vec![ObstacleRisk {
                id: 7,
                risk_score: 1,
                reason: "near".into(),
                written_score: None,
            }],
            justification: "because".into(),
            critical: None,
            probability: None,
            token_probability: None,
            unknown: Vec::new(),
        };
        let text = serde_json::to_string(&verdict).unwrap();
        assert!(
            text.starts_with(r#"{"task":"safety","safety_critical":true,"obstacles":[{"id":7,"#)
        );
        assert!(!text.contains("probability"), "{text}");
        assert_eq!(serde_json::from_str::<Verdict>(&text).unwrap(), verdict);
        verdict.task = Task::Recording;
        let text = serde_json::to_string(&verdict).unwrap();
        assert!(text.starts_with(r#"{"task":"recording","high_risk":true,"#));
        assert_eq!(serde_json::from_str::<Verdict>(&text).unwrap(), verdict);
        verdict.task = Task::Safety;
        verdict.critical = Some(vec![CriticalObstacle::new(7)]);
        verdict.probability = Some(0.9);
        verdict.token_probability = Some(0.97);
        verdict.obstacles[0].written_score = Some(3);
        let text = serde_json::to_string(&verdict).unwrap();
        assert_eq!(serde_json::from_str::<Verdict>(&text).unwrap(), verdict);
    }

    fn verdict(
        dangerous: bool,
        probability: Option<f64>,
        critical: Option<&[(i64, f64)]>,
    ) -> Verdict {
        let one = |(id, p): &(i64, f64)| CriticalObstacle {
            id: *id,
            probability: Some(*p),
        };
        Verdict {
            task: Task::Safety,
            dangerous,
            obstacles: Vec::new(),
            justification: String::new(),
            critical: critical.map(|all| all.iter().map(one).collect()),
            probability,
            token_probability: None,
            unknown: Vec::new(),
        }
    }

    #[test]
    fn yes_no_probability_and_critical_obstacles_are_held_against_each_other() {
        for sound in [
            verdict(true, Some(0.5), Some(&[(7, 0.4)])),
            verdict(false, Some(0.49), Some(&[(7, 0.3)])),
            verdict(true, None, None),
            verdict(false, None, Some(&[])),
        ] {
            assert_eq!(sound.flags(), [""; 0], "{sound:?}");
        }
        let says = |verdict: Verdict| verdict.flags().join("; ");
        assert_eq!(
            says(verdict(true, Some(0.01), Some(&[]))),
            "says safety-critical with a probability of 0.01; says safety-critical and calls no obstacle critical"
        );
        assert_eq!(
            says(verdict(false, Some(0.1), Some(&[(7, 0.2), (9, 0.9)]))),
            "says not critical and calls obstacle 9 critical"
        );
        let mut named = verdict(true, None, Some(&[(7, 0.9), (7, 0.8)]));
        let graded = |id| ObstacleRisk {
            id,
            risk_score: 2,
            reason: String::new(),
            written_score: None,
        };
        named.obstacles = vec![graded(9), graded(9), graded(9), graded(7)];
        named.unknown = vec![429];
        assert_eq!(
            says(named),
            "names obstacle 7 twice; names obstacle 9 twice; names obstacle 429, which is not in the scene"
        );
    }
}
