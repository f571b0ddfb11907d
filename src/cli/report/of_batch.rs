//! The report of a batch from `evaluate`: tables, also over chosen axes, and a page of its answers.

use std::collections::HashMap;
use std::sync::Arc;

use nearmiss_ask::prompts::Library;
use nearmiss_base::system::without_folders;
use nearmiss_formats::Entry;
use nearmiss_store::{BatchId, Filter, Item, ItemState, RunId, SplitPart, Store};
use nearmiss_study::evaluation::batch::{
    self, Answers, QuestionBuilder, SceneDescriptions, Spec, SpecError, TestSplit,
    UnjudgedScenario, with_judge_verdicts,
};
use nearmiss_study::evaluation::report::{
    AskedFacts, Axis, Measure, Pivot, PivotRequest, Report, ReportFigure, ReportSubject,
    SplitReport, TruthSubject, Varied,
};
use nearmiss_study::evaluation::{
    AnswerCase, AnswerPage, AnswerStatus, Lead, Provenance, RuleScore, leaks, note_on_score, rules,
    validate,
};
use nearmiss_workflow::answer_page;

use super::truth::{self, known_files};
use super::{AnyReport, ReportArguments, ReportFormat};
use crate::open::spelled;
use crate::output::LateProgress;
use crate::{Failure, Outcome, open, output};

/// A batch of `evaluate`: every question of it, also those without an answer, beside the truth that it was begun with;
/// of a batch with a split each part alone, and of a locked test split its progress.
pub fn batch_report(
    arguments: &ReportArguments,
    store: &Store,
    id: BatchId,
    format: ReportFormat,
) -> Result<AnyReport, Failure> {
    let Some(batch) = store.batch(id).map_err(Failure::input)? else {
        return Err(Failure::input(format!(
            "no batch {id}; `nearmiss evaluate list` lists batches"
        )));
    };
    let spec = Spec::from_json(&batch.spec).map_err(Failure::input)?;
    let test = TestSplit::open(store, &batch, arguments.unlock).map_err(Failure::input)?;
    let words = test
        .as_ref()
        .map(|test| {
            let progress = std::iter::once(test.summary());
            progress.chain(test.looks_note()).collect::<Vec<String>>()
        })
        .unwrap_or_default();
    for words in &words {
        output::say(&format!("nearmiss: {words}"));
    }
    let mut notes: Vec<String> = words.iter().map(|words| sentence(words)).collect();
    if let Some(parts) = &batch.shard {
        let words = format!(
            "only part {parts} of the batch is here; `nearmiss runs import` and `nearmiss runs import` add the others"
        );
        output::say(&format!("nearmiss: {words}"));
        notes.push(sentence(&words));
    }
    let part = |part| read(arguments, store, (id, &spec), (part, &notes));
    let parts = parts_shown(arguments, id, test.as_ref())?;
    // Where only one table or figure is made.
    let one_part = || match parts {
        [] => Ok(None),
        [one] => Ok(Some(*one)),
        _ => Err(Failure::input(format!(
            "{id} has a split, whose parts are not counted together: add --split dev or --split test"
        ))),
    };
    if let Some(request) = arguments.pivot.request() {
        let Part { answers, about, .. } = part(one_part()?)?;
        let table = pivot_report(store, &answers.cases(), request)?;
        return Ok(AnyReport::Pivot(Box::new(table.about(about))));
    }
    let page = |parts: &[&Part]| match format {
        ReportFormat::Html => {
            let cases: Vec<_> = parts.iter().flat_map(|part| part.answers.cases()).collect();
            page_of_answers(store, &cases, Vec::new())
        }
        _ => Ok(AnswerPage::default()),
    };
    let report = |part: Part| {
        let report = arguments.compared(&part.answers.plain, &spec.experiment.comparison())?;
        Ok::<Report, Failure>(
            report
                .about(part.about)
                .varied(Varied::from_answers(&part.answers))
                .tables(part.tables)
                .rules(part.rules)
                .leaks(leaks(part.items.iter().map(|item| &item.asked))),
        )
    };
    let Some(test) = test.filter(|_| arguments.figure.is_none()) else {
        let part = part(one_part()?)?;
        let page = page(&[&part])?;
        let report = report(part)?.answers(page);
        return Ok(AnyReport::Report(Box::new(report)));
    };
    let dev = store
        .split_progress(id, SplitPart::Dev)
        .map_err(Failure::input)?;
    let parts = parts.iter();
    let parts: Vec<(SplitPart, Part)> = parts
        .map(|one| Ok((*one, part(Some(*one))?)))
        .collect::<Result<_, Failure>>()?;
    // One page for all that may be shown.
    let answers = page(&parts.iter().map(|(_, part)| part).collect::<Vec<_>>())?;
    let provenance = {
        let items: Vec<Item> = parts
            .iter()
            .flat_map(|(_, part)| part.items.clone())
            .collect();
        let runs = parts
            .iter()
            .flat_map(|(_, part)| &part.answers.plain)
            .filter_map(|one| one.run)
            .collect();
        Provenance::of_batch(store, (id, &spec.portable(), &items), &runs)
    };
    let reports = parts
        .into_iter()
        .map(|(one, part)| Ok((one, report(part)?)));
    Ok(AnyReport::Split(Box::new(SplitReport {
        parts: reports.collect::<Result<_, Failure>>()?,
        answers,
        provenance: Some(provenance.map_err(Failure::input)?),
        progress: test.parts(dev).to_vec(),
        notes,
    })))
}

