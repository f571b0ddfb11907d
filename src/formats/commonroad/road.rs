//! The road: lanelets, signs with their numbers, lights and intersections.

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{
    Adjacent, Bound, Incoming, Intersection, Lanelet, LaneletType, LightPhase, LineMarking,
    RoadUser, Severity, Sign, SignElement, SignalColor, StopLine, TrafficDirection, TrafficLight,
};

use super::elements::{point, point_with_height, push_reference, truth, word};
use super::xml::{Element, Xml, short};
use super::{ReadError, builder};

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
                if !is_known(&id) {
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

/// Whether the schema of version 2020a has the sign.
pub(super) fn in_schema(id: &str) -> bool {
    SCHEMA.contains(&id)
}

/// Whether any reader knows the sign.
pub(super) fn is_known(id: &str) -> bool {
    in_schema(id) || BEYOND_SCHEMA.contains(&id)
}

/// Signs that the schema lists.
#[rustfmt::skip]
const SCHEMA: &[&str] = &[
    "1000", "1000-10", "1000-11", "1000-20", "1000-21", "1000-30", "1000-31", "1001-30",
    "1001-31", "1002-10", "1002-11", "1002-12", "1002-13", "1002-14", "1002-20", "1002-21",
    "1002-22", "1002-23", "1002-24", "1004-30", "1004-31", "1004-32", "1004-33", "1004-34",
    "1004-35", "1006-30", "1006-31", "1006-32", "1006-33", "1006-34", "1006-35", "1006-36",
    "1006-37", "1006-38", "1006-39", "1007-31", "101", "1010-10", "1010-11", "1010-12",
    "1010-13", "1010-14", "1012-30", "1012-31", "1012-32", "1012-33", "1012-34", "1012-35",
    "1012-36", "1012-37", "1012-38", "102", "1020-30", "1022-10", "1024-10", "1026-36",
    "1026-37", "1026-38", "103-10", "103-20", "1031-52", "1040-30", "1048-12", "1049-13",
    "1052-31", "1053-33", "1053-34", "1053-35", "108", "114", "123", "124", "125", "131",
    "133-10", "133-20", "138", "142-10", "145-50", "201", "205", "206", "208", "209", "209-10",
    "209-20", "211-20", "2113", "215", "220-10", "220-20", "222-10", "222-20", "223.2",
    "223.2-50", "223.2-51", "224-50", "237", "239", "240", "242.1", "242.2", "244.1", "244.2",
    "245", "250", "251", "253", "254", "255", "257-54", "259", "260", "261", "262", "264",
    "265", "266", "267", "270.1", "270.2", "272", "274", "274.1", "274.2", "275", "276", "277",
    "278", "280", "281", "282", "283-10", "283-30", "286-30", "301", "306", "308", "310", "311",
    "314", "314-10", "314-20", "314-30", "325.1", "325.2", "327", "328", "330.1", "330.2",
    "331.1", "331.2", "332", "332.1", "333", "333-21", "333-22", "350", "354", "356", "357",
    "363", "365-51", "365-52", "365-60", "386.1", "386.2", "386.3", "406-50", "418-20",
    "419-20", "430-20", "432-10", "432-20", "434", "434-50", "438", "439", "440", "448", "449",
    "450-50", "450-51", "450-52", "450-53", "450-54", "450-55", "453", "455.1-30", "458",
    "460-10", "460-12", "460-20", "460-21", "460-22", "460-30", "501-15", "501-16", "511-22",
    "521-30", "521-31", "521-32", "521-33", "525", "531-10", "531-20", "531-21", "533-22",
    "550-20", "600-30", "600-31", "600-32", "600-34", "600-35", "600-38", "605-10", "605-11",
    "605-20", "605-21", "605-31", "625-10", "625-11", "625-12", "625-13", "625-20", "625-21",
    "625-22", "625-23", "626-10", "626-20", "626-30", "626-31", "626-32", "628-10", "629-10",
    "629-20", "720", "CW20-1", "M6-2aL", "R10-7", "R2-1", "R3-1", "R3-2", "R3-27", "R3-4",
    "R3-5L", "R3-5R", "R3-8b", "R4-7", "R5-1", "R6-1L", "R6-1R", "R7-1", "R7-107", "R7-201a",
    "R7-4", "R7-8", "R8-3", "R8-3C", "R8-3gP", "W1-3L", "W1-6L", "W11-2", "W3-3", "W4-2R", "r1",
    "r100", "r101", "r106", "r107", "r2", "r205", "r301", "r305", "r307", "r308", "s13",
];

/// Signs that commonroad-io reads beside them.
#[rustfmt::skip]
const BEYOND_SCHEMA: &[&str] = &[
    "1012-50", "1012-51", "1012-52", "1012-53", "209-30", "3.24", "B14", "B31", "C43", "R1-1",
    "R1-2", "R1-3", "R1-6", "R10-11", "R15", "Ρ-32",
];
