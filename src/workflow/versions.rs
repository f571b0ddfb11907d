//! Two versions of a prompt over the same scenarios: their stored answers beside the truth, and what changed.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::batch::{BatchError, BatchPlan, DryRun, DryRunEvent};
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::Entry;
use nearmiss_scene::verdict;
use nearmiss_store::{NewItem, Run, RunId, SameQuestion, Store, StoreError};
use nearmiss_study::evaluation::batch::{Estimate, Variant, critical_of, label_of, way_of};
use nearmiss_study::evaluation::statistics::{FEWEST, PairedTest};
use nearmiss_study::evaluation::{
    AnswerStatus, Cluster, Judges, Label, Outcome, Scored, with_token_probability,
};

/// A version of a prompt.
pub struct VersionSource {
    /// The questions that it makes of the scenarios.
    pub plan: BatchPlan,
    /// The hash of its template, where that is all that is known of it: then only what was asked counts.
    pub hash: Option<String>,
}

/// The answers about a scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparedAnswers {
    /// Where the scenario is from.
    pub entry: Entry,
    /// The answer to each version, or why there is none.
    pub answers: [Scored; 2],
}

/// The answers to two versions of a prompt.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VersionComparison {
    /// The truth that answers are held against, in words.
    pub truth: String,
    /// The scenarios, in order.
    pub rows: Vec<ComparedAnswers>,
    /// What asking each version takes.
    pub estimates: [Estimate; 2],
    /// Scenarios that are left out because their truth is unknown.
    pub unlabelled: usize,
    /// Scenarios that are left out because an answer is one of a locked test split.
    pub locked: usize,
}

/// What the second version changed about an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VersionChange {
    /// An answer is missing.
    Missing,
    /// Both say the same.
    Same,
    /// The second is right, the first was not.
    Better,
    /// The first was right, the second is not.
    Worse,
    /// They differ, and neither is right alone, or the truth is unknown.
    Other,
}

/// Consumption of the answers to one version.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SideTotals {
    /// Answers.
    pub answers: usize,
    /// Those that are right.
    pub right: usize,
    /// Tokens of questions and answers, where the server counted them.
    pub tokens: u64,
    /// US dollars, where they are known.
    pub usd: f64,
    /// Answers whose cost is unknown.
    pub unpriced: usize,
}

/// Sums over all scenarios.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VersionTotals {
    /// Scenarios with both answers.
    pub pairs: usize,
    /// Those whose answers differ.
    pub changed: usize,
    /// Those that became right.
    pub better: usize,
    /// Those that became wrong.
    pub worse: usize,
    /// The paired permutation test by scenario of the second version's right answers minus the first's; `None` below
    /// ten scenarios, or where none became right or wrong.
    pub test: Option<PairedTest>,
    /// Each version.
    pub sides: [SideTotals; 2],
}

/// Finds the stored answers to two versions; nothing is asked. Nothing where `cancel` asked for an end. `on_progress`
/// is told how many questions of both were made.
///
/// # Errors
/// The store cannot be read, or a label cannot be of its scenario.
pub fn compare_versions(
    sides: &[VersionSource; 2],
    judges: &Judges,
    store: &Store,
    cancel: &Cancel,
    on_progress: &mut dyn FnMut(usize),
) -> Result<Option<VersionComparison>, BatchError> {
    let mut found: [Vec<(Entry, Scored)>; 2] = Default::default();
    let mut comparison = VersionComparison {
        truth: sides[0].plan.spec.truth.words(),
        ..VersionComparison::default()
    };
    let mut before = 0;
    for (place, side) in sides.iter().enumerate() {
        let told = &mut |event: DryRunEvent<'_>| {
            let DryRunEvent::Described { done, .. } = event;
            on_progress(before + done);
        };
        let Some(dry_run) = side.plan.dry_run(judges, store, cancel, told)? else {
            return Ok(None);
        };
        before += side.plan.scenarios();
        found[place] = answers(side, &dry_run, store)?;
        comparison.unlabelled = dry_run.unlabelled.len();
        if side.hash.is_none() {
            comparison.estimates[place] = dry_run.estimate;
        }
    }
    let [first, second] = found;
    let mut second: HashMap<_, _> = second
        .into_iter()
        .map(|(entry, scored)| (entry.place, scored))
        .collect();
    let rows = first.into_iter().filter_map(|(entry, a)| {
        let b = second.remove(&entry.place)?;
        Some(ComparedAnswers {
            entry,
            answers: [a, b],
        })
    });
    let locked = store.locked_runs()?;
    comparison.set_rows(rows.collect(), |run| locked.contains_key(&run));
    Ok(Some(comparison))
}

/// The stored answers to the questions of a version, in order.
fn answers(
    side: &VersionSource,
    dry_run: &DryRun,
    store: &Store,
) -> Result<Vec<(Entry, Scored)>, StoreError> {
    let one = |item: &NewItem| {
        let entry = Entry::of_argument(Path::new(&item.path));
        let run = match (&side.hash, &item.key) {
            (Some(hash), _) => with_template(side, &entry, item, hash, store)?,
            (None, Some(key)) => store.answer_with_key(key, item.sample)?,
            (None, None) => None,
        };
        let scored = scored(item, run)?;
        Ok((entry, scored))
    };
    dry_run.items.iter().map(one).collect()
}

/// The newest answer to a question that was asked with a template of which only the hash is known.
fn with_template(
    side: &VersionSource,
    entry: &Entry,
    item: &NewItem,
    hash: &str,
    store: &Store,
) -> Result<Option<Run>, StoreError> {
    let way = way_of(item).map_err(StoreError::Word)?;
    let question = side
        .plan
        .builder
        .question(entry, &way, &Variant::default(), label_of(item));
    let (Ok(question), Some(scenario_hash), Some(ego)) = (question, &item.scenario_hash, &item.ego)
    else {
        return Ok(None);
    };
    let window = question.case.window;
    let same = SameQuestion {
        scenario_hash,
        ego,
        task: item.task,
        frame: question.case.frame.name(),
        techniques: &question.case.techniques.to_string(),
        model: &item.model,
        window: (window.first(), window.last()),
    };
    store.answer_with_template(&same, hash)
}

