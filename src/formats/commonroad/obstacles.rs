//! Obstacles: static, dynamic, phantom and environment; trucks and semi-trailer trucks.
//!
//! Trucks and semi-trailer trucks, part of version 2020a since 2026.

use nearmiss_base::geometry::{Footprint, SemiTrailer, Shape, Truck};
use nearmiss_scene::scenario::{
    ObstacleParts, ObstacleRole, ObstacleType, Occupancy, Prediction, Severity, Signal,
    SignalState, State,
};

use super::elements::{footprint, shape, state, steps, truth, word};
use super::writer::{WriteError, XmlWriter, number};
use super::xml::{Element, Xml};
use super::{ReadError, builder};

/// An obstacle; `role` is what its element's name says, `None` for the 2018b element with a `<role>`.
pub(super) fn obstacle<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    mut role: Option<ObstacleRole>,
) -> Result<ObstacleParts, ReadError> {
    let id = xml.id_attribute(element, "id")?;
    let mut kind = ObstacleType::Unknown;
    let mut body: Option<Footprint> = None;
    let mut initial: Option<State> = None;
    let mut prediction = Prediction::None;
    let mut signals = Vec::new();
    while let Some(child) = xml.next()? {
        match child.name {
            "role" => {
                role = Some(word(
                    xml,
                    child,
                    ObstacleRole::parse,
                    ObstacleRole::Dynamic,
                )?)
            }
            "type" => kind = word(xml, child, ObstacleType::parse, ObstacleType::Unknown)?,
            "shape" => body = footprint(xml, child)?,
            "initialSignalState" => signals.extend(signal_state(xml, child)?),
            "signalSeries" => {
                while let Some(part) = xml.next()? {
                    match part.name {
                        "signalState" => signals.extend(signal_state(xml, part)?),
                        _ => xml.skip_unknown(part)?,
                    }
                }
            }
            "initialState" => {
                if initial.is_some() {
                    let message = "a second initial state; it replaces the first".into();
                    xml.note(Severity::Warning, child, message);
                }
                initial = Some(state(xml, child, true)?);
            }
            "trajectory" | "occupancySet" => {
                if prediction != Prediction::None {
                    let message = "a second prediction; it replaces the first".into();
                    xml.note(Severity::Warning, child, message);
                }
                prediction = match child.name {
                    "trajectory" => Prediction::Trajectory(trajectory(xml, child)?),
                    _ => Prediction::Occupancies(occupancies(xml, child)?),
                };
            }
            _ => xml.skip_unknown(child)?,
        }
    }
    let role = role.unwrap_or_else(|| {
        xml.note(
            Severity::Warning,
            element,
            "no role; taken as dynamic".into(),
        );
        ObstacleRole::Dynamic
    });
    Ok(ObstacleParts {
        id,
        role,
        kind,
        footprint: body,
        initial,
        prediction,
        signals,
    })
}

fn signal_state<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
) -> Result<Option<SignalState>, ReadError> {
    let (mut time, mut signals) = (None, Vec::new());
    while let Some(child) = xml.next()? {
        match (child.name, Signal::parse(child.name)) {
            ("time", _) => time = Some(steps(xml, child)?),
            (_, Some(signal)) => signals.push((signal, truth(xml, child, false)?)),
            _ => xml.skip_unknown(child)?,
        }
    }
    if time.is_none() {
        let message = "a signal state without a time was left out".into();
        xml.note(Severity::Warning, element, message);
    }
    Ok(time.map(|time| SignalState { time, signals }))
}

fn trajectory<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Vec<State>, ReadError> {
    let mut states = Vec::new();
    while let Some(child) = xml.next()? {
        match child.name {
            "state" => states.push(state(xml, child, false)?),
            _ => xml.skip_unknown(child)?,
        }
        xml.check_count(element, states.len(), "states")?;
    }
    Ok(states)
}

fn occupancies<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Vec<Occupancy>, ReadError> {
    let mut found = Vec::new();
    while let Some(child) = xml.next()? {
        match child.name {
            "occupancy" => found.extend(occupancy(xml, child)?),
            _ => xml.skip_unknown(child)?,
        }
        xml.check_count(element, found.len(), "occupancies")?;
    }
    Ok(found)
}

fn occupancy<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Option<Occupancy>, ReadError> {
    let (mut time, mut region) = (None, None);
    while let Some(child) = xml.next()? {
        match child.name {
            "time" => time = Some(steps(xml, child)?),
            "shape" | "absoluteShape" => region = shape(xml, child)?,
            _ => xml.skip_unknown(child)?,
        }
    }
    let both = time.zip(region);
    if both.is_none() {
        xml.note(
            Severity::Warning,
            element,
            "no time or shape; left out".into(),
        );
    }
    Ok(both.map(|(time, region)| Occupancy { time, region }))
}

