//! A verdict as JSON: the form that is printed, stored and exported.

use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{ObstacleRisk, Task, Verdict};

impl Serialize for Verdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("task", &self.task)?;
        map.serialize_entry(self.task.key(), &self.dangerous)?;
        map.serialize_entry("obstacles", &self.obstacles)?;
        map.serialize_entry("justification", &self.justification)?;
        map.end()
    }
}

#[derive(Deserialize)]
struct Form {
    task: Task,
    collision: Option<bool>,
    safety_critical: Option<bool>,
    obstacles: Vec<ObstacleRisk>,
    justification: String,
}

impl<'de> Deserialize<'de> for Verdict {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let form = Form::deserialize(deserializer)?;
        let dangerous = match form.task {
            Task::Collision => form.collision,
            Task::Safety => form.safety_critical,
            Task::Attacker | Task::Trajectory => {
                return Err(serde::de::Error::custom("the task has no yes or no"));
            }
        };
        Ok(Self {
            task: form.task,
            dangerous: dangerous.ok_or_else(|| serde::de::Error::missing_field(form.task.key()))?,
            obstacles: form.obstacles,
            justification: form.justification,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn there_and_back() {
        let verdict = Verdict {
            task: Task::Safety,
            dangerous: true,
            obstacles: vec![ObstacleRisk {
                id: 7,
                risk_score: 1,
                reason: "near".into(),
            }],
            justification: "because".into(),
        };
        let text = serde_json::to_string(&verdict).unwrap();
        assert!(
            text.starts_with(r#"{"task":"safety","safety_critical":true,"obstacles":[{"id":7,"#)
        );
        assert_eq!(serde_json::from_str::<Verdict>(&text).unwrap(), verdict);
    }
}
