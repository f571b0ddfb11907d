//! States: time, position and quantities, exact or as intervals; planning problems.

use nearmiss_base::geometry::Shape;
use nearmiss_scene::scenario::{
    Goal, PlanningProblem, Position, Quantity, Severity, State, StateField, Steps,
};

use super::elements::{point, push_shape, reference};
use super::xml::{Element, Xml};
use super::{ReadError, builder};

/// A state; `initial` gives the time 0 to one that says none.
pub(super) fn state<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    initial: bool,
) -> Result<State, ReadError> {
    xml.mark(element);
    let mut time = None;
    let mut state = State::at(Steps::exact(0));
    let mut seen: Vec<&str> = Vec::new();
    while let Some(child) = xml.next()? {
        if seen.contains(&child.name) {
            let message = format!("<{}> is given twice; the first is used", child.name);
            xml.note(Severity::Warning, child, message);
            xml.skip_unknown(child)?;
            continue;
        }
        seen.push(child.name);
        match child.name {
            "time" => time = Some(steps(xml, child)?),
            "position" => state.position = position(xml, child)?,
            name => match StateField::parse(name) {
                Some(field) => {
                    let value = if builder::is_needed(field) {
                        quantity(xml, child)?
                    } else {
                        optional_quantity(xml, child)?
                    };
                    builder::set_quantity(&mut state, field, value);
                }
                None => xml.skip_unknown(child)?,
            },
        }
    }
    state.time = match time {
        Some(time) => time,
        None if initial => {
            xml.note(
                Severity::Warning,
                element,
                "no <time>; taken as step 0".into(),
            );
            Steps::exact(0)
        }
        None => return Err(xml.fail_in(element, "a state needs <time>".into())),
    };
    Ok(state)
}

/// A time: an exact step or an interval of steps.
pub(super) fn steps<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Steps, ReadError> {
    let [exact, from, to] = numbers(xml, Xml::any_number)?;
    xml.times.steps(&xml.at(element), exact, from, to)
}

/// A quantity that must be sound.
pub(super) fn quantity<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
) -> Result<Option<Quantity>, ReadError> {
    let [exact, from, to] = numbers(xml, Xml::number)?;
    builder::quantity(&xml.at(element), exact, from, to)
}

/// A quantity that is left out where it is not sound.
fn optional_quantity<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
) -> Result<Option<Quantity>, ReadError> {
    let [exact, from, to] = numbers(xml, Xml::any_number)?;
    builder::optional_quantity(&xml.at(element), exact, from, to)
}

/// `<exact>`, `<intervalStart>` and `<intervalEnd>`.
fn numbers<'a>(
    xml: &mut Xml<'a>,
    read: fn(&mut Xml<'a>, Element<'a>) -> Result<f64, ReadError>,
) -> Result<[Option<f64>; 3], ReadError> {
    let (mut exact, mut from, mut to) = (None, None, None);
    while let Some(child) = xml.next()? {
        match child.name {
            "exact" => exact = Some(read(xml, child)?),
            "intervalStart" => from = Some(read(xml, child)?),
            "intervalEnd" => to = Some(read(xml, child)?),
            _ => xml.skip_unknown(child)?,
        }
    }
    Ok([exact, from, to])
}

/// A position: a point, regions, or lanelets.
pub(super) fn position<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
) -> Result<Option<Position>, ReadError> {
    let (mut here, mut shapes, mut lanelets) = (None, Vec::new(), Vec::new());
    while let Some(child) = xml.next()? {
        match child.name {
            "point" => here = Some(point(xml, child)?),
            "lanelet" => lanelets.push(reference(xml, child)?),
            _ => {
                if !push_shape(xml, child, 0, &mut shapes)? {
                    xml.skip_unknown(child)?;
                }
            }
        }
    }
    let kinds = [here.is_some(), !shapes.is_empty(), !lanelets.is_empty()];
    if kinds.iter().filter(|kind| **kind).count() > 1 {
        let message =
            "a position can be a point, shapes or lanelets, not several; the first counts";
        xml.note(Severity::Warning, element, message.into());
    }
    Ok(match (here, Shape::union(shapes), lanelets.is_empty()) {
        (Some(here), ..) => Some(Position::Point(here)),
        (None, Some(region), _) => Some(Position::Region(region)),
        (None, None, false) => Some(Position::Lanelets(lanelets)),
        (None, None, true) => {
            xml.note(
                Severity::Warning,
                element,
                "an empty position was left out".into(),
            );
            None
        }
    })
}

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