/// `<truckShape>`: the dimensions, and where its origin is.
pub(super) fn truck<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Truck, ReadError> {
    let (mut dimensions, mut shift) = (None, None);
    while let Some(child) = xml.next()? {
        match child.name {
            "truckDims" => dimensions = Some(numbers(xml, child, TRUCK)?),
            "originXShift" => shift = Some(xml.coordinate(child)?),
            _ => xml.skip_unknown(child)?,
        }
    }
    let Some(dimensions) = dimensions else {
        return Err(xml.fail_in(element, "a truck needs <truckDims>".into()));
    };
    if shift.is_none() {
        let message = "no <originXShift>; its states are assumed to be at the rear axle";
        xml.note(Severity::Warning, element, message.into());
    }
    Ok(builder::truck(dimensions, shift))
}

/// `<semiTrailerTruckShape>`: a truck and the dimensions of its trailer.
pub(super) fn semi_trailer_truck<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
) -> Result<Shape, ReadError> {
    let (mut tractor, mut trailer) = (None, None);
    while let Some(child) = xml.next()? {
        match child.name {
            "truckShape" => tractor = Some(truck(xml, child)?),
            "trailerDims" => trailer = Some(numbers(xml, child, TRAILER)?),
            _ => xml.skip_unknown(child)?,
        }
    }
    match (tractor, trailer) {
        (Some(tractor), Some(trailer)) => Ok(builder::semi_trailer_truck(tractor, trailer)),
        _ => {
            let message = "a semi-trailer truck needs <truckShape> and <trailerDims>";
            Err(xml.fail_in(element, message.into()))
        }
    }
}

/// The dimensions of a truck, in the builder's order.
const TRUCK: [&str; 6] = [
    "length",
    "width",
    "wheelbase",
    "distFromRearToRearAxle",
    "cabinLength",
    "distFromRearAxleToHitch",
];

/// The dimensions of a trailer, in the builder's order.
const TRAILER: [&str; 4] = ["length", "width", "wheelbase", "distFromFrontToHitch"];

/// The numbers in the children of these names, all of which must be there.
fn numbers<'a, const N: usize>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    names: [&str; N],
) -> Result<[f64; N], ReadError> {
    let mut found = [None; N];
    while let Some(child) = xml.next()? {
        match names.iter().position(|name| *name == child.name) {
            Some(place) => {
                let value = match child.name {
                    "length" | "width" => xml.size(child)?,
                    _ => xml.coordinate(child)?,
                };
                found[place] = Some(value);
            }
            None => xml.skip_unknown(child)?,
        }
    }
    let mut numbers = [0.0; N];
    for ((number, found), name) in numbers.iter_mut().zip(found).zip(names) {
        *number = found.ok_or_else(|| xml.fail_in(element, format!("it needs <{name}>")))?;
    }
    Ok(numbers)
}

/// `<truckShape>`.
pub(super) fn write_truck(out: &mut XmlWriter, truck: &Truck) -> Result<(), WriteError> {
    out.element("truckShape", &[], |out| {
        out.element("truckDims", &[], |out| {
            out.leaf("length", &number(truck.length))?;
            out.leaf("width", &number(truck.width))?;
            out.leaf("wheelbase", &number(truck.wheelbase))?;
            out.leaf("distFromRearToRearAxle", &number(truck.rear_to_rear_axle))?;
            out.leaf("cabinLength", &number(truck.cabin_length))?;
            out.leaf("distFromRearAxleToHitch", &number(truck.rear_axle_to_hitch))
        })?;
        out.leaf("originXShift", &number(truck.origin_x_shift))
    })
}

/// `<semiTrailerTruckShape>`.
pub(super) fn write_semi_trailer_truck(
    out: &mut XmlWriter,
    tractor: &Truck,
    trailer: &SemiTrailer,
) -> Result<(), WriteError> {
    out.element("semiTrailerTruckShape", &[], |out| {
        write_truck(out, tractor)?;
        out.element("trailerDims", &[], |out| {
            out.leaf("length", &number(trailer.length))?;
            out.leaf("width", &number(trailer.width))?;
            out.leaf("wheelbase", &number(trailer.wheelbase))?;
            out.leaf("distFromFrontToHitch", &number(trailer.front_to_hitch))
        })
    })
}