/// The parts of a split that are wanted and may be shown; none of a batch without a split.
fn parts_shown(
    arguments: &ReportArguments,
    id: BatchId,
    test: Option<&TestSplit>,
) -> Result<&'static [SplitPart], Failure> {
    match (test, arguments.split) {
        (None, None) => Ok(&[]),
        (None, Some(_)) => Err(Failure::input(format!("--split: {id} has no split"))),
        (Some(test), None) => Ok(test.visible_parts()),
        (Some(test), Some(SplitPart::Test)) if test.is_locked() => Err(Failure::input(format!(
            "--split test: {}; --unlock shows it and records the look",
            test.summary()
        ))),
        (Some(_), Some(SplitPart::Dev)) => Ok(&[SplitPart::Dev]),
        (Some(_), Some(SplitPart::Test)) => Ok(&[SplitPart::Test]),
    }
}

/// One part of a split, or a whole batch.
struct Part {
    answers: Answers,
    items: Vec<Item>,
    about: ReportSubject,
    tables: Vec<Pivot>,
    rules: Vec<RuleScore>,
}

/// The same words as a sentence.
fn sentence(words: &str) -> String {
    let mut letters = words.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    format!("{}{}.", first.unwrap_or_default(), letters.as_str())
}

/// Reads one part of a split, or a whole batch, with further notes.
fn read(
    arguments: &ReportArguments,
    store: &Store,
    (id, spec): (BatchId, &Spec),
    (part, more): (Option<SplitPart>, &[String]),
) -> Result<Part, Failure> {
    let mut answers = batch::answers_of_part(store, id, part).map_err(Failure::input)?;
    if let Some(cluster) = arguments.cluster {
        answers.cluster(cluster);
    }
    let mut items = store.items(id).map_err(Failure::input)?;
    let lead = spec.experiment.lead().map(Lead::stored);
    let asked = items.iter().map(|item| &item.asked);
    let rules = rules(asked, lead.as_deref(), part);
    items.retain(|item| part.is_none() || item.asked.split == part);
    let judged = judged(&mut answers, &items, spec);
    let unchecked = checked(store, &mut answers)?;
    let scored = &answers.plain;
    // Reports are read on other machines, too.
    let shown = spec.portable();
    let truth = output::visible(&shown.truth_summary());
    let mut notes = vec![format!(
        "Batch {id}{}: {}. Truth: {truth}.",
        part.map_or_else(String::new, |part| format!(", {} split", part.name())),
        output::counted(scored.len(), "question")
    )];
    notes.extend(more.iter().cloned());
    let measures = spec.experiment.measures();
    let ways = scored
        .iter()
        .map(|one| (&one.configuration, measures.as_ref()));
    notes.extend(note_on_score(
        ways.filter(|(way, _)| spec.truth().is_score(way.task)),
    ));
    let described = described(spec);
    notes.push(output::visible(&spec.request_summary(described.as_ref())));
    if answers.others > 0 {
        notes.push(format!(
            "{} more, about transformed scenes or at other leads, have their own tables.",
            answers.others
        ));
    }
    let unasked = scored
        .iter()
        .filter(|one| matches!(one.status, AnswerStatus::Unasked(_)))
        .count();
    let never = items
        .iter()
        .filter(|item| item.state == ItemState::Unaskable)
        .filter(|item| item.asked.transform.is_none())
        .count()
        .min(unasked);
    if never > 0 {
        let why = format!(
            "Of these, {never} cannot be asked, such as windows that begin before the recording; they are counted separately."
        );
        output::say(&format!("nearmiss: {why}"));
        notes.push(why);
    }
    if unasked > never {
        let unfinished = format!(
            "Of these, {} were not asked yet and are counted separately; `nearmiss evaluate {id}` resumes the batch.",
            unasked - never
        );
        output::say(&format!("nearmiss: {unfinished}"));
        notes.push(unfinished);
    }
    if arguments.declared.any() {
        notes.push("The comparisons were declared with this report, not with the batch.".into());
    } else if let Some(words) = spec.experiment.comparison().summary() {
        notes.push(output::visible(&format!(
            "Declared when the batch was begun: {words}."
        )));
    }
    notes.extend(judged.map(|words| output::visible(&words)));
    notes.extend(unchecked);
    let (tables, without) = tables(store, &answers, &spec.experiment.tables)?;
    notes.extend(without);
    let runs = scored.iter().filter_map(|one| one.run).collect();
    let provenance = Provenance::of_batch(store, (id, &shown, &items), &runs);
    let about = ReportSubject {
        provenance: Some(provenance.map_err(Failure::input)?),
        batch: Some(id.to_string()),
        title: spec.experiment.title.as_deref().map(output::visible),
        split: part.map(SplitPart::name),
        asked: Some(spec.asked(described.as_ref())),
        truth: TruthSubject {
            words: truth,
            sources: shown.truth().sources(),
        },
        notes,
    };
    Ok(Part {
        answers,
        items,
        about,
        tables,
        rules,
    })
}

