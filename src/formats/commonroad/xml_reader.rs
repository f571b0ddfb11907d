//! The root of a scenario file: its kind, its attributes, its elements in any order, and their places for diagnostics.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use nearmiss_scene::scenario::plausibility;
use nearmiss_scene::scenario::plausibility::{ElementRef, refused_time_step};
use nearmiss_scene::scenario::{
    ContentHash, Header, LaneletNetwork, ObstacleRole, Scenario, Severity,
};
use quick_xml::Reader;
use quick_xml::events::Event;

use super::builder::{ScenarioBuilder, Target, Targets, TimeScale, check_benchmark_id};
use super::encoding::{BYTE_ORDER_MARK, beginning, foreign_to_xml, utf16};
use super::xml::{Element, SourceLocation, Xml, decoded, short};
use super::{ReadError, before_2018b, conform, elements, obstacles, road};

pub(super) fn scenario(bytes: &[u8], file: &str) -> Result<Scenario, ReadError> {
    let text = decoded(bytes, file)?;
    let mut xml = Xml::new(&text, file);
    let Some(root) = xml.next()? else {
        let message = if looks_like_an_ego(bytes) {
            "not a scenario, but it looks like an ego trajectory or log; open its scenario with --ego and this file"
        } else if bytes.is_empty() {
            "the file is empty"
        } else if utf16(bytes).is_some() {
            "text in UTF-16; save it as UTF-8"
        } else {
            "no XML element; a scenario starts with <commonRoad …>"
        };
        return Err(xml.fail(0, message.into()));
    };
    if root.name == "CommonRoadSolution" {
        let message = "this is a solution, not a scenario: `nearmiss inspect` shows it, and `--ego` uses it as the ego of its scenario";
        return Err(xml.fail(root.at, message.into()));
    }
    if root.name != "commonRoad" {
        let message = format!(
            "the root is <{}>; a scenario starts with <commonRoad …>, and `nearmiss help scenarios` lists the other formats",
            short(root.name)
        );
        return Err(xml.fail(root.at, message));
    }
    let mut header = header(&xml, root)?;
    xml.known_attributes = Some(known_attributes);
    let is_old = before_2018b::is_meant(&header.version);
    xml.times = if is_old {
        TimeScale::in_seconds(header.time_step_size)
    } else {
        TimeScale::in_steps(header.time_step_size)
    };
    // Versions up to 2018b keep the tags in one attribute.
    let words = header.attributes.remove("tags").unwrap_or_default();
    let mut builder = ScenarioBuilder::default();
    builder.tags.extend(
        words
            .split_whitespace()
            .filter_map(|word| tag_of(&xml, root, word)),
    );
    let mut places = Places::below(&mut xml, root);
    while let Some(child) = xml.next()? {
        read_child(&mut xml, child, &mut builder, is_old)?;
        places.add(&mut xml, child);
        xml.check_count(root, builder.count(), "elements")?;
    }
    if is_old || header.version == "2018b" {
        // Planning problems do not count: the reference reader knows nothing of them when it numbers signs.
        let used = builder.largest_id().unwrap_or(0);
        let signs = before_2018b::signs(&mut xml, &mut builder.lanelets, used);
        builder.signs.extend(signs);
    } else {
        before_2018b::count_unused(&mut xml);
    }
    let mut scenario = builder.finish(header, ContentHash::digest(bytes));
    check_places(&mut xml, &scenario.network);
    places.note_doubts(&mut xml, &scenario);
    scenario.diagnostics = xml.into_diagnostics();
    Ok(scenario)
}

/// The attributes of an element that are read; those of the root are, or kept.
fn known_attributes(element: &str) -> &'static [&'static str] {
    match element {
        "trafficSign" => &["id", "virtual"],
        "adjacentLeft" | "adjacentRight" => &["ref", "drivingDir"],
        // Goals refer to lanelets by the same name.
        "lanelet" => &["id", "ref"],
        "trafficLight" | "intersection" | "incoming" | "planningProblem" => &["id"],
        name if role_of(name).is_some() => &["id"],
        "predecessor" | "successor" | "succecessor" | "trafficSignRef" | "trafficLightRef"
        | "incomingLanelet" | "successorsRight" | "successorsStraight" | "successorsLeft"
        | "isLeftOf" | "crossingLanelet" => &["ref"],
        _ => &[],
    }
}

