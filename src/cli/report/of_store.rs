//! The report of stored runs, or of a folder of recorded answers beside the paper's tables.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use nearmiss_scene::verdict::{self, ParsedAnswer};
use nearmiss_store::{Filter, Outcome as Run, Store};
use nearmiss_study::evaluation::report::{
    self, AskedFacts, Comparison, Pivot, ReportSubject, Stored, TruthSubject,
};
use nearmiss_study::evaluation::{
    AnswerCase, AnswerPage, Loss, Problem, Provenance, Scored, note_on_score, tool_rounds,
    with_token_probability,
};
use nearmiss_study::paper::{self, Paper};

use super::{AnyReport, ReportArguments, ReportFormat, of_batch, truth};
use crate::filters::{LAST, last_batch, store_to_read};
use crate::output::Progress;
use crate::{Failure, output};

/// The report of the runs that the filters choose, for a format: tables for programs have no place for notes.
pub fn store_report(
    arguments: &ReportArguments,
    format: ReportFormat,
) -> Result<AnyReport, Failure> {
    let has_notes = !matches!(
        format,
        ReportFormat::Csv | ReportFormat::Parquet | ReportFormat::Arrow | ReportFormat::Json
    );
    let sources = if arguments.truth.is_empty() {
        [truth::BATCH, truth::AUTO].map(PathBuf::from).to_vec()
    } else {
        arguments.truth.clone()
    };
    let filter = arguments.filters.filter()?;
    let last = match filter.batch.as_deref() {
        Some(LAST) => {
            let store = store_to_read()?;
            Some(last_batch(&store)?)
        }
        _ => None,
    };
    let named = filter.batch.as_deref().and_then(|id| id.parse().ok());
    if let Some(id) = last.or(named) {
        let alone = Filter {
            batch: filter.batch.clone(),
            ..Filter::default()
        };
        if filter != alone || !arguments.truth.is_empty() || arguments.reread {
            return Err(Failure::input(
                "--batch reports a whole batch with its own truth: remove --truth, --reread and filters such as --task; `nearmiss evaluate ID --truth …` changes its truth",
            ));
        }
        let store = store_to_read()?;
        return of_batch::batch_report(arguments, &store, id, format);
    }
    if arguments.unlock {
        return Err(Failure::input(
            "--unlock shows the test split of one batch: add --batch ID",
        ));
    }
    if arguments.split.is_some() {
        return Err(Failure::input(
            "--split chooses a part of one batch: add --batch ID",
        ));
    }
    let store = store_to_read()?;
    let mut runs = store.outcomes(&filter).map_err(Failure::input)?;
    if runs.is_empty() {
        return Err(Failure::finding(
            "no matching runs; `nearmiss runs list` lists all, `nearmiss report FOLDER` reports recorded answers",
        ));
    }
    if arguments.reread {
        reread(&store, &mut runs)?;
    }
    let files = truth::claimed_files(&sources);
    let unchecked = truth::complete_claims(&store, &mut runs, files.clone())?;
    let truth = truth::truth(&sources, &store, &runs)?;
    let asides = store.asides().map_err(Failure::input)?;
    let mut stored = report::stored(&runs, &truth, &asides);
    let cluster = arguments.cluster.unwrap_or_default();
    stored
        .scored
        .iter_mut()
        .for_each(|one| one.cluster = cluster);
    let notices = notices(&stored);
    // A report for people has them among its notes.
    if stored.scored.is_empty() || !has_notes {
        for notice in &notices {
            output::say(&format!("nearmiss: {notice}"));
        }
    }
    if stored.scored.is_empty() {
        return Err(Failure::finding("none of the runs can be scored"));
    }
    let words = truth::truth_description(&sources, &stored, &store)?;
    let mut notes = vec![format!(
        "{} of the store. Truth: {words}.",
        output::counted(stored.scored.len(), "run")
    )];
    notes.extend(notices);
    notes.extend(unchecked);
    let by_score = runs.iter().filter(|run| truth.is_score(run));
    let by_score: HashMap<_, _> = by_score
        .map(|run| (run.run, truth.asked_as(run.run)))
        .collect();
    notes.extend(note_on_score(stored.scored.iter().filter_map(|one| {
        let asked = by_score.get(&one.run?)?;
        Some((&one.configuration, asked.measures.as_ref()))
    })));
    if !stored.scored.iter().any(|one| one.reference.is_some()) {
        notes.push(
            "No agreement with the built-in judge: no run of reference/geometry has the same question; \
             `nearmiss report --batch ID` computes it for a batch."
                .into(),
        );
    }
    let counted = stored.scored.iter().filter_map(|one| one.run).collect();
    let provenance = Provenance::of_runs(&store, &counted).map_err(Failure::input)?;
    let about = ReportSubject {
        provenance: Some(provenance),
        truth: TruthSubject {
            words,
            sources: sources.iter().map(|s| s.display().to_string()).collect(),
        },
        notes,
        ..ReportSubject::default()
    };
    let cases = AnswerCase::all(&stored.scored);
    if let Some(request) = arguments.pivot.request() {
        return Ok(AnyReport::Pivot(Box::new(
            of_batch::pivot_report(&store, &cases, request)?.about(about),
        )));
    }
    let page = match format {
        ReportFormat::Html => of_batch::page_of_answers(&store, &cases, files)?,
        _ => AnswerPage::default(),
    };
    let report = arguments.compared(&stored.scored, &Comparison::default())?;
    Ok(AnyReport::Report(Box::new(
        report.about(about).answers(page),
    )))
}

