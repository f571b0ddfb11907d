//! Shared elements: points, shapes, references, the location of a scenario; states, exact or as intervals; planning problems.

use nearmiss_base::geometry::{Footprint, Point, Shape};
use nearmiss_scene::scenario::{
    Environment, GeoTransformation, Goal, Location, PlanningProblem, Position, Quantity, Severity,
    State, StateField, Steps,
};

use super::xml::{Element, Xml, short};
use super::{ReadError, builder, obstacles};

/// Shape groups inside shape groups, deeper than any file needs.
const DEEPEST_GROUP: usize = 8;

/// `<point>` with x and y, and z if it is there.
pub(super) fn point_with_height<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
) -> Result<(Point, Option<f64>), ReadError> {
    let mut z = None;
    let point = coordinates(xml, element, |xml, child| {
        z = Some(xml.number(child)?);
        Ok(())
    })?;
    Ok((point, z))
}

/// `<point>` in the plane: bodies have no height, and a z counts as not used.
pub(super) fn point<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Point, ReadError> {
    coordinates(xml, element, Xml::skip_unknown)
}

fn coordinates<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    mut height: impl FnMut(&mut Xml<'a>, Element<'a>) -> Result<(), ReadError>,
) -> Result<Point, ReadError> {
    let (mut x, mut y) = (None, None);
    while let Some(child) = xml.next()? {
        match child.name {
            "x" => x = Some(xml.coordinate(child)?),
            "y" => y = Some(xml.coordinate(child)?),
            "z" => height(xml, child)?,
            _ => xml.skip_unknown(child)?,
        }
    }
    match (x, y) {
        (Some(x), Some(y)) => Ok(Point::new(x, y)),
        _ => Err(xml.fail_in(element, "a point needs <x> and <y>".into())),
    }
}

/// The `ref` attribute of an element without content.
fn reference<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<i64, ReadError> {
    let id = xml.id_attribute(element, "ref")?;
    xml.close()?;
    xml.refer(element, id);
    Ok(id)
}

/// Appends a reference; one that cannot be read is left out with a diagnostic.
pub(super) fn push_reference<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    into: &mut Vec<i64>,
) -> Result<(), ReadError> {
    into.push(reference(xml, element)?);
    Ok(())
}

/// A word of a known vocabulary; another word gives `fallback` and a diagnostic.
pub(super) fn word<'a, T: Copy + std::fmt::Display>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    parse: fn(&str) -> Option<T>,
    fallback: T,
) -> Result<T, ReadError> {
    let text = xml.text()?;
    if let Some(value) = parse(&text) {
        return Ok(value);
    }
    xml.note(
        Severity::Warning,
        element,
        format!(
            "`{}` is not a known <{}>; taken as {fallback}",
            short(&text),
            element.name
        ),
    );
    Ok(fallback)
}

/// `true` or `false`, in any case, or 1 or 0.
pub(super) fn truth<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    fallback: bool,
) -> Result<bool, ReadError> {
    let text = xml.text()?;
    match text.to_ascii_lowercase().as_str() {
        "true" | "1" => Ok(true),
        "false" | "0" => Ok(false),
        _ => {
            xml.note(
                Severity::Warning,
                element,
                format!(
                    "`{}` is neither true nor false; taken as {fallback}",
                    short(&text)
                ),
            );
            Ok(fallback)
        }
    }
}

/// The shapes inside an element, as one; nothing where there is none.
pub(super) fn shape<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
) -> Result<Option<Shape>, ReadError> {
    let mut shapes = Vec::new();
    collect(xml, 0, &mut shapes)?;
    Ok(builder::union(&xml.at(element), shapes))
}

/// The footprint of an obstacle; one that cannot be measured is left out.
pub(super) fn footprint<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
) -> Result<Option<Footprint>, ReadError> {
    let shape = shape(xml, element)?;
    builder::footprint(&xml.at(element), shape)
}

/// Appends the shapes inside the innermost open element, those of groups one by one.
fn collect(xml: &mut Xml<'_>, depth: usize, into: &mut Vec<Shape>) -> Result<(), ReadError> {
    while let Some(child) = xml.next()? {
        if !push_shape(xml, child, depth, into)? {
            xml.skip_unknown(child)?;
        }
    }
    Ok(())
}

/// Appends the shapes that `child` opens; where it opens none, it is still open and the answer is no.
fn push_shape<'a>(
    xml: &mut Xml<'a>,
    child: Element<'a>,
    depth: usize,
    into: &mut Vec<Shape>,
) -> Result<bool, ReadError> {
    let shape = match child.name {
        "rectangle" => rectangle(xml, child)?,
        "circle" => circle(xml, child)?,
        "polygon" => polygon(xml, child)?,
        "truckShape" => Shape::Truck(obstacles::truck(xml, child)?),
        "semiTrailerTruckShape" => obstacles::semi_trailer_truck(xml, child)?,
        // The schema wraps each member of a group in a separate element.
        "shapeGroup" | "absoluteShapeGroup" | "shape" if depth < DEEPEST_GROUP => {
            collect(xml, depth + 1, into)?;
            return Ok(true);
        }
        _ => return Ok(false),
    };
    into.extend(builder::checked(&xml.at(child), shape)?);
    Ok(true)
}

