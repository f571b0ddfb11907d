//! Prints a dry run: a batch's questions and their estimated consumption, before anything is sent.

use serde_json::json;

use super::truth::say_each;
use crate::cli::progress::Progress;
use crate::cli::{Failure, Outcome, output};
use crate::evaluation::Judges;
use crate::evaluation::batch::Estimate;
use crate::planner::Cancel;
use crate::store::Store;
use crate::workflow::batch::{BatchPlan, DryRun, DryRunEvent};

/// Makes the questions of a batch, and says what is doubtful and which scenarios are left out.
pub fn make(plan: &BatchPlan, judges: &Judges, store: &Store) -> Result<DryRun, Failure> {
    let progress = Progress::new(plan.scenarios(), "scenarios described", true);
    let mut shown = 0;
    let dry_run = plan.dry_run(judges, store, &Cancel::default(), &mut |event| {
        let DryRunEvent::Described { done, .. } = event;
        (shown..done).for_each(|_| progress.step());
        shown = done;
    });
    // Nothing cancels it: Ctrl-C ends the program.
    let dry_run = dry_run.map_err(Failure::input)?.unwrap_or_default();
    drop(progress);
    say_each(&dry_run.doubts);
    if !dry_run.unlabelled.is_empty() {
        output::say(&format!(
            "nearmiss: skipped, no ground truth: {}",
            super::some(&dry_run.unlabelled)
        ));
    }
    Ok(dry_run)
}

/// The same as [`write`] in one line.
pub fn line(dry_run: &DryRun) -> String {
    let estimate = &dry_run.estimate;
    let mut words = format!(
        "{}, about {} tokens, {}",
        super::number(count(estimate.requests), "request"),
        estimate.tokens,
        estimate.price()
    );
    if estimate.free > 0 {
        words.push_str(&format!("; {} by the built-in judge", estimate.free));
    }
    if estimate.stored > 0 {
        let stored = super::number(count(estimate.stored), "answer");
        let are = if estimate.stored == 1 { "is" } else { "are" };
        words.push_str(&format!("; {stored} {are} in the store"));
    }
    if estimate.unaskable > 0 {
        let why = estimate.why.first().map_or("", |(why, _)| why.as_str());
        words.push_str(&format!("; {} cannot be asked: {why}", estimate.unaskable));
    }
    words
}

/// Writes what would be asked; `refused` is why models cannot be asked as things stand.
/// `budget` is the most that the run may cost, US dollars.
pub fn write(
    dry_run: &DryRun,
    refused: &[(String, String)],
    budget: Option<f64>,
    json: bool,
) -> Outcome {
    let estimate = &dry_run.estimate;
    let budget = budget.map(|usd| (usd, within(estimate, usd)));
    if json {
        let unaskable = estimate.why.iter();
        let unaskable = unaskable.map(|(why, count)| json!({ "why": why, "questions": count }));
        let refused = refused.iter();
        let refused = refused.map(|(model, why)| json!({ "model": model, "why": why }));
        return output::json(&json!({
            "questions": dry_run.items.len(),
            "requests": estimate.requests,
            "built_in": estimate.free,
            "stored": estimate.stored,
            "unaskable": estimate.unaskable,
            "why": unaskable.collect::<Vec<_>>(),
            "left_out": dry_run.unlabelled,
            "tokens": estimate.tokens,
            "most_usd": estimate.usd,
            "usd": estimate.usd,
            "budget": budget.map(|(usd, _)| usd),
            "within_budget": budget.and_then(|(_, within)| within),
            "unbounded": estimate.unbounded,
            "unpriced": estimate.unpriced,
            "refused": refused.collect::<Vec<_>>(),
        }));
    }
    let mut text = format!(
        "questions        {}\nrequests         {}\nbuilt-in judge   {}\nin the store     {}\ncannot be asked  {}\n",
        dry_run.items.len(),
        estimate.requests,
        estimate.free,
        estimate.stored,
        estimate.unaskable
    );
    for (why, count) in &estimate.why {
        text.push_str(&format!("  {count} × {why}\n"));
    }
    text.push_str(&format!(
        "tokens           {} (estimated, without the answers)\nprice            {}\n",
        estimate.tokens,
        estimate.price()
    ));
    if let Some((usd, within)) = budget {
        let words = match within {
            Some(true) => "enough for all",
            Some(false) => "too little: questions that could exceed it stay open for --resume",
            None => "may not be enough: some prices or limits are unknown",
        };
        text.push_str(&format!("budget           {usd} USD, {words}\n"));
    }
    for (model, why) in refused {
        text.push_str(&format!("refused          {model}: {why}\n"));
    }
    output::text(&output::visible(&text))
}

/// Whether a budget is enough for everything; `None` if that cost is unknown.
fn within(estimate: &Estimate, usd: f64) -> Option<bool> {
    let known = estimate.unbounded == 0 && estimate.unpriced == 0;
    match estimate.usd > usd {
        true => Some(false),
        false => known.then_some(true),
    }
}

fn count(number: u64) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}
