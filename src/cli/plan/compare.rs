//! Planners side by side: every scenario driven by all, paired differences of the first two, and where all stand beside
//! the baselines.

use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{CollisionKind, Outcome as DriveOutcome, Policy, Settings};
use nearmiss_formats::Entry;
use nearmiss_scene::traffic_rules::Rule;
use nearmiss_study::evaluation::statistics::PairedTest;
use nearmiss_workflow::drive::{
    BeyondBaselines, DriveRecord, DrivenScenario, PlannerChoice, Standing, StandingRecord,
    beyond_baselines, drive_each, standings, telling,
};
use nearmiss_workflow::{PlanError, prepare_beside};
use schemars::JsonSchema;
use serde::Serialize;

use super::driven;
use super::standing;
use super::table::{Export, OUTCOMES};
use super::{NotDrivenRecord, PlanArguments};
use crate::ending::interrupted;
use crate::files::Labels;
use crate::many_files::{Job, NEXT, RunJournal};
use crate::output::Align::{Left, Right};
use crate::output::{self, line};
use crate::{Failure, Outcome};

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
    let [first, second, ..] = planners else {
        return Err(Failure::input("a comparison needs two planners"));
    };
    if arguments.files.any() || arguments.files.to_stdout() {
        return Err(Failure::input(
            "planners are compared without files: leave out -o, --solution and --log, or drive each planner alone",
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
    let unnamed = Policy::BASELINES.into_iter().filter(|baseline| {
        let named = planners.iter().filter_map(|planner| planner.policy);
        !named.into_iter().any(|policy| policy == *baseline)
    });
    let baselines = unnamed.map(PlannerChoice::from);
    let all: Vec<PlannerChoice> = planners.iter().cloned().chain(baselines).collect();
    let standing = |(place, planner): (usize, &PlannerChoice)| Standing {
        name: output::visible(&planner.name),
        is_baseline: place >= planners.len(),
        drives: Vec::new(),
    };
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
        standings: all.iter().enumerate().map(standing).collect(),
        missed: 0,
        harmed: 0,
    };
    if !job.json {
        output::text(&job.title())?;
    }
    let both = |entry: &Entry| {
        let prepared = prepare_beside(entry, problem, settings);
        let drives = prepared.and_then(|prepared| drive_each(entry, &prepared, &all, &cancel));
        drives.transpose()
    };
    let done = Job::new("scenarios", &stop).run(entries, both, |entry, drives| {
        job.take(entry, drives)?;
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

/// All drives of a scenario, in the order of planners.
type ComparedDrives = Result<Vec<DrivenScenario>, PlanError>;

struct Comparison {
    json: bool,
    /// The drives as a table in a file.
    export: Option<Export>,
    names: [String; 2],
    labels: Labels,
    width: usize,
    pairs: Vec<(DrivenScenario, DrivenScenario)>,
    standings: Vec<Standing>,
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

    fn take(&mut self, entry: &Entry, drives: ComparedDrives) -> Result<(), Failure> {
        let mut drives = match drives {
            Ok(drives) => drives,
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
        let coarse = drives.iter().find_map(DrivenScenario::too_coarse);
        coarse.iter().for_each(|words| output::say(words));
        for (standing, driven) in self.standings.iter_mut().zip(&drives) {
            standing.drives.push(driven.into());
            self.harmed += usize::from(!standing.is_baseline && !driven.unharmed());
        }
        let records: Vec<DriveRecord> = if self.json || self.export.is_some() {
            drives.iter().map(DriveRecord::new).collect()
        } else {
            Vec::new()
        };
        if let Some(export) = &mut self.export {
            records.iter().try_for_each(|drive| export.add(drive))?;
        }
        drives.truncate(2);
        let (Some(two), Some(one)) = (drives.pop(), drives.pop()) else {
            return Ok(());
        };
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
        let differences = differences(&self.pairs);
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
            let interval = test.and_then(|test| telling(test, difference.scenarios));
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
        out += &format!("\n{}", standing::words(&self.standings, &self.scenarios())?);
        output::text(&out)
    }

    /// The names of what was driven.
    fn scenarios(&self) -> Vec<String> {
        self.pairs.iter().map(|(one, _)| one.name.clone()).collect()
    }

    fn record(&self) -> ComparisonRecord {
        let differences = differences(&self.pairs);
        let rows = differences.iter().map(|difference| {
            let test = difference.test.as_ref();
            let interval = test.and_then(|test| telling(test, difference.scenarios));
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
            differences: rows.collect(),
            standings: standings(&self.standings),
            beyond_baselines: beyond_baselines(&self.standings, &self.scenarios()),
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
    /// Every planner, and the baselines.
    standings: Vec<StandingRecord>,
    /// Scenarios that no baseline solves.
    beyond_baselines: BeyondBaselines,
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
            .or_else(|| driven::beyond_words(driven))
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

/// Both drives of a scenario.
type DrivenPair = (DrivenScenario, DrivenScenario);

/// A figure of both planners.
struct Difference {
    /// Its name in JSON.
    key: &'static str,
    /// In the table.
    words: &'static str,
    /// Decimals that are shown.
    decimals: usize,
    /// Scenarios in which both drives have it.
    scenarios: usize,
    /// Over these a count or a mean.
    first: Option<f64>,
    /// See `first`.
    second: Option<f64>,
    /// Of the differences in these.
    test: Option<PairedTest>,
    /// It counts drives that break a rule.
    is_rule: bool,
    /// It is the share that another one counts, in JSON alone.
    is_share: bool,
}

/// The differences of all figures.
fn differences(pairs: &[DrivenPair]) -> Vec<Difference> {
    let count = |key, words, is: &dyn Fn(&DrivenScenario) -> bool| {
        let figure = |driven: &DrivenScenario| Some(f64::from(u8::from(is(driven))));
        of(pairs, (key, words, 0), true, &figure)
    };
    let mut all = Vec::new();
    for name in OUTCOMES {
        all.push(count(name, name, &|driven| driven.outcome().name() == name));
        if name != "collision" {
            continue;
        }
        all.extend(KINDS.iter().map(|(words, kind)| {
            count(kind.name(), words, &|driven| {
                driven.collision().is_some_and(|c| c.kind() == *kind)
            })
        }));
    }
    all.extend(Rule::ALL.map(|rule| Difference {
        is_rule: true,
        ..count(rule.name(), rule.text(), &|driven| {
            driven.rules.broken().any(|broken| broken == rule)
        })
    }));
    let beyond = |driven: &DrivenScenario| {
        (!driven.is_recorded).then(|| f64::from(u8::from(driven.beyond_vehicle().is_some())))
    };
    all.push(of(
        pairs,
        ("undrivable_drives", "drives beyond the vehicle", 0),
        true,
        &beyond,
    ));
    all.extend(FIGURES.iter().map(|(key, words, decimals, figure)| {
        // What a drive would have come to is not known where its planner failed.
        let whole = |driven: &DrivenScenario| match driven.outcome() {
            DriveOutcome::PlannerError(_) => None,
            _ => figure(driven),
        };
        of(pairs, (key, words, *decimals), false, &whole)
    }));
    all.push(Difference {
        is_share: true,
        ..of(pairs, ("undrivable_share", "", 2), false, &beyond)
    });
    all
}

/// The difference of a figure over the scenarios in which both drives have it; means over these, and sums of counts over
/// all drives that have them.
fn of(
    pairs: &[DrivenPair],
    (key, words, decimals): (&'static str, &'static str, usize),
    summed: bool,
    figure: &dyn Fn(&DrivenScenario) -> Option<f64>,
) -> Difference {
    let both = pairs
        .iter()
        .filter_map(|(one, two)| Some((figure(one)?, figure(two)?)));
    let both: Vec<(f64, f64)> = both.collect();
    let whole = |own: &dyn Fn(&DrivenPair) -> Option<f64>, of_both: &dyn Fn(&(f64, f64)) -> f64| {
        let counts: Vec<f64> = pairs.iter().filter_map(own).collect();
        match (summed, both.len()) {
            (true, _) => (!counts.is_empty()).then(|| counts.iter().sum()),
            (false, 0) => None,
            (false, n) => Some(both.iter().map(of_both).sum::<f64>() / n as f64),
        }
    };
    let differences: Vec<f64> = both.iter().map(|(one, two)| one - two).collect();
    Difference {
        key,
        words,
        decimals,
        scenarios: both.len(),
        first: whole(&|pair| figure(&pair.0), &|both| both.0),
        second: whole(&|pair| figure(&pair.1), &|both| both.1),
        // One scenario says nothing about how much they differ.
        test: (differences.len() > 1)
            .then(|| PairedTest::of_differences(&differences))
            .flatten(),
        is_rule: false,
        is_share: false,
    }
}

/// A figure of a drive; nothing where the drive has none.
type Measured = fn(&DrivenScenario) -> Option<f64>;

/// What is compared beside the outcomes, with the decimals that are shown.
const FIGURES: [(&str, &str, usize, Measured); 7] = [
    ("p_serious", "serious injuries, expected", 3, |d| {
        d.p_serious()
    }),
    ("near_misses", "near misses", 2, |d| {
        d.near_misses.map(|n| n as f64)
    }),
    ("largest_deceleration", "strongest braking, m/s²", 2, |d| {
        Some(d.drive.largest_deceleration())
    }),
    ("mean_jerk", "mean jerk, m/s³", 2, |d| {
        d.drive.jerk().map(|j| j.0)
    }),
    ("max_jerk", "largest jerk, m/s³", 2, |d| {
        d.drive.jerk().map(|j| j.1)
    }),
    ("seconds_to_goal", "time to goal, s", 2, |d| {
        d.drive.seconds_to_goal()
    }),
    ("median_cycle_ms", "cycle, ms", 2, |d| {
        d.milliseconds().map(|(median, _)| median)
    }),
];

/// Collisions by kind.
const KINDS: [(&str, CollisionKind); 3] = [
    ("  ran into another", CollisionKind::RanInto),
    ("  rear-ended", CollisionKind::RearEnded),
    ("  side", CollisionKind::Side),
];