/// A stored answer beside the truth; its verdict is read from its text, as for a report.
fn scored(item: &NewItem, run: Option<Run>) -> Result<Scored, StoreError> {
    let status = match (&run, &item.unaskable) {
        (Some(run), _) => {
            let text = match run.answer.trim().is_empty() {
                true => &run.reasoning,
                false => &run.answer,
            };
            match verdict::parse(item.task, text) {
                Ok(parsed) => AnswerStatus::Verdict(with_token_probability(
                    parsed.verdict,
                    run.verdict_json.as_deref(),
                )),
                Err(why) => AnswerStatus::Unparsed(why.to_string()),
            }
        }
        (None, Some(why)) => AnswerStatus::Failed(why.clone()),
        (None, None) => AnswerStatus::Unasked("not asked yet".into()),
    };
    Ok(Scored {
        scenario: item.scenario.clone(),
        way: way_of(item).map_err(StoreError::Word)?,
        sample: item.sample,
        truth: label_of(item),
        critical: label_of(item)
            .map_or_else(Vec::new, |label| critical_of(label, item.facts.as_ref())),
        status,
        reference: None,
        window: item.window,
        most_usd: None,
        superseded: Vec::new(),
        consumed: run
            .as_ref()
            .map(|run| run.ending.consumed)
            .unwrap_or_default(),
        claims: run
            .as_ref()
            .map(|run| run.ending.claims)
            .unwrap_or_default(),
        cluster: Cluster::default(),
        run: run.map(|run| run.id),
    })
}

impl VersionChange {
    /// Right answers of the second version minus those of the first.
    fn gain(self) -> f64 {
        match self {
            Self::Better => 1.0,
            Self::Worse => -1.0,
            Self::Missing | Self::Same | Self::Other => 0.0,
        }
    }
}

impl ComparedAnswers {
    /// What is true; `None` if it is unknown.
    #[must_use]
    pub fn truth(&self) -> Option<Label> {
        self.answers[0].truth
    }

    /// What the second version changed.
    #[must_use]
    pub fn change(&self) -> VersionChange {
        let [a, b] = &self.answers;
        if a.run.is_none() || b.run.is_none() {
            return VersionChange::Missing;
        }
        let right = |one: &Scored| Outcome::of_scored(one).and_then(Outcome::is_right);
        match (right(a) == Some(true), right(b) == Some(true)) {
            (false, true) => VersionChange::Better,
            (true, false) => VersionChange::Worse,
            _ if a.positive() == b.positive() => VersionChange::Same,
            _ => VersionChange::Other,
        }
    }

    /// Whether a version was not asked about it, and can be.
    #[must_use]
    pub fn is_missing(&self, side: usize) -> bool {
        matches!(self.answers[side].status, AnswerStatus::Unasked(_))
    }
}

impl VersionComparison {
    /// Takes the scenarios without those of which an answer is locked.
    fn set_rows(&mut self, rows: Vec<ComparedAnswers>, is_locked: impl Fn(RunId) -> bool) {
        let all = rows.len();
        let may_be_shown = |row: &ComparedAnswers| {
            let mut runs = row.answers.iter().filter_map(|one| one.run);
            !runs.any(&is_locked)
        };
        self.rows = rows.into_iter().filter(may_be_shown).collect();
        self.locked = all - self.rows.len();
    }

    /// The scenarios that a version was not asked about yet.
    #[must_use]
    pub fn missing(&self, side: usize) -> Vec<Entry> {
        let rows = self.rows.iter().filter(|row| row.is_missing(side));
        rows.map(|row| row.entry.clone()).collect()
    }

    /// Sums over all scenarios.
    #[must_use]
    pub fn totals(&self) -> VersionTotals {
        let mut totals = VersionTotals::default();
        let mut scenarios: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
        for row in &self.rows {
            let change = row.change();
            if change != VersionChange::Missing {
                let (gained, answers) = scenarios.entry(&row.answers[0].scenario).or_default();
                *gained += change.gain();
                *answers += 1.0;
            }
            totals.pairs += usize::from(change != VersionChange::Missing);
            totals.better += usize::from(change == VersionChange::Better);
            totals.worse += usize::from(change == VersionChange::Worse);
            let same = [VersionChange::Missing, VersionChange::Same].contains(&change);
            totals.changed += usize::from(!same);
            for (side, one) in totals.sides.iter_mut().zip(&row.answers) {
                side.add(one);
            }
        }
        if scenarios.len() >= FEWEST as usize && totals.better + totals.worse > 0 {
            let differences = scenarios.values().map(|(gained, answers)| gained / answers);
            totals.test = PairedTest::of_differences(&differences.collect::<Vec<_>>());
        }
        totals
    }
}

impl SideTotals {
    fn add(&mut self, one: &Scored) {
        if one.run.is_none() {
            return;
        }
        self.answers += 1;
        let right = Outcome::of_scored(one).and_then(Outcome::is_right);
        self.right += usize::from(right == Some(true));
        let consumed = &one.consumed;
        self.tokens += consumed.input_tokens.unwrap_or(0) + consumed.output_tokens.unwrap_or(0);
        match consumed.cost_usd {
            Some(usd) => self.usd += usd,
            None => self.unpriced += 1,
        }
    }
}

#[cfg(test)]
#[path = "versions_tests.rs"]
mod tests;
