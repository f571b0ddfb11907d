//! Reading a verdict from what a model wrote: JSON somewhere in text, with the keys models choose.

use serde_json::{Map, Value};

use super::{ObstacleRisk, Task, Verdict};

/// How a verdict was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum How {
    /// It is as it was asked for.
    Strict,
    /// These things were put right.
    Repaired(Vec<String>),
}

/// A verdict and how it was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Parsed {
    /// What the answer says.
    pub verdict: Verdict,
    /// How it was read.
    pub how: How,
}

/// Why an answer holds no verdict.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NoVerdict {
    /// There is no text.
    #[error("the answer is empty")]
    Empty,
    /// There is no JSON object in it.
    #[error("no JSON object in the answer")]
    NoJson,
    /// A JSON object begins and never ends.
    #[error("the answer breaks off inside its JSON")]
    CutOff,
    /// There is JSON, but nothing in it says yes or no.
    #[error("the answer's JSON does not say `{0}`")]
    NoDecision(&'static str),
}

/// Reads the verdict on `task` from the text of an answer; the last object that says yes or no counts.
///
/// # Errors
/// See [`NoVerdict`].
pub fn parse(task: Task, answer: &str) -> Result<Parsed, NoVerdict> {
    if answer.trim().is_empty() {
        return Err(NoVerdict::Empty);
    }
    let (objects, open) = objects(answer);
    let read = objects
        .iter()
        .rev()
        .find_map(|object| interpret(task, object));
    match read {
        Some(parsed) => Ok(parsed),
        None if open => Err(NoVerdict::CutOff),
        None if objects.is_empty() => Err(NoVerdict::NoJson),
        None => Err(NoVerdict::NoDecision(task.key())),
    }
}

/// The outermost JSON objects in a text, and whether one is still open at its end.
fn objects(text: &str) -> (Vec<Map<String, Value>>, bool) {
    let mut found = Vec::new();
    let mut rest = text;
    let mut open = false;
    while let Some(start) = rest.find('{') {
        let mut stream = serde_json::Deserializer::from_str(&rest[start..]).into_iter::<Value>();
        match stream.next() {
            Some(Ok(Value::Object(map))) => {
                rest = &rest[start + stream.byte_offset()..];
                found.push(map);
                open = false;
            }
            Some(Err(error)) if error.is_eof() => {
                open = true;
                rest = &rest[start + 1..];
            }
            _ => rest = &rest[start + 1..],
        }
    }
    (found, open)
}

fn interpret(task: Task, object: &Map<String, Value>) -> Option<Parsed> {
    let strict: Option<Verdict> = match task {
        Task::Collision => strict::<super::CollisionAnswer>(object),
        Task::Safety => strict::<super::SafetyAnswer>(object),
    };
    if let Some(verdict) = strict {
        return Some(Parsed {
            verdict,
            how: How::Strict,
        });
    }
    let mut notes = Vec::new();
    let dangerous = decision(task, object, &mut notes)?;
    let obstacles = obstacles(object, &mut notes);
    let justification = find(object, "justification")
        .and_then(Value::as_str)
        .map(str::to_string)
        .unwrap_or_else(|| {
            notes.push("no justification".into());
            String::new()
        });
    Some(Parsed {
        verdict: Verdict {
            task,
            dangerous,
            obstacles,
            justification,
        },
        how: How::Repaired(notes),
    })
}

/// The verdict if the object is exactly as asked for, with scores in range.
fn strict<T: serde::de::DeserializeOwned + Into<Verdict>>(
    object: &Map<String, Value>,
) -> Option<Verdict> {
    let answer: T = serde_json::from_value(Value::Object(object.clone())).ok()?;
    let verdict: Verdict = answer.into();
    verdict
        .obstacles
        .iter()
        .all(|o| o.risk_score <= 5)
        .then_some(verdict)
}

/// Yes or no, from the key asked for or from keys that mean it.
fn decision(task: Task, object: &Map<String, Value>, notes: &mut Vec<String>) -> Option<bool> {
    let keys: &[&str] = match task {
        Task::Collision => &["collision", "iscollisionscenario", "iscollision"],
        Task::Safety => &["safetycritical", "issafetycritical", "critical"],
    };
    for key in keys {
        if let Some(decision) = find(object, key).and_then(truth) {
            notes.push(format!("the decision was read from `{key}`"));
            return Some(decision);
        }
    }
    // The paper's safety prompt asks only for obstacles; naming one is a yes.
    let groups = [
        "collisionobstacle",
        "extremeriskobstacle",
        "predictedcollisionobstacle",
    ];
    let present: Vec<&Value> = groups
        .iter()
        .filter_map(|group| find(object, group))
        .collect();
    (task == Task::Safety && !present.is_empty()).then(|| {
        notes.push("the decision was read from the obstacles named".into());
        present.into_iter().any(|value| !entries(value).is_empty())
    })
}

fn obstacles(object: &Map<String, Value>, notes: &mut Vec<String>) -> Vec<ObstacleRisk> {
    let mut found: Vec<ObstacleRisk> = Vec::new();
    let groups = [
        ("obstacles", None),
        ("collisionobstacle", Some(0)),
        ("predictedcollisionobstacle", Some(0)),
        ("extremeriskobstacle", Some(1)),
        ("highriskobstacle", Some(2)),
    ];
    for (group, usual) in groups {
        for (id, score, reason) in find(object, group).map(entries).unwrap_or_default() {
            let Some(risk_score) = score.filter(|s| *s <= 5).or(usual) else {
                notes.push(format!(
                    "obstacle {id} has no score from 0 to 5 and was left out"
                ));
                continue;
            };
            if group != "obstacles" {
                notes.push(format!("obstacle {id} was read from `{group}`"));
            }
            if !found.iter().any(|o| o.id == id) {
                found.push(ObstacleRisk {
                    id,
                    risk_score,
                    reason,
                });
            }
        }
    }
    found
}

