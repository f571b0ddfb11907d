//! Runs as a table: time, verdict, model and cost.

use crate::{output, time};
use nearmiss_base::system::columns;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{AnswerState, Origin, Summary};
use nearmiss_study::evaluation::Spending;

const TITLES: [&str; 10] = [
    "run",
    "asked",
    "verdict",
    "scenario",
    "model",
    "task",
    "frame",
    "techniques",
    "cost [$]",
    "",
];

/// The table, with a line of titles; nothing where there are no runs.
pub(super) fn table(runs: &[Summary]) -> String {
    if runs.is_empty() {
        return String::new();
    }
    let titles = std::iter::once(TITLES.map(String::from));
    let rows: Vec<[String; 10]> = titles.chain(runs.iter().map(row)).collect();
    let indent = rows.iter().map(|row| columns(&row[0])).max();
    let indent = " ".repeat(indent.unwrap_or(0));
    // Numbers end where their column does.
    let mut lines = output::table_lines(&rows, &[0, 8]);
    let mut text = lines.next().unwrap_or_default();
    for (line, run) in lines.zip(runs) {
        text += &line;
        if let Some(excerpt) = &run.excerpt {
            let words: Vec<_> = excerpt.split_whitespace().collect();
            text += &output::visible(&format!("{indent}  {}\n", words.join(" ")));
        }
    }
    text
}

fn row(run: &Summary) -> [String; 10] {
    let mut remarks = Vec::new();
    if run.sample > 0 {
        remarks.push(format!("sample {}", run.sample));
    }
    match run.origin {
        Origin::Asked => {}
        Origin::Recorded => remarks.push("recorded, imported".into()),
        Origin::Replayed => remarks.push(run.origin.name().into()),
    }
    if run.superseded {
        remarks.push(AnswerState::Superseded.name().into());
    }
    if run.pinned {
        remarks.push("pinned".into());
    }
    [
        run.run.to_string(),
        time::local(run.created_ms),
        said(run),
        run.scenario.clone(),
        run.model.clone(),
        run.task.name().into(),
        run.frame.clone(),
        run.techniques.clone(),
        cost(run),
        remarks.join(", "),
    ]
}

/// The verdict in the words of its task, or how far the answer came; in brackets the verdict of an answer that was cut
/// off, which does not count.
fn said(run: &Summary) -> String {
    let has_verdicts = Task::VERDICTS.contains(&run.task);
    let verdict = match (run.dangerous, run.task) {
        (Some(true), Task::Collision) => "collision",
        (Some(false), Task::Collision) => "no collision",
        (Some(true), Task::Recording) => "high risk",
        (Some(false), Task::Recording) => "safe",
        (Some(true), _) => "critical",
        (Some(false), _) => "not critical",
        (None, _) => "",
    };
    match (run.own_state(), verdict) {
        (AnswerState::Answered, verdict) if !verdict.is_empty() => verdict.into(),
        (AnswerState::Unparsed, _) if has_verdicts => "no verdict".into(),
        (AnswerState::Answered | AnswerState::Unparsed, _) => run.state.name().into(),
        (state, "") => state.name().into(),
        (state, verdict) => format!("{} ({verdict})", state.name()),
    }
}

/// What a run cost, US dollars; `<=` before the most that one can have cost that broke off.
fn cost(run: &Summary) -> String {
    match (run.cost_usd, run.most_usd) {
        (Some(usd), _) => format!("{usd:.6}"),
        (None, Some(0.0)) => "0".into(),
        (None, Some(most)) => format!("<={most:.6}"),
        (None, None) if costs_nothing(run) => "-".into(),
        (None, None) => "unknown".into(),
    }
}

/// The built-in judge costs nothing, and what others recorded cost nothing here.
fn costs_nothing(run: &Summary) -> bool {
    run.model == judge::MODEL || run.origin == Origin::Recorded
}

/// How many runs, and what they cost together.
pub(super) fn sum(runs: &[Summary]) -> String {
    let mut sum = Spending::default();
    for run in runs {
        let free = costs_nothing(run) && run.most_usd.is_none();
        sum.add(run.cost_usd.or(free.then_some(0.0)), run.most_usd);
    }
    let mut text = format!(
        "{}: {:.6} US dollars",
        output::counted(runs.len(), "run"),
        sum.usd
    );
    if sum.bounded > 0 {
        text += &format!(
            "; {} of unknown cost, at most {:.6} more",
            sum.bounded, sum.most_usd
        );
    }
    match sum.unknown {
        0 => {}
        n => text += &format!("; cost of {n} unknown"),
    }
    text
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_store::{RunState, StoredTemplate};

    fn summary(run: i64, cost: Option<f64>, most: Option<f64>) -> Summary {
        Summary {
            run,
            created_ms: 0,
            origin: Origin::Asked,
            state: RunState::Answered,
            answer_state: AnswerState::Answered,
            scenario: "ZAM_A-1".into(),
            task: Task::Collision,
            frame: "ego".into(),
            techniques: "cp".into(),
            template: StoredTemplate::default(),
            model: "lab/x".into(),
            sample: 0,
            dangerous: None,
            cost_usd: cost,
            most_usd: most,
            output_tokens: None,
            finish: None,
            superseded: false,
            pinned: false,
            excerpt: None,
        }
    }

    #[test]
    fn costs_are_summed_and_bounds_told_apart() {
        let mut built_in = summary(4, None, None);
        built_in.model = judge::MODEL.into();
        let runs = [
            summary(1, Some(0.25), Some(1.0)),
            summary(2, None, Some(0.5)),
            summary(3, None, None),
            built_in,
            summary(5, None, Some(0.0)),
        ];
        assert_eq!(
            sum(&runs),
            "5 runs: 0.250000 US dollars; 1 of unknown cost, at most 0.500000 more; cost of 1 unknown"
        );
        assert_eq!(sum(&runs[3..4]), "1 run: 0.000000 US dollars");
        let costs = runs.each_ref().map(cost);
        assert_eq!(costs, ["0.250000", "<=0.500000", "unknown", "-", "0"]);
    }

    #[test]
    fn verdicts_have_the_words_of_their_task() {
        let mut run = summary(1, None, None);
        assert_eq!(said(&run), "no verdict");
        run.dangerous = Some(false);
        assert_eq!(said(&run), "no collision");
        run.task = Task::Safety;
        assert_eq!(said(&run), "not critical");
        (run.dangerous, run.task) = (None, Task::Attacker);
        assert_eq!(said(&run), "answered");
        // A cut answer says something, and is none.
        (run.state, run.finish) = (RunState::Truncated, Some("content_filter".into()));
        (run.task, run.dangerous) = (Task::Safety, Some(true));
        assert_eq!(said(&run), "filtered (critical)");
        assert_eq!(run.own_state(), AnswerState::Filtered);
        (run.state, run.dangerous) = (RunState::Cancelled, None);
        assert_eq!(said(&run), "cancelled");
        let table = table(&[run]);
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(lines.len(), 2, "{table}");
        assert_eq!(
            lines[0].find("verdict"),
            lines[1].find("cancelled"),
            "{table}"
        );
    }
}