/// The tables that were declared with the batch, and why some cannot be made.
fn tables(
    store: &Store,
    answers: &Answers,
    declared: &[PivotRequest],
) -> Result<(Vec<Pivot>, Vec<String>), Failure> {
    let (mut made, mut without) = (Vec::new(), Vec::new());
    if declared.is_empty() {
        return Ok((made, without));
    }
    let cases = answers.cases();
    let runs = store.origins().map_err(Failure::input)?;
    for request in declared {
        let asked = AskedFacts::new(&cases, &runs);
        match Pivot::new(&cases, asked, request.clone()) {
            Ok(table) => made.push(table),
            Err(why) => without.push(output::visible(&format!(
                "No table of {}: {why}.",
                request.summary()
            ))),
        }
    }
    Ok((made, without))
}

/// Counts the claims of answers that were not checked when they came; says how many still are not.
fn checked(store: &Store, answers: &mut Answers) -> Result<Option<String>, Failure> {
    let counts: HashMap<RunId, usize> = answers
        .plain
        .iter()
        .enumerate()
        .filter(|(_, one)| one.claims.known().is_none())
        .filter_map(|(place, one)| Some((one.run?, place)))
        .collect();
    if counts.is_empty() {
        return Ok(None);
    }
    let mut runs = store.outcomes(&Filter::default()).map_err(Failure::input)?;
    runs.retain(|run| counts.contains_key(&run.run));
    let unchecked = truth::complete_claims(store, &mut runs, Vec::new())?;
    for run in &runs {
        if let Some(one) = counts
            .get(&run.run)
            .and_then(|at| answers.plain.get_mut(*at))
        {
            one.claims = run.claims;
        }
    }
    Ok(unchecked)
}

/// What the templates say where the batch does not; `None` if they cannot be read or are no longer the same.
fn described(spec: &Spec) -> Option<SceneDescriptions> {
    let (folders, _) = open::configuration().ok()?;
    spec.described(&validate(Library::load(Some(&folders.prompts()))))
}

/// Asks the built-in judge about the scenarios, where it has said nothing yet; says what came of it, if anything did.
fn judged(answers: &mut Answers, items: &[Item], spec: &Spec) -> Option<String> {
    let found = with_judge_verdicts(answers, items, || batch_builder(spec));
    let verdicts = found.verdicts();
    let first = found.unjudged.first();
    if let (0, Some(first)) = (verdicts, first)
        && found.unjudged.iter().all(|one| one.why == first.why)
    {
        return Some(format!(
            "κ leaves out some answers, as the built-in judge could not be asked: {}.",
            first.why
        ));
    }
    if found.all.is_empty() {
        return None;
    }
    let asked = format!(
        "For κ, the built-in judge answered the questions of {}; the batch holds no verdict of it on them.",
        output::counted(verdicts, "answer")
    );
    Some(match unjudged_note(&found.unjudged) {
        None => asked,
        Some(words) => format!("{asked} It could not be asked about {words}."),
    })
}

/// Scenarios that are named each.
const MAX_LISTED: usize = 3;

fn unjudged_note(unjudged: &[UnjudgedScenario]) -> Option<String> {
    let named = unjudged.iter().take(MAX_LISTED);
    let named: Vec<String> = named
        .map(|one| format!("{} ({})", one.scenario, one.why))
        .collect();
    let more = if unjudged.len() > MAX_LISTED {
        ", …"
    } else {
        ""
    };
    let count = match unjudged.len() {
        0 => return None,
        1 => "1 scenario".to_string(),
        n => format!("{n} scenarios"),
    };
    Some(format!(
        "{count}, left out of κ: {}{more}",
        named.join("; ")
    ))
}

