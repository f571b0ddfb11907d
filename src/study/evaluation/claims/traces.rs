//! Traces: texts of models about scenes, a line of JSON each, and how true they are by model and kind of claim.

use std::collections::BTreeMap;
use std::path::PathBuf;

use nearmiss_record::Record;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{CheckedSentence, Judgement, Quantity, SentenceOutcome, Subject, Waypoint, sentences};
use crate::evaluation::statistics::{Interval, scenario_interval};

/// A text about a scene.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trace {
    /// A scenario file, or the name of a bundled scenario.
    pub scenario: PathBuf,
    /// The ego's recording or id; left out: as the scenario has it.
    #[serde(default)]
    pub ego: Option<String>,
    /// The present of the text, seconds; left out: the end of the recording.
    #[serde(default)]
    pub time: Option<f64>,
    /// The same as a time step.
    #[serde(default)]
    pub step: Option<i64>,
    /// Steps until then that the text was told of.
    #[serde(default)]
    pub history: Option<u32>,
    /// Whether its times count from the present.
    #[serde(default)]
    pub relative: bool,
    /// Which model wrote it.
    #[serde(default)]
    pub model: Option<String>,
    /// What it wrote.
    pub text: String,
    /// What it was shown.
    #[serde(default)]
    pub prompt: Option<String>,
    /// The trajectory that came with it: `[[t, x, y], …]`, seconds from the present and metres.
    #[serde(default)]
    pub trajectory: Vec<[f64; 3]>,
}

/// Why a trace cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    /// It is no line of JSON, or not of this form.
    #[error("{}", .0.to_string().replace(" at line 1 column ", ", column "))]
    Json(#[from] serde_json::Error),
    /// It says when in two ways.
    #[error("it has time and step: leave one out")]
    Twice,
    /// A trajectory of one point.
    #[error("the trajectory has one point: two are needed")]
    OnePoint,
    /// A point of a trajectory is not later than the one before it.
    #[error("point {0} of the trajectory is not later than the one before it")]
    Backwards(usize),
}

impl Trace {
    /// From a line of JSON.
    ///
    /// # Errors
    /// The line is not one of a trace.
    pub fn read(line: &str) -> Result<Self, TraceError> {
        let trace: Self = serde_json::from_str(line)?;
        if trace.time.is_some() && trace.step.is_some() {
            return Err(TraceError::Twice);
        }
        Ok(trace)
    }
}

/// The points of a trajectory, `[t, x, y]` each: seconds and metres; none where there are no rows.
///
/// # Errors
/// There is only one, or their times do not increase.
pub fn waypoints(rows: &[[f64; 3]]) -> Result<Vec<Waypoint>, TraceError> {
    if rows.len() == 1 {
        return Err(TraceError::OnePoint);
    }
    if let Some(place) = rows.windows(2).position(|two| two[1][0] <= two[0][0]) {
        return Err(TraceError::Backwards(place + 2));
    }
    let all = { rows.iter() }
        .map(|[time, x, y]| Waypoint {
            time: *time,
            x: *x,
            y: *y,
        })
        .collect();
    Ok(all)
}

/// The sentences of many texts, each with what it is about.
#[must_use]
pub fn sentences_of(texts: &[(Subject<'_>, &str)]) -> Vec<Vec<CheckedSentence>> {
    let all = texts.par_iter();
    all.map(|(subject, text)| sentences(text, subject))
        .collect()
}

/// How many claims of a kind a model made, and how many hold.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct TruthRow {
    /// The model.
    #[schemars(title = "Model")]
    pub model: String,
    /// The kind of claim; "all" for all of them.
    #[schemars(title = "Claims")]
    pub kind: &'static str,
    /// Claims that hold.
    #[schemars(title = "Right")]
    pub right: u32,
    /// Claims that do not.
    #[schemars(title = "Wrong")]
    pub wrong: u32,
    /// Claims that cannot be decided.
    #[schemars(title = "Open")]
    pub open: u32,
    /// The share that holds of those that are decided.
    #[schemars(title = "Right share", extend("decimals" = 3))]
    pub share: Option<f64>,
    /// Its interval of 95 %: the bootstrap over scenarios, as claims about one scene are not independent; `None` of few.
    #[serde(rename = "share_ci")]
    pub interval: Option<Interval>,
}

impl Record for TruthRow {
    const NAME: &'static str = "truth";
    const TITLE: &'static str = "Claims of a kind by a model a line";
}

/// All claims but those of risk scores, which are judgements.
const FACTS: &str = "all but risk scores";

/// Claims by model and kind, the commonest kinds first, each model's "all" before them. A text comes with its model, its
/// scenario, and its sentences.
#[must_use]
pub fn truth_table<'a>(
    texts: impl IntoIterator<Item = (&'a str, &'a str, &'a [CheckedSentence])>,
) -> Vec<TruthRow> {
    type Units = BTreeMap<String, (u32, u32)>;
    let mut cells: BTreeMap<&str, BTreeMap<&'static str, ([u32; 3], Units)>> = BTreeMap::new();
    for (model, scenario, sentences) in texts {
        let kinds = cells.entry(model).or_default();
        for claim in sentences.iter().flat_map(|one| &one.claims) {
            let quantity = claim.claim.quantity;
            let is_fact = (quantity != Quantity::Risk).then_some(FACTS);
            for kind in { is_fact.into_iter() }.chain(["all", quantity.name()]) {
                let (counts, units) = kinds.entry(kind).or_default();
                let place = match claim.judgement {
                    Judgement::Right => 0,
                    Judgement::Wrong => 1,
                    Judgement::Unknown(_) => 2,
                };
                counts[place] += 1;
                if place < 2 {
                    let (right, decided) = units.entry(scenario.to_owned()).or_default();
                    *right += u32::from(place == 0);
                    *decided += 1;
                }
            }
        }
    }
    let mut rows = Vec::new();
    for (model, kinds) in cells {
        let mut own: Vec<TruthRow> = { kinds.into_iter() }
            .map(|(kind, (counts, units))| {
                let [right, wrong, open] = counts;
                let decided = right + wrong;
                let units: Vec<(u32, u32)> = units.into_values().collect();
                TruthRow {
                    model: model.to_owned(),
                    kind,
                    right,
                    wrong,
                    open,
                    share: (decided > 0).then(|| f64::from(right) / f64::from(decided)),
                    interval: scenario_interval(&units),
                }
            })
            .collect();
        own.sort_by_key(|row| {
            (
                row.kind != "all",
                row.kind != FACTS,
                std::cmp::Reverse(row.right + row.wrong + row.open),
            )
        });
        rows.extend(own);
    }
    rows
}

impl CheckedSentence {
    /// Sentences by what they come to, in the order of [`SentenceOutcome`].
    #[must_use]
    pub fn counts(all: &[Self]) -> [usize; 4] {
        let count = |outcome| all.iter().filter(|one| one.outcome == outcome).count();
        [
            count(SentenceOutcome::Right),
            count(SentenceOutcome::Wrong),
            count(SentenceOutcome::Open),
            count(SentenceOutcome::NotUnderstood),
        ]
    }
}
