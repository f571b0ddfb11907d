//! Checks references between elements, and reports dangling ones.

use super::builder::{Target, Targets};
use super::xml::Xml;
use nearmiss_scene::scenario::{LaneletNetwork, Severity};

/// The target of an element with a `ref`.
fn target(name: &str) -> Target {
    match name {
        "trafficSignRef" => Target::Sign,
        "trafficLightRef" => Target::Light,
        "isLeftOf" => Target::Incoming,
        _ => Target::Lanelet,
    }
}

/// Notes every reference to an element that is not there.
pub(super) fn check(xml: &mut Xml<'_>, network: &LaneletNetwork) {
    let known = Targets::new(network);
    for (place, id) in xml.take_references() {
        let name = place.element.name;
        if !known.has(target(name), id) {
            let message = format!("<{name}> refers to {id}, which is not in the file");
            xml.note_at(Severity::Warning, &place, message);
        }
    }
}
