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
            "no run fits; `nearmiss runs` lists those that there are, `nearmiss report FOLDER` reports recorded answers"
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
        return Err(finding("none of the runs can be counted".into()));
    }
    let words = truth::words(&sources, &stored, &store)?;
    let mut notes = vec![format!(
        "{} runs of the store. Truth: {words}.",
        stored.scored.len()
    )];
    notes.extend(notices);
    if !stored.scored.iter().any(|one| one.reference.is_some()) {
        notes.push(
            "There is no agreement with the built-in judge: no run of reference/geometry asks the same question; \
             `nearmiss report --batch ID` works it out for a batch."
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
            "in whose place another answer to the same question counts",
        ),
        (stored.other_tasks, "of tasks without a yes or no"),
        (
            stored.unknown_ways,
            "asked with a frame or techniques that this version does not know",
        ),
        (
            stored.other_leads,
            "at other leads than the first one of their batch, which are other questions; `nearmiss evaluate --resume \
             ID` tells about them",
        ),
        (
            stored.changed,
            "about changed scenes, which are other questions; `nearmiss evaluate --resume ID` tells about them",
        ),
    ];
    let left_out = left_out.into_iter().filter(|(count, _)| *count > 0);
    let mut notices: Vec<String> = left_out
        .map(|(count, what)| format!("left out: {count} {what}"))
        .collect();
    if stored.several_windows > 0 {
        notices.push(format!(
            "about {} scenarios the safety task was asked with several windows, and the answers to all are counted \
             together; --batch ID reports those of one",
            stored.several_windows
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
            "the truth of {} scenarios is unknown ({}{more}); --truth names labels or a folder with the scenarios",
            stored.unlabelled.len(),
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
