//! The report of stored runs.

use std::path::PathBuf;

use super::{AnyReport, ReportArguments, finding, of_batch, truth};
use crate::cli::filters::store_to_read;
use crate::cli::progress::Progress;
use crate::cli::{Failure, output};
use crate::evaluation::report::{self, Report, ReportSubject, Stored};
use crate::store::{Filter, Outcome as Run, Store};
use crate::verdict;

/// The report of the runs that the filters choose.
pub fn made(arguments: &ReportArguments) -> Result<AnyReport, Failure> {
    let sources = match arguments.truth.is_empty() {
        true => [truth::BATCH, truth::AUTO].map(PathBuf::from).to_vec(),
        false => arguments.truth.clone(),
    };
    let filter = arguments.filters.filter(None);
    let last = match filter.batch.as_deref() {
        Some("last") => store_to_read()?.last_batch().map_err(Failure::input)?,
        _ => None,
    };
    let named = filter.batch.as_deref().and_then(|id| id.parse().ok());
    if let Some(id) = last.map(|batch| batch.id).or(named) {
        let alone = Filter {
            batch: filter.batch.clone(),
            ..Filter::default()
        };
        if filter != alone || !arguments.truth.is_empty() || arguments.reread {
            return Err(Failure::input(
                "--batch: a batch is reported as a whole, beside its own truth, and its answers are \
                 always read anew; `nearmiss evaluate --resume ID --truth …` gives it another truth",
            ));
        }
        let store = store_to_read()?;
        return of_batch::made(&store, id);
    }
    let store = store_to_read()?;
    let mut runs = store.outcomes(&filter).map_err(Failure::input)?;
    if runs.is_empty() {
        return Err(finding(
            "no matching runs; `nearmiss runs` lists all, `nearmiss report FOLDER` reports recorded answers"
                .into(),
        ));
    }
    if arguments.reread {
        reread(&store, &mut runs)?;
    }
    let truth = truth::truth(&sources, &store, &runs)?;
    let asides = store.asides().map_err(Failure::input)?;
    let stored = report::stored(&runs, &truth, &asides);
    let notices = notices(&stored);
    for notice in &notices {
        output::say(&format!("nearmiss: {notice}"));
    }
    if stored.scored.is_empty() {
        return Err(finding("none of the runs can be scored".into()));
    }
    let words = truth::words(&sources, &stored, &store)?;
    let mut notes = vec![format!(
        "{} of the store. Truth: {words}.",
        output::counted(stored.scored.len(), "run")
    )];
    notes.extend(notices);
    if !stored.scored.iter().any(|one| one.reference.is_some()) {
        notes.push(
            "No agreement with the built-in judge: no run of reference/geometry has the same question; \
             `nearmiss report --batch ID` computes it for a batch."
                .into(),
        );
    }
    let about = ReportSubject {
        truth: words,
        sources: sources.iter().map(|s| s.display().to_string()).collect(),
        notes,
        ..ReportSubject::default()
    };
    Ok(AnyReport::Report(
        Report::from_scored(&stored.scored).about(about),
    ))
}

/// Describes runs left out of the report, or without a ground truth.
fn notices(stored: &Stored) -> Vec<String> {
    let left_out = [
        (stored.unfinished, "running, cancelled or interrupted"),
        (
            stored.asked_again,
            "repeats of a question; its newest answer counts",
        ),
        (stored.other_tasks, "of tasks without a yes or no"),
        (
            stored.unknown_ways,
            "with a frame or techniques unknown to this version",
        ),
        (
            stored.other_leads,
            "at further leads of their batch; `nearmiss evaluate --resume ID` shows them",
        ),
        (
            stored.changed,
            "about transformed scenes; `nearmiss evaluate --resume ID` shows them",
        ),
    ];
    let left_out = left_out.into_iter().filter(|(count, _)| *count > 0);
    let mut notices: Vec<String> = left_out
        .map(|(count, what)| format!("skipped: {count} {what}"))
        .collect();
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
        let more = match stored.unlabelled.len() > some.len() {
            true => ", …",
            false => "",
        };
        notices.push(format!(
            "no ground truth for {} ({}{more}); add labels or a folder of scenarios with --truth",
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
        let Some((answer, reasoning)) = store.texts(run.run).map_err(Failure::input)? else {
            continue;
        };
        // A model that puts everything into its reasoning has still answered.
        let whole = if answer.trim().is_empty() {
            reasoning
        } else {
            answer
        };
        if whole.trim().is_empty() {
            continue;
        }
        match verdict::read(run.task, &whole) {
            Ok(reading) => {
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
