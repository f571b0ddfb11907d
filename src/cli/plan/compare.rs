//! Two planners side by side: every scenario driven by both, and paired differences.

use schemars::JsonSchema;
use serde::Serialize;

use super::differences;
use super::driven::{self, DrivenScenario};
use super::export::Export;
use super::planners::PlannerChoice;
use super::{DriveRecord, NotDrivenRecord, PlanArguments};
use crate::interrupt::interrupted;
use crate::json::Output;
use crate::many_files::{Job, NEXT, RunJournal};
use crate::output::Align::{Left, Right};
use crate::output::{self, line};
use crate::row_file::Labels;
use crate::{Failure, Outcome};
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::Entry;
use nearmiss_workflow::PlanError;

/// Longer names of scenarios push the columns behind them.
const WIDEST: usize = 48;

/// Names of planners above columns are cut to so many characters.
const LABEL: usize = 20;

/// Drives every scenario with both planners.
pub fn run(
    arguments: &PlanArguments,
    entries: &[Entry],
    planners: &[PlannerChoice],
    settings: &Settings,
) -> Outcome {
    let [first, second] = planners else {
        return Err(Failure::input(format!(
            "{} planners are named; two can be compared",
            planners.len()
        )));
    };
    if arguments.files.any() || arguments.files.to_stdout() {
        return Err(Failure::input(
            "two planners are compared without files: leave out -o, --solution and --log, or drive each planner alone",
        ));
    }
    if arguments.monitor.is_asked() {
        return Err(Failure::input(
            "--monitor watches one planner; name only one",
        ));
    }
    let stop = interrupted(true);
    let cancel = Cancel::from_flag(&stop);
    let problem = arguments.how.planning_problem;
    let labels = Labels::new(entries);
    let mut job = Comparison {
        json: arguments.format.is_json(),
        export: Export::begin(
            (arguments.table.as_deref(), arguments.spreadsheet),
            arguments.files.overwrites(),
            &RunJournal::none(),
        )?,
        names: [output::visible(&first.name), output::visible(&second.name)],
        width: widest(&labels),
        labels,
        pairs: Vec::new(),
        missed: 0,
        harmed: 0,
    };
    if !job.json {
        output::text(&job.title())?;
    }
    let both = |entry: &Entry| {
        let drive = |planner| {
            driven::drive(
                entry,
                problem,
                settings,
                Some(planner),
                (None, false),
                &cancel,
            )
        };
        let one = drive(first)?;
        Some(one.and_then(|one| Ok((one, drive(second).transpose()?))))
    };
    let done = Job::new("scenarios", &stop).run(entries, both, |entry, pair| {
        job.take(entry, pair)?;
        NEXT
    });
    job.end()?;
    job.export
        .take()
        .map_or(Ok(()), |export| export.finish(&RunJournal::none()))?;
    done.end("")?;
    match (job.harmed, job.missed) {
        (0, 0) => Ok(()),
        (_, missed) if missed == entries.len() => Err(Failure::input(format!(
            "none of the {missed} scenarios could be planned"
        ))),
        (harmed, missed) => Err(Failure::finding(format!(
            "{} ended otherwise than at the goal or out of time; {} could not be planned",
            output::counted(harmed, "drive"),
            output::counted(missed, "scenario")
        ))),
    }
}

fn widest(labels: &Labels) -> usize {
    let least = "drives beyond the vehicle".len();
    labels.longest().max(least).min(WIDEST)
}

/// Both drives of a scenario; the second one is missing where it was cut short.
type Pair = Result<(DrivenScenario, Option<DrivenScenario>), PlanError>;

struct Comparison {
    json: bool,
    /// The drives as a table in a file.
    export: Option<Export>,
    names: [String; 2],
    labels: Labels,
    width: usize,
    pairs: Vec<(DrivenScenario, DrivenScenario)>,
    missed: usize,
    harmed: usize,
}

impl Comparison {
    /// What stands above the columns of both: their names, where those are short and differ.
    fn labels(&self) -> [String; 2] {
        let labels = [0, 1].map(|place| {
            let name: &String = &self.names[place];
            if name.chars().count() > LABEL {
                { name.chars() }.take(LABEL - 1).chain(['…']).collect()
            } else {
                name.clone()
            }
        });
        if labels[0] == labels[1] {
            ["first".into(), "second".into()]
        } else {
            labels
        }
    }

    fn title(&self) -> String {
        let labels = self.labels();
        let [first, second] = &labels;
        let mut title = String::new();
        for (label, name) in labels.iter().zip(&self.names) {
            if label != name {
                title += &format!("{label}: {name}\n");
            }
        }
        let header = ["scenario", first, second, "goal s", "goal s", "with"];
        title + &self.row(&header)
    }

    /// The width of the columns of both planners.
    fn label_width(&self) -> usize {
        let widest = self.labels().map(|label| label.chars().count());
        widest.into_iter().max().unwrap_or(0).max(13)
    }

    fn row(&self, cells: &[&str; 6]) -> String {
        let columns = [
            Left(self.width),
            Left(self.label_width()),
            Left(self.label_width()),
            Right(6),
            Right(6),
            Left(30),
        ];
        line("  ", &columns, cells)
    }

