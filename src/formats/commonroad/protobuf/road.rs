//! The single message of 2020a with its road: lanelets, signs with their national numbers, lights and intersections.
//!
//! XML files carry the national number (`274`), protobuf an enumeration value: one enumeration a country in 2020a
//! (commonroad-io 2024.3), one for all in 2024 (commonroad-io 2026.1), with the German signs at the same values.
//! Values of signs of 2024 are in the map, and updated in the dynamic file.

use nearmiss_scene::scenario::{
    Adjacent, Bound, ContentHash, Incoming, Intersection, Lanelet, LaneletType, LightPhase,
    LineMarking, RoadUser, Scenario, Sign, SignElement, SignalColor, StopLine, TrafficDirection,
    TrafficLight,
};

use super::messages::traffic_sign_element::Number;
use super::messages::{self, CycleElement, MapSignElement, TrafficSignElement};
use super::report::{FieldPath, Report};
use super::shapes::region;
use super::values::{
    DIRECTIONS, ENVIRONMENT_2020A, Elements, LANELET_TYPES, LINE_MARKINGS, OBSTACLE_TYPES,
    ROAD_USERS, SIGNAL_COLORS, ids,
};
use super::{ONE, header, obstacles};
use crate::commonroad::ReadError;
use crate::commonroad::builder::{self, ScenarioBuilder, SourceLocation};
use crate::commonroad::xml::short;

fn lanelet(at: &FieldPath<'_>, message: &messages::Lanelet) -> Result<Lanelet, ReadError> {
    let border = |name, border: Option<&messages::Bound>| {
        let border = at.need(name, border)?;
        bound(&at.field(name), &border.points, border.line_marking)
    };
    let adjacent = |name, id: Option<u32>, direction: Option<i32>| -> Option<Adjacent> {
        let same = direction.filter(|d| matches!(d, 0 | 1)).map(|d| d == 0);
        Some(builder::adjacent(&at.field(name), id?.into(), same))
    };
    let line = message
        .stop_line
        .as_ref()
        .map(|line| stop_line(&at.field("stop_line"), line));
    let (left, right) = (message.adjacent_left, message.adjacent_right);
    Ok(Lanelet {
        id: at.need("lanelet_id", message.lanelet_id)?.into(),
        left: border("left_bound", message.left_bound.as_ref())?,
        right: border("right_bound", message.right_bound.as_ref())?,
        predecessors: ids(&message.predecessors),
        successors: ids(&message.successors),
        adjacent_left: adjacent("adjacent_left_dir", left, message.adjacent_left_dir),
        adjacent_right: adjacent("adjacent_right_dir", right, message.adjacent_right_dir),
        stop_line: line.transpose()?,
        types: types(at, &message.lanelet_types),
        users_one_way: users(at, "user_one_way", &message.user_one_way),
        users_bidirectional: users(at, "user_bidirectional", &message.user_bidirectional),
        signs: ids(&message.traffic_sign_refs),
        lights: ids(&message.traffic_light_refs),
    })
}

pub(super) fn types(at: &FieldPath<'_>, numbers: &[i32]) -> Vec<LaneletType> {
    at.names(
        "lanelet_types",
        LANELET_TYPES,
        numbers,
        LaneletType::Unknown,
    )
}

pub(super) fn users(at: &FieldPath<'_>, name: &str, numbers: &[i32]) -> Vec<RoadUser> {
    at.names(name, ROAD_USERS, numbers, RoadUser::Vehicle)
}

/// A border of at least two points.
pub(super) fn bound(
    at: &FieldPath<'_>,
    points: &[messages::Point],
    marking: Option<i32>,
) -> Result<Bound, ReadError> {
    let (points, heights) = at.points(points)?;
    let unknown = LineMarking::Unknown;
    let marking = marking.map_or(unknown, |number| {
        at.field("line_marking")
            .word_or(LINE_MARKINGS, number, unknown)
    });
    builder::bound(at, points, heights, marking)
}

