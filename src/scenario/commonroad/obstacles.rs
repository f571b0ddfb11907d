//! Obstacles: static, dynamic, phantom and environment.

use super::elements::{footprint, shape, truth, word};
use super::error::ReadError;
use super::states::{state, steps};
use super::xml::{Element, Xml};
use crate::geometry::Footprint;
use crate::scenario::{
    LONGEST_TRACK, Obstacle, ObstacleParts, ObstacleRole, ObstacleType, Occupancy, Prediction,
    Severity, Signal, SignalState, State,
};

/// An obstacle; `role` is what its element's name says, `None` for the 2018b element with a `<role>`.
pub(super) fn obstacle<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    mut role: Option<ObstacleRole>,
    dt: f64,
) -> Result<Obstacle, ReadError> {
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
            "initialState" => initial = Some(state(xml, child, true)?),
            "trajectory" | "occupancySet" => {
                if prediction != Prediction::None {
                    let message = "a second prediction; it replaces the first".into();
                    xml.note(Severity::Warning, child, message);
                }
                prediction = match child.name {
                    "trajectory" => Prediction::Trajectory(trajectory(xml)?),
                    _ => Prediction::Occupancies(occupancies(xml)?),
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
    let bodily = matches!(role, ObstacleRole::Static | ObstacleRole::Dynamic);
    if bodily && body.is_none() {
        xml.note(
            Severity::Warning,
            element,
            "no shape; it is not measured".into(),
        );
    }
    if bodily && initial.is_none() {
        xml.note(Severity::Warning, element, "no initial state".into());
    }
    check_times(xml, element, initial.as_ref(), &prediction);
    let parts = ObstacleParts {
        id,
        role,
        kind,
        footprint: body,
        initial,
        prediction,
        signals,
    };
    if let Some(message) = parts.uncertainty() {
        xml.note(Severity::Warning, element, message);
    }
    let obstacle = Obstacle::new(parts, dt);
    if let Some(jump) = obstacle.track().jump(dt) {
        xml.note(Severity::Warning, element, format!("obstacle {id}: {jump}"));
    }
    Ok(obstacle)
}

/// Notes states whose times make them useless.
fn check_times<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    initial: Option<&State>,
    prediction: &Prediction,
) {
    let Prediction::Trajectory(later) = prediction else {
        return;
    };
    let mut steps: Vec<i64> = initial
        .iter()
        .copied()
        .chain(later)
        .map(|s| s.time.from)
        .collect();
    let in_order = steps.is_sorted();
    steps.sort_unstable();
    let mut say = |message: String| xml.note(Severity::Warning, element, message);
    if let Some(twice) = steps.windows(2).find(|pair| pair[0] == pair[1]) {
        say(format!(
            "time step {} has two states; the first counts",
            twice[0]
        ));
    } else if !in_order {
        say("the states are not in order of time; they are put in order".into());
    }
    if let (Some(first), Some(last)) = (steps.first(), steps.last())
        && last - first > LONGEST_TRACK
    {
        say(format!(
            "states later than {LONGEST_TRACK} steps after the first are left out of its motion"
        ));
    }
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
        let message = "a signal state without time was left out".into();
        xml.note(Severity::Warning, element, message);
    }
    Ok(time.map(|time| SignalState { time, signals }))
}

fn trajectory(xml: &mut Xml<'_>) -> Result<Vec<State>, ReadError> {
    let mut states = Vec::new();
    while let Some(child) = xml.next()? {
        match child.name {
            "state" => states.push(state(xml, child, false)?),
            _ => xml.skip_unknown(child)?,
        }
    }
    Ok(states)
}

fn occupancies(xml: &mut Xml<'_>) -> Result<Vec<Occupancy>, ReadError> {
    let mut found = Vec::new();
    while let Some(child) = xml.next()? {
        match child.name {
            "occupancy" => found.extend(occupancy(xml, child)?),
            _ => xml.skip_unknown(child)?,
        }
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
            "without time or shape; left out".into(),
        );
    }
    Ok(both.map(|(time, region)| Occupancy { time, region }))
}
