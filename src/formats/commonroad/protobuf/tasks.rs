//! The scenario file of 2024: planning problems, and the map and traffic they refer to.

use super::elements::Elements;
use super::header::{self, Map};
use super::messages::PlanningProblem;
use super::planning;
use super::report::FieldPath;
use crate::commonroad::ReadError;
use crate::commonroad::builder::{ScenarioBuilder, SourceLocation};
use nearmiss_scene::scenario::{Header, Severity};

/// Adds the planning problems to a scenario, and the tags of all of them, each once; the header.
pub(super) fn read(
    root: &FieldPath<'_>,
    bytes: &[u8],
    builder: &mut ScenarioBuilder,
) -> Result<Header, ReadError> {
    let mut information: Option<(Header, Map)> = None;
    let (mut map, mut dynamic, mut cooperative) = (None, None, 0);
    let mut elements = Elements::new(root, builder);
    root.each_field(bytes, |field| {
        match field.number {
            1 => {
                let at = root.field("scenario_meta_information");
                at.part(field, &mut information, header::of_2024)?;
            }
            // These fields were used to find the other files.
            3 => map = Some(()),
            4 => dynamic = Some(()),
            5 => elements.add("planning_problems", field, problem)?,
            6 => cooperative += 1,
            _ => root.skip_unknown(field),
        }
        Ok(())
    })?;
    let (header, _) = root.need("scenario_meta_information", information)?;
    root.need("map_id", map)?;
    root.need("dynamic_id", dynamic)?;
    if cooperative > 0 {
        let message = format!(
            "{cooperative} cooperative planning problems are not supported; their single problems are kept"
        );
        root.note(Severity::Note, message);
    }
    Ok(header)
}

fn problem(
    builder: &mut ScenarioBuilder,
    at: &FieldPath<'_>,
    message: &PlanningProblem,
) -> Result<(), ReadError> {
    let own = at.need("scenario_tags", message.scenario_tags.as_ref())?;
    for tag in planning::tags(&at.field("scenario_tags"), own) {
        if !builder.tags.contains(&tag) {
            builder.tags.push(tag);
        }
    }
    builder.problem(at, planning::problem(at, message)?);
    Ok(())
}
