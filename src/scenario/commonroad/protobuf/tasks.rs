//! The scenario file of 2024: the planning problems, and which map and which traffic they are for.

use super::header::{self, Map};
use super::messages::PlanningProblem;
use super::report::{At, Report};
use super::wire::{Field, Fields};
use super::{planning, words};
use crate::scenario::commonroad::ReadError;
use crate::scenario::{self, Header, Severity};

/// What a scenario file says.
pub(super) struct Tasks {
    pub header: Header,
    /// Those of all planning problems, each once.
    pub tags: Vec<String>,
    pub problems: Vec<scenario::PlanningProblem>,
}

/// What was read so far.
#[derive(Default)]
struct Found {
    information: Option<(Header, Map)>,
    map: bool,
    dynamic: bool,
    tags: Vec<String>,
    problems: Vec<scenario::PlanningProblem>,
    cooperative: usize,
}

pub(super) fn read(r: &mut Report, root: &At<'_>, bytes: &[u8]) -> Result<Tasks, ReadError> {
    let mut found = Found::default();
    for field in Fields::of(bytes) {
        let field = r.whole(root, field)?;
        found.add(r, root, &field)?;
    }
    let (header, _) = r.need(root, "scenario_meta_information", found.information)?;
    r.need(root, "map_id", found.map.then_some(()))?;
    r.need(root, "dynamic_id", found.dynamic.then_some(()))?;
    if found.cooperative > 0 {
        let message = format!(
            "{} cooperative planning problems have no place here; their single problems are kept",
            found.cooperative
        );
        r.note(Severity::Note, root, message);
    }
    Ok(Tasks {
        header,
        tags: found.tags,
        problems: found.problems,
    })
}

impl Found {
    fn add(&mut self, r: &mut Report, root: &At<'_>, field: &Field<'_>) -> Result<(), ReadError> {
        match field.number {
            1 => {
                let at = root.field("scenario_meta_information");
                return r.part(&at, field, &mut self.information, header::of_2024);
            }
            // What they say was used to find the other files.
            3 => self.map = true,
            4 => self.dynamic = true,
            5 => {
                let at = root.field("planning_problems");
                let tags = &mut self.tags;
                let read = |r: &mut Report, at: &At<'_>, message: &PlanningProblem| {
                    let own = r.need(at, "scenario_tags", message.scenario_tags.as_ref())?;
                    for tag in words::tags(r, &at.field("scenario_tags"), &own.tags) {
                        if !tags.contains(&tag) {
                            tags.push(tag);
                        }
                    }
                    planning::problem(r, at, message)
                };
                return r.element(&at, field, &mut self.problems, read, |p| p.id);
            }
            6 => self.cooperative += 1,
            _ => r.unknown(root, field),
        }
        Ok(())
    }
}