/// Ids, scores and reasons in a list of objects, one object, or bare ids.
fn entries(value: &Value) -> Vec<(i64, Option<u8>, String)> {
    match value {
        Value::Array(items) => items.iter().flat_map(entries).collect(),
        Value::Object(map) => {
            let id = ["id", "obstacleid"]
                .iter()
                .find_map(|k| find(map, k))
                .map(entries);
            let score = ["riskscore", "overallriskscore", "score"]
                .iter()
                .find_map(|k| find(map, k));
            let score = score.and_then(whole).and_then(|s| u8::try_from(s).ok());
            let reason = find(map, "reason")
                .and_then(Value::as_str)
                .unwrap_or_default();
            let ids = id.unwrap_or_default().into_iter();
            ids.map(|(id, ..)| (id, score, reason.to_string()))
                .collect()
        }
        other => whole(other)
            .map(|id| (id, None, String::new()))
            .into_iter()
            .collect(),
    }
}

/// A whole number, also as `"30308"` or `30308.0`.
fn whole(value: &Value) -> Option<i64> {
    let number = match value {
        Value::Number(number) => number.as_f64()?,
        Value::String(text) => text.trim().parse().ok()?,
        _ => return None,
    };
    (number.fract() == 0.0 && number.abs() < 1e15).then_some(number as i64)
}

fn truth(value: &Value) -> Option<bool> {
    match value {
        Value::Bool(value) => Some(*value),
        Value::String(text) => match text.trim().to_ascii_lowercase().as_str() {
            "true" | "yes" => Some(true),
            "false" | "no" => Some(false),
            _ => None,
        },
        _ => None,
    }
}

/// The value of a key, whatever its case, underscores and plural; also one object further in.
fn find<'a>(object: &'a Map<String, Value>, key: &str) -> Option<&'a Value> {
    let plain = |name: &str| -> String {
        let letters: String = name.chars().filter(|c| c.is_alphanumeric()).collect();
        letters.to_lowercase()
    };
    let here = |map: &'a Map<String, Value>| {
        map.iter().find(|(name, _)| {
            let name = plain(name);
            name == key || name.strip_suffix('s') == Some(key)
        })
    };
    here(object)
        .or_else(|| object.values().filter_map(Value::as_object).find_map(here))
        .map(|(_, value)| value)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn as_asked_for() {
        let answer = "Thinking {a}.\n```json\n{\"collision\": true, \"obstacles\": [{\"id\": 7, \"risk_score\": 0, \"reason\": \"hit\"}], \"justification\": \"x\"}\n```";
        let parsed = parse(Task::Collision, answer).unwrap();
        assert_eq!(parsed.how, How::Strict);
        assert!(parsed.verdict.dangerous);
        assert_eq!(parsed.verdict.worst().unwrap().id, 7);
    }

    #[test]
    fn the_words_of_the_paper() {
        let answer = r#"{"CollisionObstacles": null, "ExtremeRiskObstacle": {"ObstacleID": "30674.0", "OverallRiskScore": "1"},
            "ScenarioAnalysis": {"IsCollisionScenario": false, "Justification": "none"}}"#;
        let parsed = parse(Task::Collision, answer).unwrap();
        assert!(matches!(parsed.how, How::Repaired(_)));
        assert!(!parsed.verdict.dangerous);
        assert_eq!(parsed.verdict.obstacles[0].id, 30674);
        assert_eq!(parsed.verdict.obstacles[0].risk_score, 1);
        assert_eq!(parsed.verdict.justification, "none");
        let safety = parse(Task::Safety, answer).unwrap();
        assert!(safety.verdict.dangerous, "an extreme risk is named");
    }

    #[test]
    fn the_last_decision_counts() {
        let answer = r#"first {"collision": false, "obstacles": [], "justification": "a"} no: {"collision": true, "obstacles": [], "justification": "b"}"#;
        assert!(parse(Task::Collision, answer).unwrap().verdict.dangerous);
    }

    #[test]
    fn out_of_range_scores_are_not_believed() {
        let answer = r#"{"collision": false, "obstacles": [{"id": 1, "risk_score": 9, "reason": ""}], "justification": ""}"#;
        let parsed = parse(Task::Collision, answer).unwrap();
        assert!(parsed.verdict.obstacles.is_empty() && matches!(parsed.how, How::Repaired(_)));
    }

    #[test]
    fn answers_without_a_verdict() {
        assert_eq!(parse(Task::Collision, "  "), Err(NoVerdict::Empty));
        assert_eq!(
            parse(Task::Collision, "It is safe."),
            Err(NoVerdict::NoJson)
        );
        assert_eq!(
            parse(Task::Collision, "```json\n{\"collision\": tr"),
            Err(NoVerdict::CutOff)
        );
        assert_eq!(
            parse(Task::Collision, "{\"hello\": 1}"),
            Err(NoVerdict::NoDecision("collision"))
        );
    }
}
