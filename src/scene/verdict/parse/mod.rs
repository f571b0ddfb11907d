//! Parses a model's answer: JSON anywhere in the text, in the requested schema or another one.

use std::collections::HashSet;

use serde_json::Value;

use super::answer_schema::{self, CollisionAnswer, RecordingAnswer, SafetyAnswer};
use super::lenient::{End, JsonPiece};
use super::parsed_answer::Notes;
use super::trajectory::TrajectoryAnswer;
use super::values::Object;
use super::{
    AttackerChoice, NewMotion, ParsedAnswer, Task, Verdict, critical, decision, lenient,
    trajectory, values,
};

/// How an answer was parsed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ParseQuality {
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
    pub how: ParseQuality,
}

/// An answer to any task, and how it was parsed.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// What it says.
    pub said: ParsedAnswer,
    /// How it was read.
    pub how: ParseQuality,
}

/// Why an answer has no verdict.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NoVerdict {
    /// The text is empty.
    #[error("the answer is empty")]
    Empty,
    /// There is no JSON object in it.
    #[error("no JSON object in the answer")]
    NoJson,
    /// A JSON object begins and never ends.
    #[error("the answer breaks off inside its JSON")]
    CutOff,
    /// There is JSON, but it does not answer the question.
    #[error("the answer's JSON has no `{0}`")]
    NoDecision(&'static str),
    /// One object says yes and no.
    #[error("the answer contradicts itself: `{0}` and `{1}` disagree")]
    Contradictory(String, String),
    /// It is there, but cannot be meant so.
    #[error("the answer cannot be used: {0}")]
    Unusable(String),
}

/// Reads the verdict on a yes-or-no task from the text of an answer; the last object that says yes or no counts.
///
/// ```
/// use nearmiss_scene::verdict::{Task, parse};
///
/// let answer = "The gap closes fast.\n```json\n{\"collision\": true, \"obstacles\": [], \"justification\": \"it closes\",}\n```";
/// let parsed = parse(Task::Collision, answer)?; // the comma too many does no harm
/// assert!(parsed.verdict.dangerous);
/// # Ok::<(), nearmiss_scene::verdict::NoVerdict>(())
/// ```
///
/// # Errors
/// See [`NoVerdict`]; for the other tasks, see [`read`].
pub fn parse(task: Task, answer: &str) -> Result<Parsed, NoVerdict> {
    let Reading { said, how } = read(task, answer)?;
    match said {
        ParsedAnswer::Verdict(verdict) => Ok(Parsed { verdict, how }),
        ParsedAnswer::Attacker(_) | ParsedAnswer::Trajectory(_) => {
            Err(NoVerdict::NoDecision(task.key()))
        }
    }
}

/// Reads what the text of an answer says to a task; of several objects that say it, the last one counts.
///
/// # Errors
/// See [`NoVerdict`].
pub fn read(task: Task, answer: &str) -> Result<Reading, NoVerdict> {
    if answer.trim().is_empty() {
        return Err(NoVerdict::Empty);
    }
    let read = read_plain(task, answer);
    let is_nothing = matches!(
        read,
        Err(NoVerdict::NoJson | NoVerdict::NoDecision(_) | NoVerdict::CutOff)
    );
    if !is_nothing {
        return read;
    }
    for (text, how) in disguised(answer) {
        if let Ok(mut found) = read_plain(task, &text) {
            let mut notes = match found.how {
                ParseQuality::Strict => Vec::new(),
                ParseQuality::Repaired(notes) => notes,
            };
            notes.insert(0, how.into());
            found.how = ParseQuality::Repaired(notes);
            return Ok(found);
        }
    }
    read
}

fn read_plain(task: Task, answer: &str) -> Result<Reading, NoVerdict> {
    let pieces = lenient::read(answer);
    let found = AnswerObjects::new(&pieces);
    let reading = match task {
        Task::Collision | Task::Safety | Task::Recording => found.verdict(task)?,
        Task::Attacker => found.attacker(),
        Task::Trajectory => found.trajectory()?,
    };
    match reading {
        Some(reading) => Ok(reading),
        None if pieces.last().is_some_and(|p| p.end == End::CutOff) => Err(NoVerdict::CutOff),
        None if pieces.is_empty() => Err(NoVerdict::NoJson),
        None => Err(NoVerdict::NoDecision(task.key())),
    }
}

/// Whether an object says neither why nor of whom, as an example or a summary after the answer.
fn is_fragment(object: &Object) -> bool {
    !object.contains_key("obstacles") && !object.contains_key("justification")
}

/// The objects of an answer, outermost ones and those in outermost lists, with the pieces they are from.
struct AnswerObjects<'a> {
    pieces: &'a [JsonPiece],
    objects: Vec<(&'a JsonPiece, &'a Object)>,
}

