//! The result of a tune for people.

use super::Tuned;
use crate::output::{self, counted, table_lines};
use nearmiss_study::evaluation::statistics::FEWEST;
use nearmiss_workflow::tune::{
    Candidate, CostMeasure, DevPart, TuneOutcome, TunePlan, template_diff,
};

/// Says what is tuned on.
pub fn begin(plan: &TunePlan, test_scenarios: usize) {
    for line in parts(plan, test_scenarios) {
        output::say(&format!("nearmiss: {line}"));
    }
}

/// The parts of the scenarios, a line each.
pub fn parts(plan: &TunePlan, test_scenarios: usize) -> Vec<String> {
    let part = |part: DevPart, about: &str| {
        let (scenarios, questions, dangerous) = plan.counts(part);
        format!(
            "{} part: {}, {} ({dangerous} dangerous); {about}",
            part.name(),
            counted(scenarios, "scenario"),
            counted(questions, "question"),
        )
    };
    let mut lines = vec![
        part(DevPart::Feedback, "wrong answers are shown"),
        part(DevPart::Selection, "templates are compared"),
        format!(
            "test split: {}, not opened",
            counted(test_scenarios, "scenario")
        ),
    ];
    if !can_find_gain(plan) {
        lines.push(format!(
            "no gain can be found: the selection part needs at least {FEWEST} {}s",
            plan.cluster()
        ));
    }
    if !plan.division.by_map {
        lines.push("too few maps: scenarios on the same map are in both parts".into());
    }
    if plan.left_out > 0 {
        lines.push(format!(
            "{} left out: no prompt can be made, or the truth is unknown",
            counted(plan.left_out, "question")
        ));
    }
    lines
}

/// Whether the selection part has enough units to tell a gain from chance.
pub fn can_find_gain(plan: &TunePlan) -> bool {
    plan.units().len() >= FEWEST as usize
}

/// The table, the gain, and the difference of the templates.
pub fn result(tuned: &Tuned<'_>, outcome: &TuneOutcome) -> String {
    let mut text = table(outcome);
    text += &format!("\n{}\n", gain(outcome));
    if !outcome.refused.is_empty() {
        text += &format!(
            "{} refused or not better; `--format json` lists them\n",
            counted(outcome.refused.len(), "proposal")
        );
    }
    text += &format!("{}\n", spent(tuned, outcome));
    if let (Some(winner), None) = (outcome.winner(), &tuned.arguments.output) {
        let plan = tuned.plan;
        text += &format!(
            "\n{}",
            template_diff(&plan.file, &plan.template.source, &winner.source)
        );
    }
    text
}

fn table(outcome: &TuneOutcome) -> String {
    let share = |value: Option<f64>| value.map_or_else(|| "–".into(), |v| format!("{v:.3}"));
    let titles = [
        "",
        "from",
        outcome.measure.title(),
        "specificity",
        "gain",
        "95 %",
        "USD/answer",
        "tokens",
        "front",
        "change",
    ];
    let mut rows = vec![titles.map(String::from)];
    rows.extend(outcome.candidates.iter().map(|one| {
        let gain = one.gain;
        [
            name(one),
            one.parent.map_or_else(String::new, |parent| match parent {
                0 => "base".into(),
                n => n.to_string(),
            }),
            share(one.score.value(outcome.measure)),
            share(one.score.counts.specificity()),
            gain.map_or_else(String::new, |gain| format!("{:+.3}", gain.difference)),
            gain.map_or_else(String::new, |gain| {
                format!("{:+.3} … {:+.3}", gain.interval.low, gain.interval.high)
            }),
            one.score
                .usd
                .map_or_else(|| "–".into(), |usd| format!("{usd:.5}")),
            one.score
                .tokens
                .map_or_else(|| "–".into(), |tokens| format!("{tokens:.0}")),
            if one.on_front { "yes" } else { "" }.into(),
            change(one),
        ]
    }));
    let cost = match outcome.cost {
        CostMeasure::Usd => "cost of an answer",
        CostMeasure::Tokens => "tokens of question and answer",
        CostMeasure::Unknown => "cost, which the server does not tell",
    };
    let lines: String = table_lines(&rows, &[2, 3, 4, 6, 7]).collect();
    let asked = outcome.candidates[0].score.asked;
    format!(
        "{lines}Selection part: {}, {}. Front: {} against {cost}.\n",
        counted(outcome.units, &outcome.cluster.to_string()),
        counted(asked, "question"),
        outcome.measure.title()
    )
}