fn rectangle<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Shape, ReadError> {
    let (mut length, mut width) = (None, None);
    let (mut center, mut orientation, mut shift) = (Point::origin(), 0.0, 0.0);
    while let Some(child) = xml.next()? {
        match child.name {
            "length" => length = Some(xml.size(child)?),
            "width" => width = Some(xml.size(child)?),
            "orientation" => orientation = xml.number(child)?,
            "center" => center = point(xml, child)?,
            "originXShift" => shift = xml.coordinate(child)?,
            _ => xml.skip_unknown(child)?,
        }
    }
    match (length, width) {
        (Some(length), Some(width)) => Ok(Shape::Rectangle {
            length,
            width,
            center,
            orientation,
            origin_x_shift: shift,
        }),
        _ => Err(xml.fail_in(element, "a rectangle needs <length> and <width>".into())),
    }
}

fn circle<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Shape, ReadError> {
    let (mut radius, mut center) = (None, Point::origin());
    while let Some(child) = xml.next()? {
        match child.name {
            "radius" => radius = Some(xml.size(child)?),
            "center" => center = point(xml, child)?,
            _ => xml.skip_unknown(child)?,
        }
    }
    let radius = radius.ok_or_else(|| xml.fail_in(element, "a circle needs <radius>".into()))?;
    Ok(Shape::Circle { radius, center })
}

fn polygon<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Shape, ReadError> {
    let mut vertices = Vec::new();
    while let Some(child) = xml.next()? {
        match child.name {
            "point" => vertices.push(point(xml, child)?),
            _ => xml.skip_unknown(child)?,
        }
        xml.check_count(element, vertices.len(), "points")?;
    }
    Ok(builder::polygon(vertices))
}

/// The value that files write for an unknown place id.
pub(super) const UNKNOWN_ID: i64 = -999;

/// The value that files write for an unknown latitude or longitude.
pub(super) const UNKNOWN_DEGREES: f64 = 999.0;

fn degrees<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Option<f64>, ReadError> {
    let said = xml.optional_number(element)?;
    Ok(said.filter(|degrees| *degrees != UNKNOWN_DEGREES))
}

pub(super) fn location(xml: &mut Xml<'_>) -> Result<Location, ReadError> {
    let mut location = Location::default();
    while let Some(child) = xml.next()? {
        match child.name {
            "geoNameId" => {
                let id = xml.optional_number(child)?.map(|v| v as i64);
                location.geo_name_id = id.filter(|id| *id != UNKNOWN_ID);
            }
            "gpsLatitude" => location.latitude = degrees(xml, child)?,
            "gpsLongitude" => location.longitude = degrees(xml, child)?,
            "geoTransformation" => location.transformation = Some(transformation(xml)?),
            "environment" => location.environment = Some(environment(xml)?),
            _ => xml.skip_unknown(child)?,
        }
    }
    Ok(location)
}

fn transformation(xml: &mut Xml<'_>) -> Result<GeoTransformation, ReadError> {
    let mut found = GeoTransformation::default();
    while let Some(child) = xml.next()? {
        match child.name {
            "geoReference" => {
                found.reference = Some(xml.text()?.into_owned()).filter(|text| !text.is_empty());
            }
            "additionalTransformation" => {
                while let Some(part) = xml.next()? {
                    match part.name {
                        "xTranslation" => found.x = xml.optional_number(part)?,
                        "yTranslation" => found.y = xml.optional_number(part)?,
                        "zRotation" => found.rotation = xml.optional_number(part)?,
                        "scaling" => found.scaling = xml.optional_number(part)?,
                        _ => xml.skip_unknown(part)?,
                    }
                }
            }
            _ => xml.skip_unknown(child)?,
        }
    }
    Ok(found)
}

fn environment(xml: &mut Xml<'_>) -> Result<Environment, ReadError> {
    let mut found = Environment::default();
    while let Some(child) = xml.next()? {
        let word = match child.name {
            "time" => &mut found.time,
            "timeOfDay" => &mut found.time_of_day,
            "weather" => &mut found.weather,
            "underground" => &mut found.underground,
            _ => {
                xml.skip_unknown(child)?;
                continue;
            }
        };
        *word = Some(xml.text()?.into_owned()).filter(|text| !text.is_empty());
    }
    Ok(found)
}

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
fn quantity<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Option<Quantity>, ReadError> {
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
fn position<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Option<Position>, ReadError> {
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
