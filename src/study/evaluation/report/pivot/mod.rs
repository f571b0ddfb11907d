//! Tables over any axes: a measure by model and techniques, by lead and frame; and differences from a baseline.

mod axis;
mod output;

use std::collections::{BTreeMap, BTreeSet, HashMap};

use nearmiss_ask::llm::Parameters;
use nearmiss_base::system::available;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{RunId, RunOrigin};
use rayon::prelude::*;

use super::cell::count;
use super::{Cell, DataHalf, Report, ReportSubject};
use crate::evaluation::statistics::{PairedTest, holm};
use crate::evaluation::{AnswerCase, Scored};

pub use axis::{Axis, AxisValue, Measure};
pub use output::AxesDocument;

nearmiss_record::fields! {
    /// Which table is wanted.
    #[derive(Eq)]
    pub struct PivotRequest {
        "table" {
            /// The axis of the rows.
            rows [required]: Axis = Axis::Techniques;
            /// That of the columns; by default one column.
            columns: Option<Axis>;
            /// What is measured.
            measure: Measure;
            /// The value of the rows' axis that all others are compared with.
            against: Option<String>;
        }
    }
}

impl PivotRequest {
    /// Whether its axes fit together.
    ///
    /// # Errors
    /// The name of the wrong part, and what to do.
    pub fn check(&self) -> Result<(), (&'static str, &'static str)> {
        let compared = self.against.is_some();
        match self.rows {
            rows if self.columns == Some(rows) => {
                Err(("columns", "the rows have this axis; choose another"))
            }
            Axis::Task if compared => Err((
                "against",
                "tasks have different truths; choose another axis for the rows",
            )),
            Axis::Country if compared => Err((
                "against",
                "scenarios of different countries cannot be paired; choose another axis for the rows",
            )),
            _ => Ok(()),
        }
    }

    /// The same in words: `f1 by techniques and model, against base`.
    #[must_use]
    pub fn summary(&self) -> String {
        let columns = self.columns.map(|axis| format!(" and {}", axis.name()));
        let against = self
            .against
            .as_ref()
            .map(|name| format!(", against {name}"));
        format!(
            "{} by {}{}{}",
            self.measure.name(),
            self.rows.name(),
            columns.unwrap_or_default(),
            against.unwrap_or_default()
        )
    }
}

/// A table for each task.
#[derive(Debug, Clone, PartialEq)]
pub struct Pivot {
    /// Which table.
    pub request: PivotRequest,
    /// The tables, in the order of tasks; one of all tasks where a task is a value of an axis.
    pub parts: Vec<PivotPart>,
    /// Which answers these are, and beside which truth.
    pub about: ReportSubject,
    /// When they were asked, and whom.
    pub asked: AskedFacts,
    /// What is said before every table.
    warnings: Vec<String>,
}

/// The table of a task.
#[derive(Debug, Clone, PartialEq)]
pub struct PivotPart {
    /// The task; `None` of all.
    pub task: Option<Task>,
    /// Scenarios, and questions about them.
    pub counted: (usize, usize),
    /// Cells that have answers, row by row.
    pub cells: Vec<PivotCell>,
    /// Differences from the baseline, where there is one.
    pub differences: Vec<Difference>,
}

/// The answers with one value of each axis.
#[derive(Debug, Clone, PartialEq)]
pub struct PivotCell {
    /// The value of the rows' axis.
    pub row: AxisValue,
    /// That of the columns' axis.
    pub column: Option<AxisValue>,
    /// What they come to.
    pub cell: Cell,
}

/// An answer with its values of the axes.
struct Placed<'a> {
    case: AnswerCase<'a>,
    parameters: Option<&'a Parameters>,
    row: AxisValue,
    column: Option<AxisValue>,
}