/// What makes the batch's windows again; nothing where they would be others now.
fn batch_builder(spec: &Spec) -> Result<QuestionBuilder, String> {
    let words = |failure: Failure| without_folders(&failure.message);
    let (folders, _) = open::configuration().map_err(words)?;
    let library = validate(Library::load(Some(&folders.prompts())));
    let thresholds = open::user_thresholds(&folders).map_err(words)?;
    let words = |error: SpecError| without_folders(&error.to_string());
    spec.builder_again(&library, Arc::new(thresholds))
        .map_err(words)
}

/// The page of these answers; their scenarios are looked for in `files`, in the batches and among the bundled ones.
pub fn page_of_answers(
    store: &Store,
    cases: &[AnswerCase<'_>],
    mut files: Vec<Entry>,
) -> Result<AnswerPage, Failure> {
    files.extend(known_files(store)?);
    let progress = LateProgress::new("scenes");
    let shown = |_, of| progress.step(of);
    let page = answer_page(store, cases, &files, &shown).map_err(Failure::input)?;
    let left_out = page.pictures_left_out();
    if left_out > 0 {
        output::say(&format!(
            "nearmiss: the page has no pictures of {}: they would make it too large",
            output::counted(left_out, "question")
        ));
    }
    let left_out = page.sent_left_out();
    if left_out > 0 {
        output::say(&format!(
            "nearmiss: the page has no {} that models were sent: they would make it too large; `runs picture` writes one",
            output::counted(left_out, "picture")
        ));
    }
    Ok(page)
}

/// Options of a table over axes.
#[derive(Debug, clap::Args)]
pub struct PivotOptions {
    /// Print one table with this axis as rows; cells show a 95 % interval and the number of answers
    ///
    /// Axes: model, techniques, frame, task, template, lead, transform, effort, temperature, form, stride, seed, tools,
    /// sample, country.
    #[arg(long, value_name = "AXIS", conflicts_with = "paper")]
    rows: Option<Axis>,
    /// Axis of the columns.
    #[arg(long, value_name = "AXIS", conflicts_with = "paper", value_parser = spelled::<Axis>)]
    columns: Option<String>,
    /// Measure in the cells: right_of_all, f1, precision, recall, specificity, accuracy, naming_recall,
    /// naming_precision, seconds_median or cost_usd [default: right_of_all].
    #[arg(long, value_name = "MEASURE")]
    measure: Option<Measure>,
    /// Compare every value of the rows with this one: paired differences in the share of correct answers, with
    /// intervals and Holm-adjusted p-values.
    #[arg(long, value_name = "VALUE")]
    against: Option<String>,
}

impl PivotOptions {
    /// What is measured.
    pub fn measure(&self) -> Measure {
        self.measure.unwrap_or_default()
    }

    /// The table that is wanted, where one is.
    pub fn request(&self) -> Option<PivotRequest> {
        let rows = self.rows?;
        Some(PivotRequest {
            rows,
            columns: self.columns.as_ref().and_then(|axis| axis.parse().ok()),
            measure: self.measure(),
            against: self.against.clone(),
        })
    }

    /// Options that do not fit together.
    pub fn check(&self, arguments: &ReportArguments) -> Outcome {
        let wrong = |words: &str| Err(Failure::input(words));
        let Some(request) = self.request() else {
            let named = [
                (self.columns.is_some(), "--columns"),
                (
                    self.measure.is_some() && arguments.figure.is_none(),
                    "--measure",
                ),
                (self.against.is_some(), "--against"),
            ];
            return match named.into_iter().find(|(is_named, _)| *is_named) {
                Some((_, option)) => wrong(&format!("{option} needs --rows AXIS")),
                None => Ok(()),
            };
        };
        if let Some(figure) = arguments.figure.filter(|one| *one != ReportFigure::Bars) {
            return Err(Failure::input(format!(
                "--rows: only bars are drawn over axes, not {}",
                figure.name()
            )));
        }
        if let Err((part, words)) = request.check() {
            return wrong(&format!("--{part}: {words}"));
        }
        if arguments.declared.any() || arguments.pairs.is_some() {
            return wrong(
                "--baseline, --compare and --pairs belong to the whole report; --against VALUE compares the rows of --rows",
            );
        }
        Ok(())
    }
}

/// The table of these answers, with when and whom they were asked from the store.
pub fn pivot_report(
    store: &Store,
    cases: &[AnswerCase<'_>],
    request: PivotRequest,
) -> Result<Pivot, Failure> {
    let runs = store.origins().map_err(Failure::input)?;
    let asked = AskedFacts::new(cases, &runs);
    Pivot::new(cases, asked, request).map_err(Failure::input)
}