/// A line marking.
pub(super) fn marking(at: &FieldPath<'_>, number: Option<i32>) -> Result<LineMarking, ReadError> {
    at.needed_word("line_marking", LINE_MARKINGS, number, LineMarking::Unknown)
}

fn stop_line(at: &FieldPath<'_>, message: &messages::StopLine) -> Result<StopLine, ReadError> {
    let (points, heights) = at.points(&message.points)?;
    if !heights.is_empty() {
        at.no_place_for("points/z");
    }
    Ok(StopLine {
        points: builder::stop_line(at, &points),
        marking: marking(at, message.line_marking)?,
        signs: ids(&message.traffic_sign_refs),
        lights: ids(&message.traffic_light_refs),
    })
}

fn sign(at: &FieldPath<'_>, message: &messages::TrafficSign) -> Result<Sign, ReadError> {
    let elements = message
        .traffic_sign_elements
        .iter()
        .enumerate()
        .map(|(i, element)| sign_element(&at.nth("traffic_sign_elements", i), element));
    if !message.first_occurrences.is_empty() {
        at.no_place_for("first_occurrences");
    }
    Ok(Sign {
        id: at.need("traffic_sign_id", message.traffic_sign_id)?.into(),
        elements: elements.collect::<Result<_, _>>()?,
        position: at.optional_point("position", message.position.as_ref())?,
        is_virtual: message.is_virtual.unwrap_or(false),
    })
}

fn sign_element(
    at: &FieldPath<'_>,
    message: &TrafficSignElement,
) -> Result<SignElement, ReadError> {
    let number = message
        .number
        .ok_or_else(|| at.fail("does not say which sign it is"))?;
    let id = sign_of_2020a(number);
    if id.is_none() {
        at.warn("an unknown sign; its number was left empty");
    }
    Ok(SignElement {
        id: id.unwrap_or_default().to_string(),
        values: at.texts("additional_values", &message.additional_values),
    })
}

fn light(at: &FieldPath<'_>, message: &messages::TrafficLight) -> Result<TrafficLight, ReadError> {
    Ok(TrafficLight {
        id: at
            .need("traffic_light_id", message.traffic_light_id)?
            .into(),
        cycle: cycle(at, &message.cycle_elements)?,
        offset: message.time_offset.unwrap_or(0).into(),
        position: at.optional_point("position", message.position.as_ref())?,
        direction: direction(at, message.direction),
        active: message.active.unwrap_or(true),
    })
}

pub(super) fn direction(at: &FieldPath<'_>, number: Option<i32>) -> Option<TrafficDirection> {
    let at = at.field("direction");
    number.map(|n| at.word_or(DIRECTIONS, n, TrafficDirection::All))
}

pub(super) fn cycle(
    at: &FieldPath<'_>,
    elements: &[CycleElement],
) -> Result<Vec<LightPhase>, ReadError> {
    let phase = |(i, element): (usize, &CycleElement)| {
        let (at, inactive) = (at.nth("cycle_elements", i), SignalColor::Inactive);
        Ok(LightPhase {
            duration: at.need("duration", element.duration)?.into(),
            color: at.needed_word("color", SIGNAL_COLORS, element.color, inactive)?,
        })
    };
    elements.iter().enumerate().map(phase).collect()
}

fn intersection(
    at: &FieldPath<'_>,
    message: &messages::Intersection,
) -> Result<Intersection, ReadError> {
    let incoming = |(i, road): (usize, &messages::Incoming)| {
        let id = at
            .nth("incomings", i)
            .need("incoming_id", road.incoming_id)?;
        Ok(Incoming {
            id: id.into(),
            lanelets: ids(&road.incoming_lanelets),
            right: ids(&road.successors_right),
            straight: ids(&road.successors_straight),
            left: ids(&road.successors_left),
            is_left_of: road.is_left_of.map(i64::from),
        })
    };
    let incomings = message.incomings.iter().enumerate().map(incoming);
    Ok(Intersection {
        incomings: incomings.collect::<Result<_, ReadError>>()?,
        id: at.need("intersection_id", message.intersection_id)?.into(),
        crossings: ids(&message.crossing_lanelets),
    })
}