impl Pivot {
    /// Counts answers by the axes. Other leads and transformed scenes count only where an axis tells them apart.
    ///
    /// # Errors
    /// No answer has the value that is to be compared with.
    pub fn new(
        cases: &[AnswerCase<'_>],
        asked: AskedFacts,
        request: PivotRequest,
    ) -> Result<Self, String> {
        let has = |axis| request.rows == axis || request.columns == Some(axis);
        let safety = |case: &&AnswerCase<'_>| case.scored.configuration.task == Task::Safety;
        let first = cases.iter().find(safety).and_then(|case| case.lead);
        let counts = |case: &&AnswerCase<'_>| {
            let changed = case.transform().is_some() && !has(Axis::Transform);
            let other_lead = safety(case) && case.lead != first && !has(Axis::Lead);
            !changed && !other_lead
        };
        let placed = cases.iter().filter(counts).map(|case| {
            let parameters = case.scored.run.and_then(|run| asked.parameters.get(&run));
            Placed {
                case: *case,
                parameters,
                row: request.rows.value(case, parameters),
                column: request.columns.map(|axis| axis.value(case, parameters)),
            }
        });
        let mut tasks: BTreeMap<Option<Task>, Vec<Placed<'_>>> = BTreeMap::new();
        for one in placed {
            let task = (!has(Axis::Task)).then_some(one.case.scored.configuration.task);
            tasks.entry(task).or_default().push(one);
        }
        let mut values = BTreeSet::new();
        values.extend(tasks.values().flatten().map(|one| one.row.clone()));
        if let Some(name) = &request.against
            && !values.iter().any(|value| value.text == *name)
        {
            let known = values.iter().map(|value| value.text.as_str());
            let axis = request.rows.name();
            return Err(format!(
                "no answer has the {axis} `{name}`{}",
                available(name, known)
            ));
        }
        let parts = tasks
            .iter()
            .map(|(task, placed)| part(*task, placed, &request));
        Ok(Self {
            parts: parts.collect(),
            request,
            about: ReportSubject::default(),
            asked,
            warnings: Report::answer_warnings(cases.iter().map(|case| case.scored)).collect(),
        })
    }

    /// The same, saying what it is of, who left out much and whose verdicts are doubtful.
    #[must_use]
    pub fn about(self, mut about: ReportSubject) -> Self {
        about.notes.splice(0..0, self.warnings.iter().cloned());
        Self { about, ..self }
    }
}

fn part(task: Option<Task>, placed: &[Placed<'_>], request: &PivotRequest) -> PivotPart {
    let mut groups: BTreeMap<(&AxisValue, &Option<AxisValue>), Vec<&Scored>> = BTreeMap::new();
    for one in placed {
        let group = groups.entry((&one.row, &one.column)).or_default();
        group.push(one.case.scored);
    }
    let groups: Vec<_> = groups.into_iter().collect();
    let cells = groups.par_iter().filter_map(|((row, column), scored)| {
        Some(PivotCell {
            row: (*row).clone(),
            column: (*column).clone(),
            cell: Cell::count(&scored.first()?.configuration, DataHalf::All, scored),
        })
    });
    let baseline = request.against.as_ref().and_then(|name| {
        let named = placed.iter().find(|one| one.row.text == *name)?;
        Some(named.row.clone())
    });
    let differences = baseline.map(|value| differences(request.rows, &value, placed));
    let scenarios: BTreeSet<&str> = placed.iter().map(|one| one.case.scenario()).collect();
    PivotPart {
        task,
        counted: (scenarios.len(), placed.len()),
        cells: cells.collect(),
        differences: differences.unwrap_or_default(),
    }
}

/// When and whom a table's answers were asked, and with which parameters.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AskedFacts {
    /// Parameters that were sent, by run.
    parameters: HashMap<RunId, Parameters>,
    /// When the first and the last answer was asked, milliseconds since 1970, UTC.
    pub asked_ms: Option<(i64, i64)>,
    /// The names that servers returned, by the model asked for.
    pub returned: BTreeMap<String, BTreeSet<String>>,
}

impl AskedFacts {
    /// Of these answers, as far as the store knows their runs.
    #[must_use]
    pub fn new(cases: &[AnswerCase<'_>], runs: &[RunOrigin]) -> Self {
        let runs: HashMap<RunId, &RunOrigin> = runs.iter().map(|one| (one.run, one)).collect();
        let mut facts = Self::default();
        for case in cases {
            let Some((id, run)) = case.scored.run.and_then(|id| Some((id, runs.get(&id)?))) else {
                continue;
            };
            // Without a prompt nothing was sent.
            if case.scored.configuration.frame.is_some()
                && let Ok(sent) = serde_json::from_str(&run.parameters)
            {
                facts.parameters.insert(id, sent);
            }
            let (first, last) = facts.asked_ms.unwrap_or((run.created_ms, run.created_ms));
            facts.asked_ms = Some((first.min(run.created_ms), last.max(run.created_ms)));
            if let Some(name) = &run.model_returned {
                let names = facts
                    .returned
                    .entry(case.scored.configuration.model.clone());
                names.or_default().insert(name.clone());
            }
        }
        facts
    }

    /// In words: `asked 2026-11-23 to 2026-11-24; models as returned: …`; `None` where nothing is known.
    #[must_use]
    pub fn summary(&self) -> Option<String> {
        let day = |ms| {
            let time = jiff::Timestamp::from_millisecond(ms).ok()?;
            Some(time.strftime("%Y-%m-%d").to_string())
        };
        let mut parts = Vec::new();
        if let Some((first, last)) = self.asked_ms.and_then(|(a, b)| Some((day(a)?, day(b)?))) {
            parts.push(if first == last {
                format!("asked {first}")
            } else {
                format!("asked {first} to {last}")
            });
        }
        let models = self.returned.iter().map(|(model, names)| {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            format!("{} ({model})", names.join(", "))
        });
        let models: Vec<String> = models.collect();
        if !models.is_empty() {
            parts.push(format!("models as returned: {}", models.join("; ")));
        }
        (!parts.is_empty()).then(|| parts.join("; "))
    }
}

/// A value of the rows' axis against the baseline, within a column.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// The value.
    pub row: AxisValue,
    /// The column; `None` without a second axis.
    pub column: Option<AxisValue>,
    /// Units that both were asked about alike in all else.
    pub units: u32,
    /// Units that both have questions about, and that at least one was not asked so.
    pub left_out: u32,
    /// By how much the value is right more often than the baseline.
    pub test: PairedTest,
    /// Its p value, corrected for all differences of the table, by Holm.
    pub corrected: f64,
}

