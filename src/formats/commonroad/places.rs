//! Places of a scenario's elements in an XML file, for diagnostics made after reading it.

use nearmiss_scene::scenario::plausibility::{self, ElementRef};
use nearmiss_scene::scenario::{LaneletNetwork, Scenario, Severity};

use super::builder::{Target, Targets};
use super::xml::{Element, SourceLocation, Xml};

/// An element and the states or goals in it.
type ElementWithParts<'a> = (SourceLocation<'a>, Vec<SourceLocation<'a>>);

/// The elements of a scenario in its own order.
pub(super) struct Places<'a> {
    root: SourceLocation<'a>,
    location: Option<SourceLocation<'a>>,
    lanelets: Vec<SourceLocation<'a>>,
    signs: Vec<SourceLocation<'a>>,
    lights: Vec<SourceLocation<'a>>,
    intersections: Vec<SourceLocation<'a>>,
    obstacles: Vec<ElementWithParts<'a>>,
    problems: Vec<ElementWithParts<'a>>,
}

impl<'a> Places<'a> {
    pub fn below(xml: &mut Xml<'a>, root: Element<'a>) -> Self {
        Self {
            root: xml.place(root),
            location: None,
            lanelets: Vec::new(),
            signs: Vec::new(),
            lights: Vec::new(),
            intersections: Vec::new(),
            obstacles: Vec::new(),
            problems: Vec::new(),
        }
    }

    /// Remembers a child of the root that was just read.
    pub fn add(&mut self, xml: &mut Xml<'a>, child: Element<'a>) {
        let (place, parts) = (xml.place(child), xml.take_marks());
        match child.name {
            "location" => self.location = Some(place),
            "lanelet" => self.lanelets.push(place),
            "trafficSign" => self.signs.push(place),
            "trafficLight" => self.lights.push(place),
            "intersection" => self.intersections.push(place),
            "planningProblem" => self.problems.push((place, parts)),
            name if name.ends_with("bstacle") => self.obstacles.push((place, parts)),
            _ => {}
        }
    }

    /// Notes what cannot be true of a scenario, in the order of the file.
    pub fn note_doubts(&self, xml: &mut Xml<'a>, scenario: &Scenario) {
        let found = plausibility::check(scenario).into_iter();
        let mut placed: Vec<_> = found
            .map(|finding| (self.location(finding.about), finding))
            .collect();
        placed.sort_by_key(|(place, _)| place.element.at);
        for (place, finding) in placed {
            xml.note_at(finding.severity, place, finding.message);
        }
    }

    /// The place of an element; the root for elements without one, such as signs made from speed limits.
    fn location(&self, about: ElementRef) -> &SourceLocation<'a> {
        let found = match about {
            ElementRef::Scenario => None,
            ElementRef::Location => self.location.as_ref(),
            ElementRef::Lanelet(i) => self.lanelets.get(i),
            ElementRef::Sign(i) => self.signs.get(i),
            ElementRef::Light(i) => self.lights.get(i),
            ElementRef::Intersection(i) => self.intersections.get(i),
            ElementRef::Obstacle(i) => self.obstacles.get(i).map(|(place, _)| place),
            ElementRef::State { obstacle, state } => inside(
                self.obstacles.get(obstacle),
                &["initialState", "state"],
                state,
            ),
            ElementRef::Start(i) => inside(self.problems.get(i), &["initialState"], 0),
            ElementRef::Goal { problem, goal } => {
                inside(self.problems.get(problem), &["goalState", "state"], goal)
            }
        };
        found.unwrap_or(&self.root)
    }
}

/// The part at this place among those of these names, all of the first before those of the second; the whole where that
/// is not there.
fn inside<'p, 'a>(
    whole: Option<&'p ElementWithParts<'a>>,
    names: &[&str],
    place: usize,
) -> Option<&'p SourceLocation<'a>> {
    let (whole, parts) = whole?;
    let named = |name| parts.iter().filter(move |part| part.element.name == name);
    let mut named = names.iter().copied().flat_map(named);
    Some(named.nth(place).unwrap_or(whole))
}

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
