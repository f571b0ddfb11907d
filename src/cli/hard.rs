//! `corpus sample --hard`: drives scenarios in the order of drawing until enough are hard and proven solvable.

use std::collections::HashSet;
use std::ops::ControlFlow;
use std::path::Path;

use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::Entry;
use nearmiss_scene::corpus::{DrawingOrder, SampledWindow, in_cells};
use nearmiss_workflow::PlanError;
use nearmiss_workflow::drive::{Hardness, Solver, hardness};

use super::corpus::SampleLine;
use super::ending::interrupted;
use super::many_files::{Done, Job, NEXT};
use super::open::{configuration, entry};
use super::{Failure, output};

/// What came of the scenarios that were tried.
#[derive(Default)]
struct Counts {
    driven: usize,
    /// Scenarios that say nothing: traffic that reacts to nothing runs into a baseline.
    hit_from_behind: usize,
    /// Scenarios in which all baselines leave the road.
    off_road: usize,
    hard: usize,
    /// Of these, by [`Solver::ALL`].
    solved: [usize; Solver::ALL.len()],
    /// Scenarios without a planning problem, or without a way to its goal.
    nothing: usize,
    /// Scenarios with the content of one before.
    copies: usize,
    failed: usize,
}

/// Why a scenario was not driven.
enum NotDriven {
    /// There is nothing to drive in it.
    Nothing,
    Failed(Failure),
}

/// At most `most` windows, each of another scenario that no baseline solves and a drive proves solvable; and how far the job
/// came.
pub fn drawn(
    order: DrawingOrder<SampleLine>,
    most: usize,
) -> Result<(Vec<SampledWindow<SampleLine>>, Done), Failure> {
    let (_, config) = configuration()?;
    let settings = Settings::from(&config.planning());
    let stop = interrupted(true);
    let cancel = Cancel::from_flag(&stop);
    let mut seen = HashSet::new();
    let windows = order.filter(|one| seen.insert(one.candidate.path.clone()));
    let windows: Vec<SampledWindow<SampleLine>> = windows.collect();
    let drive = |window: &SampledWindow<SampleLine>| {
        let entry = entry(Path::new(&window.row.file)).map_err(NotDriven::Failed);
        let judged = |entry: Entry| {
            let hash = entry
                .read()
                .map_err(|why| NotDriven::Failed(Failure::input(why)))?
                .hash;
            let judged = hardness(&entry, &settings, &cancel).map_err(|error| match error {
                PlanError::NothingToPlan(_) => NotDriven::Nothing,
                error => NotDriven::Failed(Failure::input(error)),
            });
            Ok(judged?.map(|hardness| (hash, hardness)))
        };
        entry.and_then(judged).transpose()
    };
    let (mut counts, mut found) = (Counts::default(), Vec::new());
    let mut contents = HashSet::new();
    let done = Job::new("scenarios", &stop).run(&windows, drive, |window, result| {
        match result {
            Ok((hash, _)) if !contents.insert(hash) => counts.copies += 1,
            Ok((_, hardness)) => {
                counts.driven += 1;
                match hardness {
                    Hardness::SolvedBy(_) => {}
                    Hardness::HitFromBehind(_) => counts.hit_from_behind += 1,
                    Hardness::OffRoad => counts.off_road += 1,
                    Hardness::Hard { ends, solver } => {
                        counts.hard += 1;
                        found.extend(solver.map(|solver| {
                            counts.solved[solver as usize] += 1;
                            let mut window = window.clone();
                            window.row.solved_by = Some(solver);
                            window.row.baselines = Some(ends.into());
                            window
                        }));
                    }
                }
            }
            Err(NotDriven::Nothing) => counts.nothing += 1,
            Err(NotDriven::Failed(failure)) => {
                failure.say();
                counts.failed += 1;
            }
        }
        if found.len() < most {
            NEXT
        } else {
            Ok(ControlFlow::Break(()))
        }
    });
    counts.say();
    if counts.driven == 0 && !done.interrupted {
        return Err(Failure::input("no scenario of the index could be driven"));
    }
    if found.len() < most && !done.interrupted {
        output::say("nearmiss: all scenarios of the index were tried");
    }
    Ok((in_cells(found), done))
}

impl Counts {
    /// On standard error.
    fn say(&self) {
        let by = Solver::ALL.into_iter().zip(self.solved);
        let by: Vec<String> = by.map(|(by, n)| format!("{} {n}", by.words())).collect();
        let mut words = format!(
            "nearmiss: driven {}, a baseline hit from behind {}, baselines off the road {}, baselines fail {}, solvable {} ({})",
            self.driven,
            self.hit_from_behind,
            self.off_road,
            self.hard,
            self.solved.iter().sum::<usize>(),
            by.join(", ")
        );
        let not = [
            (self.nothing, "without a problem that can be planned"),
            (self.copies, "with the content of another"),
            (self.failed, "failed"),
        ];
        let not = not.iter().filter(|(count, _)| *count > 0);
        let not: Vec<String> = not.map(|(count, why)| format!("{count} {why}")).collect();
        if !not.is_empty() {
            words += &format!("; not driven: {}", not.join(", "));
        }
        output::say(&words);
    }
}