/// Questions that are right and that are not, by unit, and within it by scenario and how else was asked.
type Verdicts<'a> = BTreeMap<&'a str, BTreeMap<(&'a str, Vec<AxisValue>), (u32, u32)>>;

/// Every value but the baseline, in every column in which both have answers.
fn differences(rows: Axis, baseline: &AxisValue, placed: &[Placed<'_>]) -> Vec<Difference> {
    let columns: BTreeSet<&Option<AxisValue>> = placed.iter().map(|one| &one.column).collect();
    let values: BTreeSet<&AxisValue> = placed.iter().map(|one| &one.row).collect();
    let mut sides: BTreeMap<(&AxisValue, &Option<AxisValue>), Verdicts<'_>> = BTreeMap::new();
    for one in placed {
        let side = sides.entry((&one.row, &one.column)).or_default();
        take(side, rows, one);
    }
    let wanted: Vec<_> = values
        .into_iter()
        .filter(|value| *value != baseline)
        .flat_map(|value| columns.iter().map(move |column| (value, *column)))
        .collect();
    let found = wanted.into_par_iter().filter_map(|(row, column)| {
        let (one, other) = (sides.get(&(row, column))?, sides.get(&(baseline, column))?);
        difference(row, column, one, other)
    });
    let mut found: Vec<Difference> = found.collect();
    let p: Vec<f64> = found.iter().map(|one| one.test.p).collect();
    for (one, corrected) in found.iter_mut().zip(holm(&p)) {
        one.corrected = corrected;
    }
    found
}

fn take<'a>(side: &mut Verdicts<'a>, rows: Axis, one: &Placed<'a>) {
    let scored = one.case.scored;
    if scored.is_collision().is_none() {
        return;
    }
    let others = Axis::OF_QUESTIONS
        .into_iter()
        .filter(|axis| *axis != rows)
        // A template belongs to its frame: where frames are compared, templates differ, too.
        .filter(|axis| rows != Axis::Frame || *axis != Axis::Template);
    let alike: Vec<AxisValue> = others
        .map(|axis| axis.value(&one.case, one.parameters))
        .collect();
    let votes = side
        .entry(scored.cluster.unit(one.case.scenario()))
        .or_default()
        .entry((one.case.scenario(), alike))
        .or_default();
    match scored.is_right() {
        Some(true) => votes.0 += 1,
        Some(false) => votes.1 += 1,
        None => {}
    }
}

fn difference(
    row: &AxisValue,
    column: &Option<AxisValue>,
    one: &Verdicts<'_>,
    other: &Verdicts<'_>,
) -> Option<Difference> {
    let share = |(right, wrong): (u32, u32)| {
        let all = right + wrong;
        (all > 0).then(|| f64::from(right) / f64::from(all))
    };
    let (mut differences, mut left_out) = (Vec::new(), 0_usize);
    for (unit, votes) in one {
        let Some(others) = other.get(unit) else {
            continue;
        };
        let pairs = votes.iter().filter_map(|(alike, votes)| {
            let other = others.get(alike)?;
            Some(share(*votes)? - share(*other)?)
        });
        let pairs: Vec<f64> = pairs.collect();
        if pairs.is_empty() {
            left_out += 1
        } else {
            differences.push(pairs.iter().sum::<f64>() / pairs.len() as f64)
        }
    }
    Some(Difference {
        row: row.clone(),
        column: column.clone(),
        units: count(differences.len()),
        left_out: count(left_out),
        test: PairedTest::of_differences(&differences)?.if_enough(count(differences.len())),
        corrected: 1.0,
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
