//! `--resume`: resumes a batch, and warns if its ground truth differs.

use super::batch::carry_out;
use super::context::BatchContext;
use super::drawing::planned;
use super::options::Resumed;
use super::truth::truth_source;
use super::{Evaluate, number, some};
use crate::{Failure, Outcome, output};
use nearmiss_study::evaluation::batch::TruthSource;
use nearmiss_workflow::batch::{Relabelling, ResumeRequest};

/// Resumes a batch.
pub fn run(arguments: &Evaluate, which: Resumed) -> Outcome {
    let options = &arguments.batch;
    let context = BatchContext::new()?;
    let request = ResumeRequest {
        batch: match which {
            Resumed::Last => None,
            Resumed::Batch(id) => Some(id),
        },
        selection: options.selection(),
        more: options.more(),
        truth: truth_source(&arguments.truth)?,
        dry_run: options.asks_nothing(),
    };
    let (store, library, thresholds) = (&context.store, &context.library, &context.thresholds);
    let mut plan =
        planned(|cancel, on_event| request.plan(store, library, thresholds, cancel, on_event))?;
    if let Some(relabelling) = &plan.relabelling {
        say_truth(relabelling, &plan.spec.truth, options.asks_nothing());
    }
    carry_out(arguments, &context, &mut plan)?;
    let unlabelled = plan
        .relabelling
        .map_or(0, |relabelling| relabelling.unlabelled.len());
    match unlabelled {
        _ if options.dry_run => Ok(()),
        0 => Ok(()),
        count => Err(Failure::finding(format!(
            "{} without a label",
            number(count, "scenario")
        ))),
    }
}

/// Says that the truth is another one, and about which scenarios it says nothing.
fn say_truth(relabelling: &Relabelling, source: &TruthSource, dry_run: bool) {
    let Relabelling {
        batch,
        before,
        unlabelled,
    } = relabelling;
    if source != before {
        let (before, now) = (before.words(), source.words());
        let would = if dry_run {
            "would be"
        } else {
            "is from now on"
        };
        output::say(&output::visible(&format!(
            "nearmiss: {batch}: the truth {would}: {now}; it was: {before}"
        )));
    }
    if !unlabelled.is_empty() {
        output::say(&output::visible(&format!(
            "nearmiss: {batch}: no label for {}: {}; their answers are not scored",
            number(unlabelled.len(), "scenario"),
            some(unlabelled)
        )));
    }
}

/// Rejects arguments that would change a resumed batch, and says what can be added instead.
pub fn all_stays(arguments: &Evaluate) -> Outcome {
    let scenarios = (!arguments.paths.is_empty()).then_some(("scenarios", ""));
    let shard = arguments.batch.shard.map(|_| ("--shard", ""));
    let Some((what, instead)) = scenarios
        .into_iter()
        .chain(settings(arguments))
        .chain(shard)
        .next()
    else {
        return Ok(());
    };
    let instead = match instead {
        "" => "start a new batch without --resume".to_string(),
        option => format!("use {option} to add some, or start a new batch without --resume"),
    };
    Err(Failure::input(format!(
        "--resume keeps the scenarios and settings of the batch, so {what} is not allowed: {instead}"
    )))
}

/// The options that were given and say what a batch asks, each with the one that adds more of it.
pub fn settings(arguments: &Evaluate) -> impl Iterator<Item = (&'static str, &'static str)> {
    let options = &arguments.batch;
    let given = [
        (!arguments.model.is_empty(), "--model", "--add-model"),
        (!arguments.task.is_empty(), "--task", ""),
        (!options.frame.is_empty(), "--frame", ""),
        (
            !options.techniques.is_empty(),
            "--techniques",
            "--add-techniques",
        ),
        (
            !options.transform.is_empty(),
            "--transform",
            "--add-transform",
        ),
        (arguments.ego.is_some(), "--ego", ""),
        (!arguments.lead.is_empty(), "--lead", "--add-lead"),
        (arguments.within.is_some(), "--within", ""),
        (options.protocol.is_some(), "--protocol", ""),
        (arguments.history.is_some(), "--history", ""),
        (arguments.radius.is_some(), "--radius", ""),
        (!options.temperature.is_empty(), "--temperature", ""),
        (options.max_tokens.is_some(), "--max-tokens", ""),
        (!options.effort.is_empty(), "--effort", ""),
        (!options.tools.is_empty(), "--tools", ""),
        (options.tool_limits.any(), "--tool-rounds", ""),
        (!options.form.is_empty(), "--form", ""),
        (!options.stride.is_empty(), "--stride", ""),
        (options.of_frames.road.is_some(), "--road", ""),
        (options.of_frames.axes.is_some(), "--axes", ""),
        (options.of_frames.measures.is_some(), "--measures", ""),
        (options.pack.is_some(), "--pack", ""),
        (!options.seed.is_empty(), "--seed", ""),
        (options.select.is_some(), "--select", ""),
        (options.test_share.is_some(), "--test-share", ""),
        (options.log_probabilities, "--log-probabilities", ""),
        (options.base_url.is_some(), "--base-url", ""),
        (options.declared.any(), "--baseline or --compare", ""),
    ];
    let given = given.into_iter().filter(|(given, ..)| *given);
    given.map(|(_, what, instead)| (what, instead))
}
