//! Planning problems.

use super::error::ReadError;
use super::states::{position, quantity, state, steps};
use super::xml::{Element, Xml};
use nearmiss_scene::scenario::{Goal, PlanningProblem, Severity, State, Steps};

pub(super) fn problem<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
) -> Result<PlanningProblem, ReadError> {
    let id = xml.id_attribute(element, "id")?;
    let (mut initial, mut goals) = (None, Vec::new());
    while let Some(child) = xml.next()? {
        match child.name {
            "initialState" => initial = Some(state(xml, child, true)?),
            "goalState" => goals.push(goal(xml, child)?),
            // Version 2017a has the goals as states in it.
            "goalRegion" => {
                while let Some(part) = xml.next()? {
                    match part.name {
                        "state" => goals.push(goal(xml, part)?),
                        _ => xml.skip_unknown(part)?,
                    }
                }
            }
            _ => xml.skip_unknown(child)?,
        }
    }
    let initial = initial.unwrap_or_else(|| {
        xml.note(Severity::Warning, element, "no initial state".into());
        State::at(Steps::exact(0))
    });
    Ok(PlanningProblem { id, initial, goals })
}

fn goal<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Goal, ReadError> {
    xml.mark(element);
    let mut time = None;
    let mut goal = Goal {
        time: Steps::exact(0),
        positions: Vec::new(),
        orientation: None,
        velocity: None,
    };
    while let Some(child) = xml.next()? {
        match child.name {
            "time" => time = Some(steps(xml, child)?),
            "position" => goal.positions.extend(position(xml, child)?),
            "orientation" => goal.orientation = quantity(xml, child)?,
            "velocity" => goal.velocity = quantity(xml, child)?,
            _ => xml.skip_unknown(child)?,
        }
    }
    goal.time = time.ok_or_else(|| xml.fail_in(element, "a goal state needs <time>".into()))?;
    Ok(goal)
}