/// Reads the message.
pub(super) fn read(bytes: &[u8], file: &str) -> Result<Scenario, ReadError> {
    let report = Report::about(file);
    let root = FieldPath::root(&report, "");
    let mut builder = ScenarioBuilder::default();
    let (mut header, mut tags, mut location) = (None, None, None);
    let mut elements = Elements::new(&root, &mut builder);
    root.each_field(bytes, |field| match field.number {
        1 => {
            let at = root.field("information");
            at.part(field, &mut header, header::of_2020a)
        }
        2 => {
            let at = root.field("scenario_tags");
            at.part(field, &mut tags, |at, m| Ok(obstacles::tags(at, m)))
        }
        3 => {
            let at = root.field("location");
            at.part(field, &mut location, |at, m| {
                header::location(at, m, &ENVIRONMENT_2020A)
            })
        }
        4 => elements.add("lanelets", field, |builder, at, m| {
            builder.lanelet(at, lanelet(at, m)?);
            Ok(())
        }),
        5 => elements.add("traffic_signs", field, |builder, at, m| {
            builder.sign(at, sign(at, m)?);
            Ok(())
        }),
        6 => elements.add("traffic_lights", field, |builder, at, m| {
            builder.light(at, light(at, m)?);
            Ok(())
        }),
        7 => elements.add("intersections", field, |builder, at, m| {
            builder.intersection(at, intersection(at, m)?);
            Ok(())
        }),
        8 => elements.add("static_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::fixed(at, m, region)?);
            Ok(())
        }),
        9 => elements.add("dynamic_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::moving(at, m, region)?);
            Ok(())
        }),
        10 => elements.add("environment_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::environment(at, m, OBSTACLE_TYPES)?);
            Ok(())
        }),
        11 => elements.add("phantom_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::phantom(at, m)?);
            Ok(())
        }),
        12 => elements.add("planning_problems", field, |builder, at, m| {
            builder.problem(at, obstacles::problem(at, m)?);
            Ok(())
        }),
        _ => {
            root.skip_unknown(field);
            Ok(())
        }
    })?;
    let header = root.need("information", header)?;
    builder.tags = root.need("scenario_tags", tags)?;
    builder.location = Some(root.need("location", location)?);
    let scenario = builder.finish(header, ContentHash::digest(bytes));
    Ok(super::finish(report, &ONE, scenario))
}

/// German signs by their place in the enumerations; Zamunda, the country of made-up scenarios, has the same.
/// Place 200 is not used.
const GERMANY: [&str; 241] = [
    "101", "102", "103-10", "103-20", "108", "114", "123", "124", "125", "131", "133-10", "133-20",
    "138", "142-10", "145-50", "201", "205", "206", "208", "209-10", "209-20", "209-30", "211-20",
    "215", "220-10", "220-20", "222-10", "222-20", "223.2", "223.2-50", "223.2-51", "224-50",
    "237", "239", "240", "242.1", "242.2", "244.1", "244.2", "245", "250", "251", "253", "254",
    "255", "257-54", "259", "260", "261", "262", "264", "265", "266", "267", "270.1", "270.2",
    "272", "274", "274.1", "274.2", "275", "276", "277", "278", "280", "281", "282", "283-10",
    "283-30", "286-30", "301", "306", "308", "310", "311", "314", "314-10", "314-20", "314-30",
    "325.1", "325.2", "327", "328", "330.1", "330.2", "331.1", "331.2", "332", "332.1", "333",
    "333-21", "333-22", "350", "354", "356", "357", "363", "365-51", "365-52", "365-60", "386.1",
    "386.2", "386.3", "406-50", "418-20", "419-20", "434-50", "430-20", "432-10", "432-20", "434",
    "438", "439", "440", "448", "449", "450-50", "450-51", "450-52", "450-53", "450-54", "450-55",
    "453", "458", "455.1-30", "460-10", "460-12", "460-20", "460-21", "460-22", "460-30", "501-15",
    "501-16", "511-22", "521-30", "521-31", "521-32", "521-33", "525", "531-10", "531-20",
    "531-21", "533-22", "550-20", "600-35", "600-30", "600-31", "600-32", "600-34", "600-38",
    "605-10", "605-11", "605-20", "605-21", "605-31", "625-10", "625-11", "625-12", "625-13",
    "625-20", "625-21", "625-22", "625-23", "626-10", "626-20", "626-30", "626-31", "628-10",
    "629-10", "629-20", "720", "1000", "1000-10", "1000-11", "1000-20", "1000-21", "1000-30",
    "1000-31", "1001-30", "1001-31", "1002-10", "1002-11", "1002-12", "1002-13", "1002-14",
    "1002-20", "1002-21", "1002-22", "1002-23", "1002-24", "1004-30", "1004-31", "1004-32",
    "1004-33", "1004-34", "1004-35", "1006-30", "1006-31", "1006-32", "1006-33", "", "1006-34",
    "1006-35", "1006-36", "1006-37", "1006-38", "1006-39", "1007-31", "1010-10", "1010-11",
    "1010-12", "1010-13", "1010-14", "1012-30", "1012-31", "1012-32", "1012-33", "1012-34",
    "1012-35", "1012-36", "1012-37", "1012-38", "1012-50", "1012-51", "1012-52", "1012-53",
    "1020-30", "1022-10", "1024-10", "1026-36", "1026-37", "1026-38", "1031-52", "1040-30",
    "1048-12", "1049-13", "1052-31", "1053-33", "1053-34", "1053-35", "2113",
];

