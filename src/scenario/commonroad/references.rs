//! References between elements: those to nothing are named.

use std::collections::HashSet;

use super::xml::Xml;
use crate::scenario::{LaneletNetwork, Severity};

/// What kind of element a reference is to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Target {
    Lanelet,
    Sign,
    Light,
    Incoming,
}

/// The target of an element with a `ref`.
pub(super) fn target(name: &str) -> Target {
    match name {
        "trafficSignRef" => Target::Sign,
        "trafficLightRef" => Target::Light,
        "isLeftOf" => Target::Incoming,
        _ => Target::Lanelet,
    }
}

/// Notes every reference to an element that is not there.
pub(super) fn check(xml: &mut Xml<'_>, network: &LaneletNetwork) {
    let incomings = network
        .intersections
        .iter()
        .flat_map(|i| &i.incomings)
        .map(|i| i.id);
    let mut known: HashSet<(Target, i64)> = incomings.map(|id| (Target::Incoming, id)).collect();
    known.extend(network.lanelets.iter().map(|l| (Target::Lanelet, l.id)));
    known.extend(network.signs.iter().map(|s| (Target::Sign, s.id)));
    known.extend(network.lights.iter().map(|l| (Target::Light, l.id)));
    for (place, id) in xml.take_references() {
        let name = place.element.name;
        if !known.contains(&(target(name), id)) {
            let message = format!("<{name}> refers to {id}, which is not in the file");
            xml.note_at(Severity::Warning, &place, message);
        }
    }
}