impl<'a> AnswerObjects<'a> {
    fn new(pieces: &'a [JsonPiece]) -> Self {
        let of = |piece: &'a JsonPiece| {
            let items = match &piece.value {
                Value::Array(items) => items.iter().collect(),
                other => vec![other],
            };
            items
                .into_iter()
                .filter_map(Value::as_object)
                .map(move |o| (piece, o))
        };
        Self {
            pieces,
            objects: pieces.iter().flat_map(of).collect(),
        }
    }

    /// Notes on the texts of some pieces, on later ones that say nothing more, and on how they depart from the schema.
    fn notes(&self, piece: &JsonPiece) -> Notes {
        let mut notes = Notes::default();
        notes.note_repairs(piece);
        let last = self.pieces.last();
        if last.is_some_and(|last| !std::ptr::eq(last, piece) && last.end == End::CutOff) {
            notes.add("the answer breaks off inside a later object");
        }
        notes
    }

    fn verdict(&self, task: Task) -> Result<Option<Reading>, NoVerdict> {
        let mut decided = None;
        let mut overruled = None;
        for (place, (piece, object)) in self.objects.iter().enumerate().rev() {
            let is_complete = strict_verdict(task, object).is_some();
            if decided.is_some() && !is_complete {
                continue;
            }
            if let Some(decision) = decision::read_decision(task, object)? {
                // A complete answer beats a fragment after it, such as an example.
                let before = decided.replace((place, *piece, *object, decision));
                overruled = before.map(|(.., decision)| decision.dangerous);
                if is_complete || !is_fragment(object) {
                    break;
                }
            }
        }
        let Some((place, piece, object, decision)) = decided else {
            return Ok(None);
        };
        let mut notes = self.notes(piece);
        if overruled.is_some_and(|dangerous| dangerous != decision.dangerous) {
            notes.add("a fragment after the complete answer differs; the answer is used");
        }
        let earlier = self.objects[..place]
            .iter()
            .rev()
            .filter_map(|(_, o)| decision::read_decision(task, o).ok().flatten());
        if let Some(strict) = strict_verdict(task, object) {
            if earlier
                .take(1)
                .any(|before| before.dangerous != strict.dangerous)
            {
                notes.add("an earlier object of the answer differs; the last one is used");
            }
            return Ok(Some(Reading {
                said: strict.into(),
                how: notes.how(),
            }));
        }
        let merged = decision::merge(task, &self.objects[..=place], &mut notes);
        let object = merged.as_ref().unwrap_or(object);
        let decision = match &merged {
            Some(merged) => decision::read_decision(task, merged)?.unwrap_or(decision),
            None => decision,
        };
        if merged.is_none()
            && earlier
                .take(1)
                .any(|before| before.dangerous != decision.dangerous)
        {
            notes.add("an earlier object of the answer differs; the last one is used");
        }
        let obstacles = decision::obstacles(object, &decision, &mut notes);
        if decision.as_asked {
            answer_schema::violations(task, object, &mut notes);
        } else {
            notes.add(decision.note.clone());
        }
        let justification = justification(object, &mut notes);
        let critical = critical::critical_obstacles(object, &mut notes);
        let probability = critical::probability(object, &mut notes);
        Ok(Some(Reading {
            said: ParsedAnswer::Verdict(Verdict {
                task,
                dangerous: decision.dangerous,
                obstacles,
                justification,
                critical,
                probability,
                token_probability: None,
                unknown: Vec::new(),
            }),
            how: notes.how(),
        }))
    }

    fn attacker(&self) -> Option<Reading> {
        // An answer with a yes or no lists obstacles for that, not as attackers.
        let other_task = self.objects.iter().any(|(_, o)| decision::is_stated(o));
        self.objects.iter().rev().find_map(|(piece, object)| {
            if other_task && !trajectory::is_named(object) {
                return None;
            }
            let mut notes = self.notes(piece);
            let choice = strict::<AttackerChoice>(Task::Attacker, object).or_else(|| {
                notes.add("read from keys other than those requested");
                trajectory::interpret(object, &mut notes)
            })?;
            Some(Reading {
                said: ParsedAnswer::Attacker(choice),
                how: notes.how(),
            })
        })
    }

    fn trajectory(&self) -> Result<Option<Reading>, NoVerdict> {
        for (piece, object) in self.objects.iter().rev() {
            let mut notes = self.notes(piece);
            let answer = match strict::<TrajectoryAnswer>(Task::Trajectory, object) {
                Some(answer) => Some(answer),
                None => {
                    trajectory::interpret_motion(object, &mut notes).map_err(NoVerdict::Unusable)?
                }
            };
            if let Some(answer) = answer {
                return reading(answer, notes).map(Some);
            }
        }
        // Waypoints one object each, or as a bare list, and the obstacle before them.
        let mut notes = Notes::default();
        let points: Vec<Value> = match self.pieces.iter().rev().find_map(|p| rows(&p.value)) {
            Some(rows) => rows.to_vec(),
            None => {
                let points = self.objects.iter().filter(|(_, o)| trajectory::is_point(o));
                points.map(|(_, o)| Value::Object((*o).clone())).collect()
            }
        };
        if points.is_empty() {
            return Ok(None);
        }
        let names = [
            "obstacle",
            "obstacleid",
            "attacker",
            "attackerid",
            "vehicleid",
        ];
        let ids: HashSet<i64> = self
            .objects
            .iter()
            .filter_map(|(_, o)| match values::id(values::find(o, &names)?) {
                values::Id::Is(id) => Some(id),
                values::Id::Unclear(_) => None,
            })
            .collect();
        let mut ids = ids.into_iter();
        let (Some(obstacle), None) = (ids.next(), ids.next()) else {
            let why = "waypoints without the one obstacle that moves";
            return Err(NoVerdict::Unusable(why.into()));
        };
        for piece in self.pieces {
            notes.note_repairs(piece);
        }
        notes.add("the waypoints were merged from several objects");
        let waypoints = trajectory::waypoints(&Value::Array(points), &mut notes)
            .map_err(NoVerdict::Unusable)?;
        let answer = TrajectoryAnswer {
            obstacle,
            waypoints: Some(waypoints),
            manoeuvre: None,
            justification: String::new(),
        };
        reading(answer, notes).map(Some)
    }
}