/// Describes runs left out of the report, or without a ground truth.
fn notices(stored: &Stored) -> Vec<String> {
    let left_out = stored.left_out().into_iter();
    let mut notices: Vec<String> = left_out
        .map(|(words, shown)| match shown {
            Some(shown) => format!("skipped: {words}; {shown}"),
            None => format!("skipped: {words}"),
        })
        .collect();
    if stored.unfinished > 0 {
        notices.push(format!(
            "{} running, cancelled or interrupted; counted as not asked",
            output::counted(stored.unfinished as usize, "question")
        ));
    }
    if stored.several_windows > 0 {
        notices.push(format!(
            "{}: several windows of the safety task are counted together; --batch ID reports one batch",
            output::counted(stored.several_windows as usize, "scenario")
        ));
    }
    if !stored.unlabelled.is_empty() {
        let some: Vec<&str> = stored
            .unlabelled
            .iter()
            .take(3)
            .map(String::as_str)
            .collect();
        let more = if stored.unlabelled.len() > some.len() {
            ", …"
        } else {
            ""
        };
        notices.push(format!(
            "no ground truth for {} about {} ({}{more}); --truth takes labels or a folder of scenarios",
            output::counted(stored.without_truth as usize, "answer"),
            output::counted(stored.unlabelled.len(), "scenario"),
            some.join(", ")
        ));
    }
    notices
}

/// Reads the answers again, as this version reads them.
fn reread(store: &Store, runs: &mut [Run]) -> Result<(), Failure> {
    let progress = Progress::new(runs.len(), "answers", true);
    for run in runs.iter_mut() {
        progress.step();
        let Some(stored) = store.run(run.run).map_err(Failure::input)? else {
            continue;
        };
        let rounds = tool_rounds::stored(stored.tool_rounds.as_deref());
        let answer = tool_rounds::last_turn(&rounds, &stored.answer, |turn| &turn.text);
        // A model that puts everything into its reasoning has still answered.
        let whole = if answer.trim().is_empty() {
            tool_rounds::last_turn(&rounds, &stored.reasoning, |turn| &turn.thought)
        } else {
            answer
        };
        if whole.trim().is_empty() {
            continue;
        }
        match verdict::read(run.task, whole) {
            Ok(mut reading) => {
                if let ParsedAnswer::Verdict(verdict) = reading.said {
                    let kept = with_token_probability(verdict, run.verdict.as_deref());
                    reading.said = kept.into();
                }
                let json = serde_json::to_string(&reading.said).map_err(Failure::input)?;
                run.verdict = Some(json);
            }
            Err(why) => {
                run.verdict = None;
                run.reading = Some(why.to_string());
            }
        }
    }
    Ok(())
}

