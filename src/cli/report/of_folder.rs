//! The report of a folder of recorded answers, alone or beside the paper's tables.

use std::path::Path;

use super::{AnyReport, Format, ReportArguments};
use crate::{Failure, output};
use nearmiss_study::evaluation::report::{
    AskedFacts, Comparison, Pivot, ReportSubject, TruthSubject,
};
use nearmiss_study::evaluation::{AnswerCase, AnswerPage, Loss, Problem, Provenance, Scored};
use nearmiss_study::paper::{self, Paper};

/// The recorded answers beside the paper's tables, and how many files could not be read.
pub fn paper(folder: &Path) -> Result<(AnyReport, usize), Failure> {
    let (scored, about, lost) = read(folder)?;
    let paper = Paper::from_scored(&scored).map_err(Failure::input)?;
    Ok((AnyReport::Paper(Box::new(paper.about(about))), lost))
}

/// The recorded answers alone, and how many files could not be read.
pub fn made(
    arguments: &ReportArguments,
    folder: &Path,
    format: Format,
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
        Format::Html => AnswerPage::new(&AnswerCase::all(&scored)),
        _ => AnswerPage::default(),
    };
    let report = arguments
        .compared(&scored, &Comparison::default())?
        .about(about)
        .answers(page);
    Ok((AnyReport::Report(Box::new(report)), lost))
}

/// Problems that are named one by one.
const NAMED: usize = 20;

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
        .take(NAMED)
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