fn reading(answer: TrajectoryAnswer, notes: Notes) -> Result<Reading, NoVerdict> {
    let said = NewMotion::try_from(answer).map_err(NoVerdict::Unusable)?;
    Ok(Reading {
        said: ParsedAnswer::Trajectory(said),
        how: notes.how(),
    })
}

/// A list of lists of numbers.
fn rows(value: &Value) -> Option<&[Value]> {
    let items = value.as_array()?;
    items.iter().all(Value::is_array).then_some(items)
}

/// The object as the answer it was asked to be, if it keeps to the schema. It may name the task, as it does where it
/// is printed and stored.
fn strict<T: serde::de::DeserializeOwned>(task: Task, object: &Object) -> Option<T> {
    let mut object = object.clone();
    if object.get("task").is_some_and(|named| named == task.name()) {
        object.shift_remove("task");
    }
    let value = Value::Object(object);
    answer_schema::is_valid(task, &value).then(|| serde_json::from_value(value).ok())?
}

fn strict_verdict(task: Task, object: &Object) -> Option<Verdict> {
    match task {
        Task::Collision => strict::<CollisionAnswer>(task, object).map(Verdict::from),
        Task::Safety => strict::<SafetyAnswer>(task, object).map(Verdict::from),
        Task::Recording => strict::<RecordingAnswer>(task, object).map(Verdict::from),
        Task::Attacker | Task::Trajectory => None,
    }
}

/// The overall justification in an object; notes its absence.
pub(super) fn justification(object: &Object, notes: &mut Notes) -> String {
    let names = [
        "justification",
        "reasoning",
        "explanation",
        "rationale",
        "analysis",
        "summary",
    ];
    let found = values::find(object, &names).and_then(values::text);
    found.unwrap_or_else(|| {
        notes.add("no justification");
        String::new()
    })
}

/// What an answer may be in another form: JSON in a JSON string, JSON whose quotes are escaped, JSON with the signs of East
/// Asian keyboards; with what was done.
fn disguised(answer: &str) -> Vec<(String, &'static str)> {
    let mut found = Vec::new();
    if let Ok(Value::String(text)) = serde_json::from_str(answer.trim()) {
        found.push((text, "the JSON is written in a string"));
    }
    if answer.contains("\\\"") {
        found.push((
            answer.replace("\\\"", "\""),
            "the quotes of the JSON are escaped",
        ));
    }
    let narrow = |sign: char| match sign {
        '：' => ':',
        '，' => ',',
        '｛' => '{',
        '｝' => '}',
        '［' => '[',
        '］' => ']',
        '＂' => '"',
        other => other,
    };
    let narrowed: String = answer.chars().map(narrow).collect();
    if narrowed != answer {
        found.push((narrowed, "the JSON has full-width signs"));
    }
    found
}

#[cfg(test)]
mod pack_tests;
#[cfg(test)]
mod proposals;
#[cfg(test)]
mod recording_tests;
#[cfg(test)]
mod tests;
