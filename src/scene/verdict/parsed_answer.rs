//! A parsed answer of any task, and the repairs made while parsing it.

use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;

use super::lenient::{End, JsonPiece};
use super::{
    AttackerChoice, NewMotion, ObstacleRisk, ParseQuality, Task, TrajectoryAnswer, Verdict,
};

/// A parsed answer, by the kind of its task.
#[derive(Debug, Clone, PartialEq)]
pub enum ParsedAnswer {
    /// Yes or no, to the collision, the safety or the recording task.
    Verdict(Verdict),
    /// The obstacles that could attack the ego.
    Attacker(AttackerChoice),
    /// How an attacker is to move.
    Trajectory(NewMotion),
}

impl ParsedAnswer {
    /// The task that it answers.
    #[must_use]
    pub fn task(&self) -> Task {
        match self {
            Self::Verdict(verdict) => verdict.task,
            Self::Attacker(_) => Task::Attacker,
            Self::Trajectory(_) => Task::Trajectory,
        }
    }

    /// The verdict, if it is one.
    #[must_use]
    pub fn verdict(&self) -> Option<&Verdict> {
        match self {
            Self::Verdict(verdict) => Some(verdict),
            Self::Attacker(_) | Self::Trajectory(_) => None,
        }
    }

    /// Why, in a few sentences.
    #[must_use]
    pub fn justification(&self) -> &str {
        match self {
            Self::Verdict(verdict) => &verdict.justification,
            Self::Attacker(choice) => &choice.justification,
            Self::Trajectory(new) => &new.justification,
        }
    }

    /// Every text in it that the model wrote.
    pub fn texts_mut(&mut self) -> impl Iterator<Item = &mut String> {
        let (justification, obstacles) = match self {
            Self::Verdict(verdict) => (&mut verdict.justification, &mut verdict.obstacles[..]),
            Self::Attacker(choice) => (&mut choice.justification, &mut choice.obstacles[..]),
            Self::Trajectory(new) => (&mut new.justification, &mut [][..]),
        };
        texts_mut(justification, obstacles)
    }

    /// Ids of the obstacles that it names.
    #[must_use]
    pub fn named(&self) -> Vec<i64> {
        match self {
            Self::Verdict(verdict) => {
                let critical = verdict.critical.iter().flatten().map(|c| c.id);
                once(verdict.obstacles.iter().map(|o| o.id).chain(critical))
            }
            Self::Attacker(choice) => {
                let listed = choice.obstacles.iter().map(|o| o.id);
                once(choice.attacker.into_iter().chain(listed))
            }
            Self::Trajectory(new) => vec![new.obstacle],
        }
    }
}

impl Verdict {
    /// Every text in it that the model wrote.
    pub fn texts_mut(&mut self) -> impl Iterator<Item = &mut String> {
        texts_mut(&mut self.justification, &mut self.obstacles)
    }
}

/// Each id once, in order.
fn once(ids: impl Iterator<Item = i64>) -> Vec<i64> {
    let mut seen = std::collections::HashSet::new();
    ids.filter(|id| seen.insert(*id)).collect()
}

fn texts_mut<'a>(
    justification: &'a mut String,
    obstacles: &'a mut [ObstacleRisk],
) -> impl Iterator<Item = &'a mut String> {
    let reasons = obstacles.iter_mut().map(|o| &mut o.reason);
    std::iter::once(justification).chain(reasons)
}

impl From<Verdict> for ParsedAnswer {
    fn from(verdict: Verdict) -> Self {
        Self::Verdict(verdict)
    }
}

