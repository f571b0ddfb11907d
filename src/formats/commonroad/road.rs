//! The road: lanelets, signs, lights and intersections.

use super::builder;
use super::elements::{point, point_with_height, push_reference, truth, word};
use super::error::ReadError;
use super::sign_ids;
use super::xml::{Element, Xml, short};
use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{
    Adjacent, Bound, Incoming, Intersection, Lanelet, LaneletType, LightPhase, LineMarking,
    RoadUser, Severity, Sign, SignElement, SignalColor, StopLine, TrafficDirection, TrafficLight,
};

pub(super) fn lanelet<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Lanelet, ReadError> {
    let (mut left, mut right) = (None, None);
    let mut lanelet = Lanelet {
        id: xml.id_attribute(element, "id")?,
        ..Lanelet::default()
    };
    while let Some(child) = xml.next()? {
        match child.name {
            "leftBound" => left = Some(bound(xml, child)?),
            "rightBound" => right = Some(bound(xml, child)?),
            "predecessor" => push_reference(xml, child, &mut lanelet.predecessors)?,
            "successor" => push_reference(xml, child, &mut lanelet.successors)?,
            // So misspelt by the first releases of scenarios.
            "succecessor" => {
                xml.note(Severity::Note, child, "taken as <successor>".into());
                push_reference(xml, child, &mut lanelet.successors)?;
            }
            "adjacentLeft" => lanelet.adjacent_left = Some(adjacent(xml, child)?),
            "adjacentRight" => lanelet.adjacent_right = Some(adjacent(xml, child)?),
            "stopLine" => lanelet.stop_line = Some(stop_line(xml, child)?),
            "laneletType" => {
                lanelet
                    .types
                    .push(word(xml, child, LaneletType::parse, LaneletType::Unknown)?);
            }
            "userOneWay" => {
                lanelet
                    .users_one_way
                    .push(word(xml, child, RoadUser::parse, RoadUser::Vehicle)?);
            }
            "userBidirectional" => {
                let user = word(xml, child, RoadUser::parse, RoadUser::Vehicle)?;
                lanelet.users_bidirectional.push(user);
            }
            "trafficSignRef" => push_reference(xml, child, &mut lanelet.signs)?,
            "trafficLightRef" => push_reference(xml, child, &mut lanelet.lights)?,
            "speedLimit" => {
                let limit = xml.any_number(child)?;
                xml.limit_speed(lanelet.id, limit, child);
            }
            _ => xml.skip_unknown(child)?,
        }
    }
    let (Some(left), Some(right)) = (left, right) else {
        let message = "a lanelet needs <leftBound> and <rightBound>";
        return Err(xml.fail_in(element, message.into()));
    };
    Ok(Lanelet {
        left,
        right,
        ..lanelet
    })
}

fn bound<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Bound, ReadError> {
    let (mut points, mut heights) = (Vec::new(), Vec::new());
    let mut marking = LineMarking::Unknown;
    while let Some(child) = xml.next()? {
        match child.name {
            "point" => {
                let (at, height) = point_with_height(xml, child)?;
                points.push(at);
                heights.extend(height);
            }
            "lineMarking" => marking = word(xml, child, LineMarking::parse, LineMarking::Unknown)?,
            _ => xml.skip_unknown(child)?,
        }
        xml.check_count(element, points.len(), "points")?;
    }
    builder::bound(&xml.at(element), points, heights, marking)
}

fn adjacent<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Adjacent, ReadError> {
    let id = xml.id_attribute(element, "ref")?;
    let same_direction = match xml.attribute(element, "drivingDir").as_deref() {
        Some("same") => Some(true),
        Some("opposite") => Some(false),
        _ => None,
    };
    let adjacent = builder::adjacent(&xml.at(element), id, same_direction);
    xml.close()?;
    xml.refer(element, id);
    Ok(adjacent)
}

fn stop_line<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<StopLine, ReadError> {
    let mut points: Vec<Point> = Vec::new();
    let mut line = StopLine {
        points: None,
        marking: LineMarking::Unknown,
        signs: Vec::new(),
        lights: Vec::new(),
    };
    while let Some(child) = xml.next()? {
        match child.name {
            "point" => points.push(point(xml, child)?),
            "lineMarking" => {
                line.marking = word(xml, child, LineMarking::parse, LineMarking::Unknown)?;
            }
            "trafficSignRef" => push_reference(xml, child, &mut line.signs)?,
            "trafficLightRef" => push_reference(xml, child, &mut line.lights)?,
            _ => xml.skip_unknown(child)?,
        }
    }
    line.points = builder::stop_line(&xml.at(element), &points);
    Ok(line)
}

