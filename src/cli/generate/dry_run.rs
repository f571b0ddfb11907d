//! `generate --dry-run`: how much a model is asked at most, and what that costs at most; nothing is sent.

use std::sync::{Arc, Mutex};

use super::variant::GenerateJob;
use crate::interrupt::interrupted;
use crate::many_files::{Job, NEXT};
use crate::output::Align::{Left, Right};
use crate::plan::request;
use crate::{Failure, Outcome, output};
use nearmiss_drive::generation::AttackSetup;
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::Scene;
use nearmiss_study::evaluation::generating::{self, Author, AuthorError, Authored, Bound, bound};
use nearmiss_workflow::{AttackSource, AttackWriter, GenerateRequest, generate};

/// Counts in place of asking.
struct Counter {
    author: Author,
    found: Mutex<Option<Bound>>,
}

impl AttackWriter for Counter {
    fn write(
        &self,
        ground: &AttackSetup<'_>,
        scene: &Arc<Scene>,
        delay: f64,
        _: &Cancel,
        _: &mut dyn FnMut(generating::Progress),
    ) -> Result<Option<Authored>, AuthorError> {
        let bound = bound(&self.author, ground, scene, delay)?;
        if let Ok(mut found) = self.found.lock() {
            *found = Some(bound);
        }
        Ok(None)
    }
}

/// Prints a line for each scenario, and the sum.
pub fn run(entries: &[Entry], job: &GenerateJob) -> Outcome {
    let Some(writer) = &job.writer else {
        return Err(Failure::input(
            "--dry-run counts what a model is asked; name one with --model, the search asks none",
        ));
    };
    let stop = interrupted(true);
    let cancel = Cancel::from_flag(&stop);
    let width = entries
        .iter()
        .map(|e| output::visible(&e.name).chars().count())
        .max()
        .unwrap_or(0)
        .clamp("scenario".len(), 48);
    let line = |name: &str, cells: [&str; 6]| {
        let columns = [
            Left(width),
            Right(8),
            Right(6),
            Right(8),
            Right(7),
            Right(9),
            Right(10),
        ];
        let cells: Vec<&str> = std::iter::once(name).chain(cells).collect();
        output::line("  ", &columns, &cells)
    };
    let cells = |bound: &Bound| {
        [
            bound.requests().to_string(),
            bound.votes.to_string(),
            bound.motions.to_string(),
            bound.grades.to_string(),
            bound.tokens.to_string(),
            bound
                .usd
                .map_or("unknown".into(), |usd| format!("{usd:.4}")),
        ]
    };
    let shown = |name: &str, bound: &Bound| {
        let cells = cells(bound);
        let [a, b, c, d, e, f] = &cells;
        line(name, [a, b, c, d, e, f])
    };
    output::text(&line(
        "scenario",
        ["requests", "votes", "motions", "grades", "tokens", "USD"],
    ))?;
    let mut all = Bound {
        usd: Some(0.0),
        ..Bound::default()
    };
    let mut failed = 0;
    let count = |entry: &Entry| {
        let counter = Counter {
            author: writer.author(&entry.name),
            found: Mutex::new(None),
        };
        let prepared = request(entry, job.problem, &job.settings);
        let counted = prepared.and_then(|prepared| {
            let prepared = prepared.driven_by(job.planner.clone());
            let request = GenerateRequest {
                prepared: &prepared,
                attackers: &job.only,
                wish: None,
                delay: job.effort.delay,
                style: job.style,
                source: AttackSource::Model(&counter),
            };
            generate(&request, &cancel, &mut |_| {})
        });
        // Nothing is asked where the ego is touched already.
        let none = || Bound {
            usd: Some(0.0),
            ..Bound::default()
        };
        let found = counter.found.into_inner().ok().flatten();
        Some(counted.map(|_| found.unwrap_or_else(none)))
    };
    let done = Job::new("scenarios", &stop).run(entries, count, |entry, found| {
        match found {
            Ok(found) => {
                output::text(&shown(&output::visible(&entry.name), &found))?;
                all = all.and(&found);
            }
            Err(error) => {
                output::say(&format!("nearmiss: {error}"));
                failed += 1;
            }
        }
        NEXT
    });
    done.end("nothing was asked")?;
    if entries.len() > 1 {
        output::text(&shown("all, at most", &all))?;
    }
    match failed {
        0 => Ok(()),
        n => Err(Failure::finding(format!(
            "{} could not be attacked",
            output::of_scenarios(n, entries.len())
        ))),
    }
}