/// The task, then the answer as it was asked for.
impl Serialize for ParsedAnswer {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let value = match self {
            Self::Verdict(verdict) => return verdict.serialize(serializer),
            Self::Attacker(choice) => serde_json::to_value(choice),
            Self::Trajectory(new) => serde_json::to_value(TrajectoryAnswer::from(new.clone())),
        };
        let form = value.map_err(serde::ser::Error::custom)?;
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("task", &self.task())?;
        for (key, value) in form.as_object().into_iter().flatten() {
            map.serialize_entry(key, value)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for ParsedAnswer {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        use serde::de::Error;
        let mut form = serde_json::Map::<String, Value>::deserialize(deserializer)?;
        let task = form
            .get("task")
            .ok_or_else(|| Error::missing_field("task"))?;
        let task: Task = serde_json::from_value(task.clone()).map_err(Error::custom)?;
        if matches!(task, Task::Attacker | Task::Trajectory) {
            form.shift_remove("task");
        }
        let form = Value::Object(form);
        match task {
            Task::Collision | Task::Safety | Task::Recording => serde_json::from_value(form)
                .map(Self::Verdict)
                .map_err(Error::custom),
            Task::Attacker => serde_json::from_value(form)
                .map(Self::Attacker)
                .map_err(Error::custom),
            Task::Trajectory => {
                let answer: TrajectoryAnswer =
                    serde_json::from_value(form).map_err(Error::custom)?;
                NewMotion::try_from(answer)
                    .map(Self::Trajectory)
                    .map_err(Error::custom)
            }
        }
    }
}

/// Notes, each once; a hostile answer does not make them endless.
#[derive(Debug, Default)]
pub(super) struct Notes {
    notes: Vec<String>,
    more: usize,
}

const MAX_LISTED: usize = 20;
const MAX_CHARACTERS: usize = 160;

impl Notes {
    pub(super) fn add(&mut self, note: impl Into<String>) {
        // The store keeps them in one line, apart by semicolons.
        let mut note = note.into().replace(';', ",").replace(['\n', '\r'], " ");
        if let Some((end, _)) = note.char_indices().nth(MAX_CHARACTERS) {
            note.truncate(end);
            note.push('…');
        }
        if self.notes.contains(&note) {
        } else if self.notes.len() < MAX_LISTED {
            self.notes.push(note);
        } else {
            self.more += 1;
        }
    }

    /// How the text of a piece departed from JSON.
    pub(super) fn note_repairs(&mut self, piece: &JsonPiece) {
        for repair in &piece.repairs {
            self.add(repair.to_string());
        }
        match piece.end {
            End::Whole => {}
            End::CutOff => {
                self.add("the answer breaks off inside its JSON; the part before was read")
            }
            End::Broken => self.add("the JSON is broken; the part before was read"),
        }
    }

    pub(super) fn how(mut self) -> ParseQuality {
        if self.more > 0 {
            self.notes.push(format!("and {} more", self.more));
        }
        if self.notes.is_empty() {
            ParseQuality::Strict
        } else {
            ParseQuality::Repaired(self.notes)
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::verdict::{Manoeuvre, ManoeuvreKind, Moment, Motion, Waypoint};

    #[test]
    fn there_and_back() {
        let near = ObstacleRisk {
            id: 7,
            risk_score: 1,
            reason: "near".into(),
            written_score: None,
        };
        let point = |at, x| Waypoint {
            at,
            x,
            y: 2.5,
            heading: None,
            velocity: Some(3.0),
        };
        let said = [
            ParsedAnswer::Verdict(Verdict {
                task: Task::Safety,
                dangerous: true,
                obstacles: vec![near.clone()],
                justification: "because".into(),
                critical: None,
                probability: None,
                token_probability: None,
                unknown: Vec::new(),
            }),
            ParsedAnswer::Attacker(AttackerChoice {
                attacker: Some(7),
                obstacles: vec![near],
                justification: "because".into(),
            }),
            ParsedAnswer::Trajectory(NewMotion {
                obstacle: 7,
                motion: Motion::Waypoints(vec![
                    point(Moment::Step(1), 1.0),
                    point(Moment::Step(2), 1.5),
                ]),
                justification: "because".into(),
            }),
            ParsedAnswer::Trajectory(NewMotion {
                obstacle: 7,
                motion: Motion::Manoeuvre(Manoeuvre {
                    kind: ManoeuvreKind::CutIn,
                    start: 1.0,
                    duration: 2.0,
                    gap: Some(4.0),
                    speed: None,
                }),
                justification: "because".into(),
            }),
        ];
        for said in said {
            let text = serde_json::to_string(&said).unwrap();
            assert!(
                text.starts_with(&format!(r#"{{"task":"{}""#, said.task().name())),
                "{text}"
            );
            assert_eq!(serde_json::from_str::<ParsedAnswer>(&text).unwrap(), said);
            assert_eq!((said.named(), said.justification()), (vec![7], "because"));
            let mut said = said;
            said.texts_mut().for_each(|text| *text = "x".into());
            let text = serde_json::to_string(&said).unwrap();
            assert!(
                !text.contains("because") && !text.contains("near"),
                "{text}"
            );
        }
    }
}