/// The recorded answers beside the paper's tables, and how many files could not be read.
pub fn paper_report(folder: &Path) -> Result<(AnyReport, usize), Failure> {
    let (scored, about, lost) = read(folder)?;
    let paper = Paper::from_scored(&scored).map_err(Failure::input)?;
    Ok((AnyReport::Paper(Box::new(paper.about(about))), lost))
}

/// The recorded answers alone, and how many files could not be read.
pub fn folder_report(
    arguments: &ReportArguments,
    folder: &Path,
    format: ReportFormat,
) -> Result<(AnyReport, usize), Failure> {
    let (mut scored, about, lost) = read(folder)?;
    let cluster = arguments.cluster.unwrap_or_default();
    scored.iter_mut().for_each(|one| one.cluster = cluster);
    if let Some(request) = arguments.pivot.request() {
        let cases = AnswerCase::all(&scored);
        let pivot = Pivot::new(&cases, AskedFacts::default(), request)
            .map_err(Failure::input)?
            .about(about);
        return Ok((AnyReport::Pivot(Box::new(pivot)), lost));
    }
    let page = match format {
        ReportFormat::Html => AnswerPage::new(&AnswerCase::all(&scored)),
        _ => AnswerPage::default(),
    };
    let report = arguments
        .compared(&scored, &Comparison::default())?
        .about(about)
        .answers(page);
    Ok((AnyReport::Report(Box::new(report)), lost))
}

/// Problems that are named one by one.
const MAX_PROBLEMS_LISTED: usize = 20;

/// Recorded answers, what they are in words, and how many files could not be read.
fn read(folder: &Path) -> Result<(Vec<Scored>, ReportSubject, usize), Failure> {
    if !paper::is_laid_out(folder) {
        let what = if folder.is_dir() {
            "it has no recorded answers"
        } else {
            "no such folder"
        };
        return Err(Failure::input(format!(
            "{}: {what}; a folder of recorded answers has `Results/output_validation` or \
             `Results/output_validation_normal`, as the repository of \"From Words to Collisions\" does",
            folder.display()
        )));
    }
    let (scored, problems) = paper::scored(folder);
    let lost: Vec<&Problem> = problems.iter().filter(|p| p.loss == Loss::Unread).collect();
    lost.iter()
        .take(MAX_PROBLEMS_LISTED)
        .for_each(|p| output::say(&format!("nearmiss: {p}")));
    let answers = scored
        .iter()
        .filter(|s| s.configuration.frame.is_some())
        .count();
    if answers == 0 {
        return Err(Failure::input(format!(
            "{}: no recorded answers to the collision or safety task",
            folder.display()
        )));
    }
    let judged = scored.iter().any(|s| s.configuration.frame.is_none());
    let mut unlabelled: Vec<&str> = scored
        .iter()
        .filter(|s| s.truth.is_none())
        .map(|s| s.scenario.as_str())
        .collect();
    unlabelled.sort_unstable();
    unlabelled.dedup();
    let without = if unlabelled.is_empty() {
        String::new()
    } else {
        format!(
            " Without an annotation, so their answers are neither right nor wrong: {}.",
            unlabelled.join(", ")
        )
    };
    let note = format!(
        "{answers} recorded answers, compared with the annotations{}. The models are those of the paper's scripts; none was asked now.",
        if judged {
            " and with the built-in judge (reference/geometry), which read the scenarios"
        } else {
            "; the scenarios are missing, so the built-in judge could not be asked"
        }
    ) + &without;
    let about = ReportSubject {
        truth: TruthSubject {
            words: "the annotations of the folder".into(),
            sources: vec![folder.display().to_string()],
        },
        notes: vec![note],
        provenance: Some(Provenance::of_program()),
        ..ReportSubject::default()
    };
    Ok((scored, about, lost.len()))
}