/// American signs of 2020a.
const USA: [&str; 28] = [
    "R2-1", "R3-4", "CW20-1", "R7-1", "R7-4", "R7-201a", "R6-1L", "R6-1R", "R5-1", "R3-2", "R3-5R",
    "R3-8b", "R3-1", "R4-7", "W3-3", "R8-3gP", "R8-3", "R3-5L", "R3-27", "W1-3L", "W11-2",
    "M6-2aL", "W4-2R", "R7-8", "R7-107", "R8-3C", "R10-7", "W1-6L",
];

/// Spanish signs of 2020a.
const SPAIN: [&str; 12] = [
    "r1", "r2", "r100", "r101", "r106", "r107", "r205", "r301", "r305", "r307", "r308", "s13",
];

/// The places of 2024 that other countries than Germany have signs for.
const COUNTRIES_2024: [(&str, &[(i32, &str)]); 12] = [
    (
        "USA",
        &[
            (17, "R1-1"),
            (56, "R3-4"),
            (57, "R2-1"),
            (241, "R1-3"),
            (242, "R10-11"),
            (243, "R1-6"),
        ],
    ),
    ("CHN", &[(57, "274")]),
    (
        "ESP",
        &[
            (16, "r1"),
            (17, "r2"),
            (40, "r100"),
            (42, "r106"),
            (49, "r107"),
            (51, "r205"),
            (53, "r101"),
            (57, "r301"),
            (61, "r305"),
            (92, "s13"),
        ],
    ),
    ("RUS", &[(57, "3.24")]),
    ("ARG", &[(57, "R15")]),
    ("BEL", &[(57, "C43")]),
    ("FRA", &[(57, "B14")]),
    ("GRC", &[(57, "Ρ-32")]),
    ("HRV", &[(57, "B31")]),
    ("ITA", &[(57, "274")]),
    ("PRI", &[(57, "R2-1")]),
    ("AUS", &[(16, "R1-2"), (17, "R1-1"), (92, "R3-1")]),
];

/// The country's number of a sign of 2020a; `None` for the enumeration's last place, which is an unknown sign, and
/// for places that it has not.
fn sign_of_2020a(number: Number) -> Option<&'static str> {
    let (signs, place): (&[&'static str], i32) = match number {
        Number::Germany(place) | Number::Zamunda(place) => (&GERMANY, place),
        Number::Usa(place) => (&USA, place),
        Number::Spain(place) => (&SPAIN, place),
        // Of these only the sign for a maximum speed exists.
        Number::China(place) | Number::Italy(place) => (&["274"], place),
        Number::Russia(place) => (&["3.24"], place),
        Number::Argentina(place) => (&["R15"], place),
        Number::Belgium(place) => (&["C43"], place),
        Number::France(place) => (&["B14"], place),
        Number::Greece(place) => (&["Ρ-32"], place),
        Number::Croatia(place) => (&["B31"], place),
        Number::PuertoRico(place) => (&["R2-1"], place),
    };
    at(signs, place)
}