    fn take(&mut self, entry: &Entry, pair: Pair) -> Result<(), Failure> {
        let (one, two) = match pair {
            Ok((one, Some(two))) => (one, two),
            Ok((_, None)) => return Ok(()),
            Err(error) => {
                self.missed += 1;
                output::say(&format!("nearmiss: {error}"));
                return if self.json {
                    show(&NotDrivenRecord::new(entry, &error))
                } else {
                    Ok(())
                };
            }
        };
        let harmed = [&one, &two].map(|driven| usize::from(!driven.unharmed()));
        self.harmed += harmed.iter().sum::<usize>();
        let records = [&one, &two].map(DriveRecord::new);
        if let Some(export) = &mut self.export {
            records.iter().try_for_each(|drive| export.add(drive))?;
        }
        if self.json {
            records.iter().try_for_each(show)?;
        } else {
            let seconds = |driven: &DrivenScenario| {
                let goal = driven.drive.seconds_to_goal();
                goal.map_or("-".into(), |seconds| format!("{seconds:.1}"))
            };
            let label = self.labels.of(&one.name, &one.file);
            let cells = [
                label.as_str(),
                one.outcome().name(),
                two.outcome().name(),
                &seconds(&one),
                &seconds(&two),
                &with(&one, &two),
            ];
            output::text(&self.row(&cells))?;
        }
        self.pairs.push((one, two));
        Ok(())
    }

    /// The differences of all scenarios.
    fn end(&self) -> Result<(), Failure> {
        if self.json {
            return show(&self.record());
        }
        let mut out = String::from("\n");
        let wide = Right(self.label_width());
        let columns = [Left(self.width), wide, wide, Right(9), Right(10), Left(24)];
        let [first, second] = &self.labels();
        let header = [
            "",
            first,
            second,
            "scenarios",
            "difference",
            "95 % interval",
        ];
        out += &line("  ", &columns, &header);
        let differences = differences::all(&self.pairs);
        for difference in differences {
            let none = [difference.first, difference.second] == [Some(0.0), Some(0.0)];
            if difference.is_rule && none || difference.is_share {
                continue;
            }
            let words = if difference.is_rule {
                format!("breaks {}", difference.words)
            } else {
                difference.words.to_string()
            };
            let decimals = difference.decimals;
            let number = |value: Option<f64>| {
                value.map_or("-".into(), |value| format!("{value:.decimals$}"))
            };
            let test = difference.test.as_ref();
            let signed = |value: f64| format!("{value:+.2}");
            let interval = test.and_then(|test| test.interval);
            let cells = [
                words,
                number(difference.first),
                number(difference.second),
                difference.scenarios.to_string(),
                test.map_or("-".into(), |test| signed(0.0 - test.difference)),
                interval.map_or(String::new(), |interval| {
                    format!(
                        "{} to {}",
                        signed(0.0 - interval.high),
                        signed(0.0 - interval.low)
                    )
                }),
            ];
            out += &line("  ", &columns, &cells);
        }
        let told = self.pairs.iter().find_map(|(one, two)| {
            let both = [one, two].map(|drive| DriveRecord::new(drive).planner_summary());
            both.iter().any(Option::is_some).then_some(both)
        });
        for told in told.into_iter().flatten().flatten() {
            out += &format!("planner {told}\n");
        }
        out += &format!(
            "{}; outcomes, kinds and rules are counts of drives, the rest means over the scenarios in which both drives have it; differences are {second} minus {first}, a scenario at a time\n",
            output::counted(self.pairs.len(), "scenario")
        );
        output::text(&out)
    }

    fn record(&self) -> ComparisonRecord {
        let differences = differences::all(&self.pairs);
        let differences = differences.iter().map(|difference| {
            let test = difference.test.as_ref();
            let interval = test.and_then(|test| test.interval);
            DifferenceRecord {
                figure: difference.key,
                scenarios: difference.scenarios,
                first: difference.first,
                second: difference.second,
                difference: test.map(|test| 0.0 - test.difference),
                interval: interval.map(|i| (0.0 - i.high, 0.0 - i.low)),
                p: test.map(|test| test.p),
            }
        });
        ComparisonRecord {
            first: self.names[0].clone(),
            second: self.names[1].clone(),
            scenarios: self.pairs.len(),
            missed: self.missed,
            differences: differences.collect(),
        }
    }
}

/// Two planners compared.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ComparisonRecord {
    /// The first planner.
    first: String,
    /// The second planner.
    second: String,
    /// Scenarios driven by both.
    scenarios: usize,
    /// Scenarios that could not be planned.
    missed: usize,
    /// By figure: outcomes, kinds of collisions, comfort, times.
    differences: Vec<DifferenceRecord>,
}

impl Output for ComparisonRecord {
    const NAME: &'static str = "plan-comparison";
    const TITLE: &'static str = "`plan --planner A --planner B --format json`: the last line";
}

/// A figure of both planners.
#[derive(Debug, Serialize, JsonSchema)]
struct DifferenceRecord {
    figure: &'static str,
    /// Scenarios in which both drives have it.
    scenarios: usize,
    /// Sums of counts, else means.
    first: Option<f64>,
    /// Sums of counts, else means.
    second: Option<f64>,
    /// Second minus first, paired.
    difference: Option<f64>,
    /// 95 % interval of the difference.
    interval: Option<(f64, f64)>,
    /// Of no difference.
    p: Option<f64>,
}

/// What the drives of a scenario touch, and what went wrong.
fn with(one: &DrivenScenario, two: &DrivenScenario) -> String {
    let touched = |driven: &DrivenScenario| {
        let collision = driven.collision();
        let touched = collision.map(|c| format!("{} ({})", c.with, c.kind().name()));
        touched
            .or_else(|| driven.planner_words())
            .or_else(|| driven.beyond_words())
    };
    match (touched(one), touched(two)) {
        (None, None) => "-".into(),
        (one, two) => [one, two]
            .map(|words| words.unwrap_or("-".into()))
            .join(" · "),
    }
}

fn show(value: &impl Serialize) -> Result<(), Failure> {
    output::text(&output::json_line(value)?)
}