pub(super) fn sign<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Sign, ReadError> {
    let mut sign = Sign {
        id: xml.id_attribute(element, "id")?,
        elements: Vec::new(),
        position: None,
        is_virtual: xml
            .attribute(element, "virtual")
            .is_some_and(|v| v == "true"),
    };
    while let Some(child) = xml.next()? {
        match child.name {
            "trafficSignElement" => {
                let (mut id, mut values) = (String::new(), Vec::new());
                while let Some(part) = xml.next()? {
                    match part.name {
                        "trafficSignID" => id = xml.text()?.into_owned(),
                        "additionalValue" => values.push(xml.text()?.into_owned()),
                        _ => xml.skip_unknown(part)?,
                    }
                }
                if !sign_ids::is_known(&id) {
                    let message = format!("unknown traffic sign `{}`", short(&id));
                    xml.note(Severity::Note, child, message);
                }
                sign.elements.push(SignElement { id, values });
            }
            "position" => sign.position = place(xml)?,
            "virtual" => sign.is_virtual = truth(xml, child, false)?,
            _ => xml.skip_unknown(child)?,
        }
    }
    Ok(sign)
}

pub(super) fn light<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
) -> Result<TrafficLight, ReadError> {
    let mut light = TrafficLight {
        id: xml.id_attribute(element, "id")?,
        cycle: Vec::new(),
        offset: 0,
        position: None,
        direction: None,
        active: true,
    };
    while let Some(child) = xml.next()? {
        match child.name {
            "cycle" => {
                while let Some(part) = xml.next()? {
                    match part.name {
                        "cycleElement" => light.cycle.push(phase(xml, part)?),
                        "timeOffset" => light.offset = xml.steps(part)?,
                        _ => xml.skip_unknown(part)?,
                    }
                }
            }
            "position" => light.position = place(xml)?,
            "direction" => {
                let all = TrafficDirection::All;
                light.direction = Some(word(xml, child, TrafficDirection::parse, all)?);
            }
            "active" => light.active = truth(xml, child, true)?,
            _ => xml.skip_unknown(child)?,
        }
    }
    Ok(light)
}

fn phase<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<LightPhase, ReadError> {
    let (mut duration, mut color) = (None, SignalColor::Inactive);
    while let Some(child) = xml.next()? {
        match child.name {
            "duration" => duration = Some(xml.steps(child)?),
            "color" => color = word(xml, child, SignalColor::parse, SignalColor::Inactive)?,
            _ => xml.skip_unknown(child)?,
        }
    }
    let duration =
        duration.ok_or_else(|| xml.fail_in(element, "a phase needs <duration>".into()))?;
    Ok(LightPhase { duration, color })
}

fn place(xml: &mut Xml<'_>) -> Result<Option<Point>, ReadError> {
    let mut found = None;
    while let Some(child) = xml.next()? {
        match child.name {
            "point" => found = Some(point(xml, child)?),
            _ => xml.skip_unknown(child)?,
        }
    }
    Ok(found)
}

pub(super) fn intersection<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
) -> Result<Intersection, ReadError> {
    let mut intersection = Intersection {
        id: xml.id_attribute(element, "id")?,
        incomings: Vec::new(),
        crossings: Vec::new(),
    };
    while let Some(child) = xml.next()? {
        match child.name {
            "incoming" => intersection.incomings.push(incoming(xml, child)?),
            "crossing" => {
                while let Some(part) = xml.next()? {
                    match part.name {
                        "crossingLanelet" => {
                            push_reference(xml, part, &mut intersection.crossings)?;
                        }
                        _ => xml.skip_unknown(part)?,
                    }
                }
            }
            _ => xml.skip_unknown(child)?,
        }
    }
    Ok(intersection)
}

fn incoming<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Incoming, ReadError> {
    let mut road = Incoming {
        id: xml.id_attribute(element, "id")?,
        ..Incoming::default()
    };
    while let Some(child) = xml.next()? {
        match child.name {
            "incomingLanelet" => push_reference(xml, child, &mut road.lanelets)?,
            "successorsRight" => push_reference(xml, child, &mut road.right)?,
            "successorsStraight" => push_reference(xml, child, &mut road.straight)?,
            "successorsLeft" => push_reference(xml, child, &mut road.left)?,
            "isLeftOf" => {
                let mut ids = Vec::new();
                push_reference(xml, child, &mut ids)?;
                road.is_left_of = ids.pop();
            }
            _ => xml.skip_unknown(child)?,
        }
    }
    Ok(road)
}