/// What a candidate changes, and whether its answers judge anything.
fn change(candidate: &Candidate) -> String {
    match candidate.score.counts.always() {
        Some(said) => format!("{} (always {})", candidate.change, yes_or_no(said)),
        None => candidate.change.clone(),
    }
}

pub fn yes_or_no(said: bool) -> &'static str {
    if said { "yes" } else { "no" }
}

fn name(candidate: &Candidate) -> String {
    match candidate.number {
        0 => "base".into(),
        n => n.to_string(),
    }
}

/// What was found, in a sentence.
pub fn gain(outcome: &TuneOutcome) -> String {
    let Some((best, gain)) = outcome.best() else {
        let alike = outcome.candidates[1..].iter();
        return match alike
            .filter(|one| one.score.counts.always().is_some())
            .count()
        {
            0 => "No gain found: no proposal is better than the base.".into(),
            _ => "No gain found: no proposal that tells windows apart is better than the base."
                .into(),
        };
    };
    let (title, compared) = (outcome.measure.title(), outcome.candidates.len() - 1);
    let of = match compared {
        1 => "the only candidate".to_string(),
        n => format!("the best of {n} candidates; interval and p are corrected for that"),
    };
    let words = format!(
        "{title} {:+.3} (95 % {:+.3} … {:+.3}, p = {:.4}), candidate {}, {of}",
        gain.difference, gain.interval.low, gain.interval.high, gain.p, best.number
    );
    if outcome.found {
        format!("Gain: {words}.")
    } else if !outcome.can_tell() {
        format!(
            "No gain found: {words}. {} are too few to tell a gain from chance; 10 are needed.",
            counted(outcome.units, &outcome.cluster.to_string())
        )
    } else {
        format!("No gain found: {words}. That may be chance.")
    }
}

/// What was asked and paid.
fn spent(tuned: &Tuned<'_>, outcome: &TuneOutcome) -> String {
    let usage = &outcome.usage;
    let stored = match usage.answers_stored + usage.reflections_stored {
        0 => String::new(),
        n => format!(" {n} more came from the store."),
    };
    format!(
        "Asked {} and {} for ${:.4} of ${:.4}.{stored}",
        counted(usage.answers, "question"),
        counted(usage.reflections, "proposal"),
        tuned.spent,
        tuned.budget
    )
}

/// Says how it ended, and what to do next.
pub fn end(tuned: &Tuned<'_>, outcome: &TuneOutcome) {
    if let Some(why) = &outcome.stopped {
        output::say(&format!(
            "nearmiss: ended in round {} of {}: {why}",
            outcome.rounds.max(1),
            tuned.settings.rounds
        ));
    }
    if outcome.winner().is_none() {
        return;
    }
    let file = tuned.arguments.experiment.display();
    if tuned.arguments.save.is_none() {
        let more = match tuned.arguments.output {
            Some(_) => "--overwrite --save NAME",
            None => "--save NAME",
        };
        output::say(&format!(
            "nearmiss: the same command with {more} keeps the template among yours; it costs nothing more"
        ));
    }
    if tuned.pinned {
        output::say(&format!(
            "nearmiss: {file} names a version of its template; change or remove its line `templates`"
        ));
    }
    output::say(&format!(
        "nearmiss: the test split was not opened; with the template in use, `nearmiss evaluate {file} --split test` evaluates it there"
    ));
}

/// Why there is no better template, in a few words.
pub fn none(outcome: &TuneOutcome) -> String {
    match &outcome.stopped {
        Some(why) if outcome.best.is_none() => format!("no gain found; ended early: {why}"),
        _ => "no gain found".into(),
    }
}