/// Reads an element below the root.
fn read_child<'a>(
    xml: &mut Xml<'a>,
    child: Element<'a>,
    builder: &mut ScenarioBuilder,
    is_old: bool,
) -> Result<(), ReadError> {
    match child.name {
        "lanelet" => {
            let lanelet = road::lanelet(xml, child)?;
            builder.lanelet(&xml.at(child), lanelet);
        }
        "trafficSign" => {
            let sign = road::sign(xml, child)?;
            builder.sign(&xml.at(child), sign);
        }
        "trafficLight" => {
            let light = road::light(xml, child)?;
            builder.light(&xml.at(child), light);
        }
        "intersection" => {
            let intersection = road::intersection(xml, child)?;
            builder.intersection(&xml.at(child), intersection);
        }
        "planningProblem" => {
            let problem = elements::problem(xml, child)?;
            builder.problem(&xml.at(child), problem);
        }
        "location" => builder.location = Some(elements::location(xml)?),
        "scenarioTags" => {
            while let Some(tag) = xml.next()? {
                xml.close()?;
                builder.tags.extend(tag_of(xml, tag, tag.name));
            }
        }
        name => match role_of(name) {
            Some(role) => {
                let mut obstacle = obstacles::obstacle(xml, child, role)?;
                if is_old {
                    before_2018b::complete(&xml.at(child), &mut obstacle);
                }
                builder.obstacle(&xml.at(child), obstacle);
            }
            None => xml.skip_unknown(child)?,
        },
    }
    Ok(())
}

fn looks_like_an_ego(bytes: &[u8]) -> bool {
    let first = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
    let first = String::from_utf8_lossy(first);
    first.contains("timestep") || first.contains("trajectory_number")
}

/// A tag; one that could not be the name of an element is left out.
fn tag_of<'a>(xml: &Xml<'a>, element: Element<'a>, word: &str) -> Option<String> {
    if !is_name(word) {
        let message = format!("`{}` cannot be a tag and was left out", short(word));
        xml.note(Severity::Warning, element, message);
        return None;
    }
    if !conform::is_tag(word) {
        let message = format!("tag `{}` is not in the schema; kept", short(word));
        xml.note(Severity::Note, element, message);
    }
    Some(word.to_string())
}

/// Whether a word can be the name of an element or attribute.
fn is_name(word: &str) -> bool {
    let letter = |c: char| c.is_ascii_alphabetic() || c == '_';
    let more = |c: char| letter(c) || c.is_ascii_digit() || matches!(c, '-' | '.' | ':');
    word.starts_with(letter) && word.chars().all(more)
}

/// The role that an obstacle element's name says; `None` for other elements.
fn role_of(name: &str) -> Option<Option<ObstacleRole>> {
    Some(match name {
        "staticObstacle" => Some(ObstacleRole::Static),
        "dynamicObstacle" => Some(ObstacleRole::Dynamic),
        "phantomObstacle" => Some(ObstacleRole::Phantom),
        "environmentObstacle" => Some(ObstacleRole::Environment),
        "obstacle" => None,
        _ => return None,
    })
}

