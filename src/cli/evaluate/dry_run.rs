//! Prints a dry run: a batch's questions, their estimated consumption, and what their surface gives away, before anything
//! is sent.

use schemars::JsonSchema;
use serde::Serialize;

use super::context::say_each;
use super::{number, some};
use crate::output::Progress;
use crate::{Failure, Outcome, output};
use nearmiss_drive::planner::Cancel;
use nearmiss_record::{columns, rows, text_table};
use nearmiss_store::{NewItem, Store};
use nearmiss_study::evaluation::batch::QuestionLine;
use nearmiss_study::evaluation::{Judges, Leak, SURFACE, leaks};
use nearmiss_workflow::batch::{BatchPlan, DryRun, DryRunEvent, DryRunLine, is_enough};

/// Makes the questions of a batch, and says what is doubtful and which scenarios are left out.
pub fn make(plan: &BatchPlan, judges: &Judges, store: &Store) -> Result<DryRun, Failure> {
    let progress = Progress::new(plan.scenarios(), "scenarios described", true);
    let mut shown = 0;
    let dry_run = plan
        .dry_run(judges, store, &Cancel::default(), &mut |event| {
            let DryRunEvent::Described { done, .. } = event;
            (shown..done).for_each(|_| progress.step());
            shown = done;
        })
        // Nothing cancels it: Ctrl-C ends the program.
        .map_err(Failure::input)?
        .unwrap_or_default();
    drop(progress);
    say_each(&dry_run.doubts);
    if !dry_run.unlabelled.is_empty() {
        output::say(&format!(
            "nearmiss: skipped, no ground truth: {}",
            some(&dry_run.unlabelled)
        ));
    }
    Ok(dry_run)
}

/// The same as [`write`] in one line.
pub fn line(dry_run: &DryRun) -> String {
    let estimate = &dry_run.estimate;
    let mut words = match estimate.requests {
        0 => "no request to a model".to_string(),
        requests => format!(
            "{}, about {} tokens, {}",
            number(count(requests), "request"),
            estimate.tokens,
            estimate.price()
        ),
    };
    if estimate.free > 0 {
        words.push_str(&format!("; {} by the built-in judge", estimate.free));
    }
    if estimate.stored > 0 {
        let stored = number(count(estimate.stored), "answer");
        let are = if estimate.stored == 1 { "is" } else { "are" };
        words.push_str(&format!("; {stored} {are} in the store"));
    }
    if estimate.unaskable > 0 {
        let why = estimate.why.first().map_or("", |(why, _)| why.as_str());
        words.push_str(&format!("; {} cannot be asked: {why}", estimate.unaskable));
    }
    words
}

/// What would be asked, for programs.
#[derive(Serialize, JsonSchema)]
pub struct DryRunDocument<'a> {
    /// Questions that are to be asked.
    questions: u64,
    /// Requests to send.
    requests: u64,
    /// Questions with the request of another one, which is sent once.
    repeated: u64,
    /// Questions for the built-in judge.
    built_in: u64,
    /// Answers in the store.
    stored: u64,
    unaskable: u64,
    /// Why questions cannot be asked: why and questions.
    why: Vec<Unaskable<'a>>,
    /// Scenarios without ground truth.
    left_out: &'a [String],
    tokens: u64,
    most_usd: Option<f64>,
    /// Budget in US dollars.
    budget: Option<f64>,
    /// Whether the budget is enough; null if that is unknown.
    within_budget: Option<bool>,
    /// Requests without a limit of tokens.
    unbounded: u64,
    /// Requests without a known price.
    unpriced: u64,
    /// Models that cannot be asked: model and why.
    refused: Vec<Refused<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Unaskable<'a> {
    why: &'a str,
    questions: u64,
}

#[derive(Serialize, JsonSchema)]
struct Refused<'a> {
    model: &'a str,
    why: &'a str,
}

/// Writes what would be asked; `refused` is why models cannot be asked as things stand.
/// `budget` is the most that the run may cost, US dollars.
pub fn write(
    dry_run: &DryRun,
    refused: &[(String, String)],
    budget: Option<f64>,
    as_json: bool,
) -> Outcome {
    let estimate = &dry_run.estimate;
    if as_json {
        let unaskable = estimate.why.iter().map(|(why, questions)| Unaskable {
            why,
            questions: *questions,
        });
        let refused = refused.iter().map(|(model, why)| Refused { model, why });
        return output::document(&DryRunDocument {
            questions: estimate.questions(),
            requests: estimate.requests,
            repeated: estimate.repeated,
            built_in: estimate.free,
            stored: estimate.stored,
            unaskable: estimate.unaskable,
            why: unaskable.collect(),
            left_out: &dry_run.unlabelled,
            tokens: estimate.tokens,
            most_usd: estimate.most_usd(),
            budget,
            within_budget: budget.and_then(|usd| is_enough(usd, estimate)),
            unbounded: estimate.unbounded,
            unpriced: estimate.unpriced,
            refused: refused.collect(),
        });
    }
    let mut text = String::new();
    for line in dry_run.lines(refused, budget) {
        text.push_str(&match line {
            DryRunLine::Value(name, value) => format!("{name:<COLUMN$}{value}\n"),
            DryRunLine::Note(words) => format!("{:COLUMN$}{words}\n", ""),
            DryRunLine::Reason(words) => format!("  {words}\n"),
        });
    }
    output::text(&output::visible(&text))
}

/// Columns of names.
const COLUMN: usize = 17;

fn count(number: u64) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}

/// Writes every question as a JSON line.
pub fn write_questions(items: &[NewItem]) -> Outcome {
    let lines = QuestionLine::of_items(items);
    let lines: Result<String, Failure> = lines.iter().map(output::json_line).collect();
    output::text(&lines?)
}

/// What the questions give away, for programs.
#[derive(Serialize, JsonSchema)]
pub struct LeaksDocument {
    /// Areas under the ROC curve by task, frame, techniques and lead.
    leaks: Vec<Leak>,
}

/// Writes how well each part of the surface tells dangerous from safe windows.
pub fn write_leaks(items: &[NewItem], json: bool) -> Outcome {
    let leaks = leaks(items);
    if json {
        return output::document(&LeaksDocument { leaks });
    }
    let mut text = String::from(
        "areas under the ROC curve: 0.5 tells nothing, 0 and 1 tell dangerous from safe without fail; all, by regression: a\n\
         logistic regression on all five, tested on scenarios that it was not fitted to; below 0.5 it has learned only noise\n",
    );
    for (name, words) in SURFACE {
        text += &format!("{name}: {words}\n");
    }
    let rows = rows(&leaks).map_err(Failure::input)?;
    output::text(&format!(
        "{text}\n{}",
        text_table(&columns::<Leak>(), &rows)
    ))
}
