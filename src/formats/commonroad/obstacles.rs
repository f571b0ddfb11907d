//! Obstacles: static, dynamic, phantom and environment.

use super::elements::{footprint, shape, truth, word};
use super::error::ReadError;
use super::states::{state, steps};
use super::xml::{Element, Xml};
use nearmiss_base::geometry::Footprint;
use nearmiss_scene::scenario::{
    ObstacleParts, ObstacleRole, ObstacleType, Occupancy, Prediction, Severity, Signal,
    SignalState, State,
};

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