fn header<'a>(xml: &Xml<'a>, root: Element<'a>) -> Result<Header, ReadError> {
    let mut attributes: BTreeMap<String, String> = xml
        .attributes(root)
        .filter(|(key, _)| is_name(key))
        .map(|(key, value)| (key.to_string(), value.into_owned()))
        .collect();
    let mut take = |name: &str| attributes.remove(name);
    let (id, version) = (take("benchmarkID"), take("commonRoadVersion"));
    let step = take("timeStepSize");
    let Some(step) = step else {
        return Err(xml.fail(root.at, "<commonRoad> has no timeStepSize".into()));
    };
    let time_step_size = step.trim().parse::<f64>().unwrap_or(f64::NAN);
    if let Some(why) = refused_time_step(time_step_size) {
        let message = format!("timeStepSize=\"{}\" {why}", short(&step));
        return Err(xml.fail(root.at, message));
    }
    let version = version.unwrap_or_default();
    if before_2018b::is_meant(&version) {
        let message = format!(
            "version {} has times in seconds; read as steps of {time_step_size} s",
            short(&version)
        );
        xml.note(Severity::Note, root, message);
    } else if !matches!(version.as_str(), "2020a" | "2018b") {
        let message = format!(
            "version `{}` is not 2020a or 2018b; read as 2020a",
            short(&version)
        );
        xml.note(Severity::Warning, root, message);
    }
    match &id {
        None => xml.note(Severity::Warning, root, "no benchmarkID".into()),
        Some(id) => check_benchmark_id(&xml.at(root), id),
    }
    Ok(Header {
        other_format: None,
        benchmark_id: id.unwrap_or_default(),
        version,
        time_step_size,
        attributes,
    })
}

/// Contents of a CommonRoad XML file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Root {
    /// A scenario, `<commonRoad>`.
    Scenario,
    /// A solution, `<CommonRoadSolution>`.
    Solution,
    /// Something else, or no XML.
    Other,
}

