//! A verdict as JSON: the form that is printed, stored and exported.

use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{CriticalObstacle, ObstacleRisk, Task, Verdict};

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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

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
}