/// A sign of 2024 in a country.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sign2024 {
    /// The country's number.
    Own(&'static str),
    /// The German number: the country has none for this sign, or is not known.
    German(&'static str),
    /// The sign does not exist.
    Unknown,
}

/// The sign at a place of the enumeration of 2024; `country` is the three letters of the map's id.
fn of_2024(country: &str, place: i32) -> Sign2024 {
    let german = at(&GERMANY, place);
    if matches!(country, "DEU" | "ZAM") {
        return german.map_or(Sign2024::Unknown, Sign2024::Own);
    }
    let known = COUNTRIES_2024.iter().find(|(name, _)| *name == country);
    let own = known.and_then(|(_, signs)| signs.iter().find(|(p, _)| *p == place));
    match (own, german) {
        (Some((_, sign)), _) => Sign2024::Own(sign),
        (None, Some(sign)) => Sign2024::German(sign),
        (None, None) => Sign2024::Unknown,
    }
}

fn at(signs: &[&'static str], place: i32) -> Option<&'static str> {
    let sign = usize::try_from(place).ok().and_then(|p| signs.get(p));
    sign.copied().filter(|s| !s.is_empty())
}

/// The sign elements on a post; `country` is that of the map.
pub(super) fn sign_elements(
    at: &FieldPath<'_>,
    messages: &[MapSignElement],
    country: &str,
) -> Result<Vec<SignElement>, ReadError> {
    let element = |(i, message): (usize, &MapSignElement)| {
        let at = at.nth("traffic_sign_elements", i);
        let place = at.need("element_id", message.element_id)?;
        let id = match of_2024(country, place) {
            Sign2024::Own(id) => id,
            Sign2024::German(id) => {
                let country = short(country);
                at.warn(format!(
                    "{country} has no number for this sign; the German {id} is used"
                ));
                id
            }
            Sign2024::Unknown => {
                at.warn("an unknown sign; its number was left empty");
                ""
            }
        };
        Ok(SignElement {
            id: id.to_string(),
            values: at.texts("additional_values", &message.additional_values),
        })
    };
    messages.iter().enumerate().map(element).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_for_a_maximum_speed_in_every_country() {
        assert_eq!(sign_of_2020a(Number::Germany(57)), Some("274"));
        assert_eq!(sign_of_2020a(Number::Zamunda(57)), Some("274"));
        assert_eq!(sign_of_2020a(Number::Usa(0)), Some("R2-1"));
        assert_eq!(sign_of_2020a(Number::Spain(7)), Some("r301"));
        assert_eq!(sign_of_2020a(Number::France(0)), Some("B14"));
        for (country, sign) in [
            ("DEU", "274"),
            ("ZAM", "274"),
            ("USA", "R2-1"),
            ("ESP", "r301"),
            ("FRA", "B14"),
        ] {
            assert_eq!(of_2024(country, 57), Sign2024::Own(sign), "{country}");
        }
    }

    #[test]
    fn places_without_a_sign() {
        for place in [-1, 200, 241, 1_000_000] {
            assert_eq!(sign_of_2020a(Number::Germany(place)), None, "{place}");
            assert_eq!(of_2024("DEU", place), Sign2024::Unknown, "{place}");
        }
        assert_eq!(sign_of_2020a(Number::Usa(28)), None);
        assert_eq!(of_2024("USA", 241), Sign2024::Own("R1-3"));
        assert_eq!(of_2024("USA", 71), Sign2024::German("306"));
        assert_eq!(of_2024("XYZ", 57), Sign2024::German("274"));
    }
}