/// Why the type of a file named like a scenario cannot be determined.
#[derive(Debug, thiserror::Error)]
pub enum Unrecognised {
    /// It has no bytes.
    #[error("empty")]
    Empty,
    /// It has to be unpacked or saved anew first.
    #[error("{0}")]
    Foreign(&'static str),
    /// XML was expected.
    #[error("no XML element in its first {} KiB", HEAD / 1024)]
    NoElement,
    /// Protobuf was expected.
    #[error("not a CommonRoad message, or damaged at its beginning")]
    NoMessage,
    /// It is a pipe, a device or the like, which is not touched.
    #[error("not a regular file")]
    Irregular,
    /// It cannot be opened or read.
    #[error("{}", nearmiss_base::system::error_text(.0))]
    Io(#[from] std::io::Error),
}

/// A root further into the file than this many bytes is not looked for.
const HEAD: usize = 64 * 1024;

/// Most roots are within this many bytes.
const FIRST: usize = 2048;

/// The kind of the file that begins with `bytes`, sound or not.
#[must_use]
pub fn root_of(bytes: &[u8]) -> Root {
    let head = beginning(&bytes[..bytes.len().min(HEAD)]);
    match first_element(&head) {
        Some("commonRoad") => Root::Scenario,
        Some("CommonRoadSolution") => Root::Solution,
        _ => Root::Other,
    }
}

/// The kind of a file; pipes and devices are not touched, and what cannot be read is something else.
#[must_use]
pub fn root_of_file(path: &Path) -> Root {
    beginning_of_file(path, HEAD).map_or(Root::Other, |head| root_of(&head))
}

/// Whether an XML file is a scenario, or something else.
///
/// # Errors
/// It is neither, or cannot be read: why.
pub(crate) fn is_scenario(path: &Path) -> Result<bool, Unrecognised> {
    let mut head = beginning_of_file(path, FIRST)?;
    let mut known = root_name(&head);
    if known.is_none() && head.len() == FIRST {
        head = beginning_of_file(path, HEAD)?;
        known = root_name(&head);
    }
    match (known, foreign_to_xml(&head)) {
        // Another encoding is reported only if the file could be a scenario.
        (Some(false), _) => Ok(false),
        (_, Some(what)) => Err(Unrecognised::Foreign(what)),
        (Some(true), None) => Ok(true),
        (None, None) => Err(Unrecognised::NoElement),
    }
}

/// The name of the root of XML that begins so; nothing if none is to be seen.
pub(crate) fn root_name_of(head: &[u8]) -> Option<String> {
    first_element(&beginning(head)).map(str::to_string)
}

/// Whether the first element is a scenario's; nothing if none is to be seen.
fn root_name(head: &[u8]) -> Option<bool> {
    first_element(&beginning(head)).map(|name| name == "commonRoad")
}

/// At most so many bytes of a file, and at least one.
pub(crate) fn beginning_of_file(path: &Path, most: usize) -> Result<Vec<u8>, Unrecognised> {
    if !path.metadata()?.is_file() {
        return Err(Unrecognised::Irregular);
    }
    let mut head = Vec::with_capacity(FIRST);
    let file = nearmiss_base::system::open_file(path)?;
    file.take(most as u64).read_to_end(&mut head)?;
    if head.is_empty() {
        return Err(Unrecognised::Empty);
    }
    Ok(head)
}

/// The name of the first element, also where `head` ends within its tag.
fn first_element(head: &str) -> Option<&str> {
    // All of them: the reader takes one away by itself and does not count its bytes.
    let head = head.trim_start_matches(BYTE_ORDER_MARK);
    let mut reader = Reader::from_str(head);
    let at = loop {
        let at = usize::try_from(reader.buffer_position()).ok()?;
        match reader.read_event() {
            Ok(Event::Start(_) | Event::Empty(_)) | Err(_) => break at,
            Ok(Event::Eof) => return None,
            Ok(_) => {}
        }
    };
    let tag = head.get(at..)?.strip_prefix('<')?;
    let end = tag.find(|c: char| c.is_whitespace() || matches!(c, '/' | '>'))?;
    let name = &tag[..end];
    name.starts_with(|c: char| c.is_alphabetic() || c == '_')
        .then_some(name)
}

/// An element and the states or goals in it.
type ElementWithParts<'a> = (SourceLocation<'a>, Vec<SourceLocation<'a>>);

/// The elements of a scenario in its own order.
struct Places<'a> {
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
    fn below(xml: &mut Xml<'a>, root: Element<'a>) -> Self {
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
    fn add(&mut self, xml: &mut Xml<'a>, child: Element<'a>) {
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
    fn note_doubts(&self, xml: &mut Xml<'a>, scenario: &Scenario) {
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
fn check_places(xml: &mut Xml<'_>, network: &LaneletNetwork) {
    let known = Targets::new(network);
    for (place, id) in xml.take_references() {
        let name = place.element.name;
        if !known.has(target(name), id) {
            let message = format!("<{name}> refers to {id}, which is not in the file");
            xml.note_at(Severity::Warning, &place, message);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_element_decides() {
        for (text, root) in [
            ("<commonRoad>", Root::Scenario),
            (
                "\u{feff}<?xml version='1.0'?>\n<!-- <commonRoad> -->\n<CommonRoadSolution x='",
                Root::Solution,
            ),
            (
                "<?xml version='1.0'?><!-- <commonRoad> --><CommonRoadSolution/>",
                Root::Solution,
            ),
            ("<CommonRoadSolution a='b'>", Root::Solution),
            (
                "<!DOCTYPE a [<!ENTITY b 'c'>]>\n<commonRoad\tx",
                Root::Scenario,
            ),
            ("\u{feff}\u{feff}<commonRoad x='1'>", Root::Scenario),
            (
                "\u{feff}\u{feff}\u{feff}<CommonRoadSolution>",
                Root::Solution,
            ),
            ("<commonRoadMap>", Root::Other),
            // Cut off before the name is known.
            ("<commonRoad", Root::Other),
            ("<!-- <commonRoad>", Root::Other),
            ("words, and then a <commonRoad>", Root::Scenario),
            ("<html><commonRoad/></html>", Root::Other),
            ("timestep,x_position", Root::Other),
            ("", Root::Other),
        ] {
            assert_eq!(root_of(text.as_bytes()), root, "{text}");
        }
        assert_eq!(root_of(b"\xff<commonRoad>"), Root::Scenario);
        let wide: Vec<u8> = "\u{feff}<commonRoad >"
            .encode_utf16()
            .flat_map(u16::to_be_bytes)
            .collect();
        assert_eq!(root_of(&wide), Root::Scenario);
    }
}
