//! What is known of a file only at its end: diagnostics kept with the enclosing elements, and what is not used.

use std::rc::Rc;

use super::{Element, Xml, short};
use crate::commonroad::ReadError;
use nearmiss_scene::scenario::Severity;

/// An element and those around it, from the root.
#[derive(Debug, Clone)]
pub(crate) struct SourceLocation<'a> {
    pub element: Element<'a>,
    pub(super) around: Rc<[Element<'a>]>,
}

/// Elements kept for later diagnostics.
#[derive(Debug, Default)]
pub(super) struct DeferredChecks<'a> {
    /// References met so far.
    references: Vec<(SourceLocation<'a>, i64)>,
    /// Speed limits of version 2018b, by lanelet.
    speed_limits: Vec<(i64, f64, SourceLocation<'a>)>,
    /// States and goals since the last top-level element, for later diagnostics.
    marks: Vec<SourceLocation<'a>>,
    /// The elements around the last one, which are those around the next one more often than not.
    around: Rc<[Element<'a>]>,
}

impl<'a> Xml<'a> {
    /// Remembers a reference, to be checked at the end.
    pub fn refer(&mut self, element: Element<'a>, id: i64) {
        let place = self.place(element);
        self.later.references.push((place, id));
    }

    /// The references met so far.
    pub fn take_references(&mut self) -> Vec<(SourceLocation<'a>, i64)> {
        std::mem::take(&mut self.later.references)
    }

    /// Remembers a speed limit of a lanelet, m/s.
    pub fn limit_speed(&mut self, lanelet: i64, limit: f64, element: Element<'a>) {
        let place = self.place(element);
        self.later.speed_limits.push((lanelet, limit, place));
    }

    /// The speed limits met so far, in the file's order.
    pub fn take_speed_limits(&mut self) -> Vec<(i64, f64, SourceLocation<'a>)> {
        std::mem::take(&mut self.later.speed_limits)
    }

    /// Notes something assumed or skipped at a place that was left long ago.
    pub fn note_at(&self, severity: Severity, place: &SourceLocation<'a>, message: String) {
        let element = place.element;
        let at = || {
            (
                self.line_of(element.at),
                super::path(&place.around, Some(element)),
            )
        };
        self.diagnostics.push(severity, at, message);
    }

    /// Remembers where a state or a goal is.
    pub fn mark(&mut self, element: Element<'a>) {
        let place = self.place(element);
        self.later.marks.push(place);
    }

    /// The elements remembered since the last call.
    pub fn take_marks(&mut self) -> Vec<SourceLocation<'a>> {
        std::mem::take(&mut self.later.marks)
    }

    /// An element and those around it.
    pub fn place(&mut self, element: Element<'a>) -> SourceLocation<'a> {
        let open = match self.path.split_last() {
            Some((last, around)) if last.at == element.at => around,
            _ => &self.path,
        };
        let known = &self.later.around;
        let same =
            known.len() == open.len() && known.last().map(|e| e.at) == open.last().map(|e| e.at);
        if !same {
            self.later.around = open.into();
        }
        SourceLocation {
            element,
            around: self.later.around.clone(),
        }
    }
}

/// The attributes that a format knows, by the names of their elements.
pub(in crate::commonroad) type KnownAttributes = fn(&str) -> &'static [&'static str];

impl<'a> Xml<'a> {
    /// Passes over an element that is not known, which counts as not used.
    pub fn skip_unknown(&mut self, element: Element<'a>) -> Result<(), ReadError> {
        // It is counted as a whole.
        let known = self.known_attributes.take();
        let passed = self.skip();
        self.known_attributes = known;
        passed?;
        self.count_unused(element.name, element.at);
        Ok(())
    }

    /// Reads the innermost open element to its end; elements in it count as not used.
    pub fn close(&mut self) -> Result<(), ReadError> {
        while let Some(child) = self.next()? {
            self.skip_unknown(child)?;
        }
        Ok(())
    }

    /// Counts an element that was read and turned out not to be used.
    pub fn unused_at(&self, place: &SourceLocation<'a>) {
        let names = place
            .around
            .iter()
            .map(|around| around.name)
            .chain([place.element.name])
            .map(short);
        let kind = names.collect::<Vec<_>>().join("/");
        let line = || self.line_of(place.element.at);
        self.diagnostics.unused(kind, line);
    }

    /// Counts the attributes of an element that was just opened that its format does not know.
    pub(in crate::commonroad) fn count_attributes(&self, element: Element<'a>) {
        let Some(known) = self.known_attributes else {
            return;
        };
        if element.attributes.trim().is_empty() {
            return;
        }
        let known = known(element.name);
        for (name, _) in element.values().filter(|(name, _)| !known.contains(name)) {
            self.count_unused(
                &format!("{}@{}", short(element.name), short(name)),
                element.at,
            );
        }
    }

    /// Counts what is within the open elements; the last part of its kind may be long.
    pub(in crate::commonroad) fn count_unused(&self, last: &str, at: usize) {
        let open = self.path.iter().map(|open| short(open.name));
        let last: String = last.chars().take(90).collect();
        let kind = open.chain([last]).collect::<Vec<_>>().join("/");
        self.diagnostics.unused(kind, || self.line_of(at));
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use crate::commonroad::read;
    use nearmiss_scene::scenario::Severity;

    const SCENARIO: &str = "<commonRoad commonRoadVersion='2020a' benchmarkID='ZAM_A-1' timeStepSize='0.1'>\
        <scenarioTags><urban></urban></scenarioTags>\
        <lanelet id='1'><leftBound><point><x>0</x><y>2</y></point><point><x>9</x><y>2</y></point></leftBound>\
        <rightBound><point><x>0</x><y>0</y></point><point><x>9</x><y>0</y></point></rightBound>\
        <trafficSignRef ref='5'></trafficSignRef></lanelet>\
        <trafficSign id='5'><trafficSignElement><trafficSignID>274</trafficSignID></trafficSignElement></trafficSign>\
        <trafficLight id='6'><cycle><cycleElement><duration>3</duration><color>red</color></cycleElement></cycle></trafficLight>\
        <dynamicObstacle id='2'><type>car</type><shape><circle><radius>1</radius></circle></shape><initialState>\
        <position><point><x>1</x><y>1</y></point></position><orientation><exact>0</exact></orientation>\
        <time><exact>0</exact></time></initialState><occupancySet><occupancy><shape><circle><radius>1</radius></circle>\
        </shape><time><exact>1</exact></time></occupancy></occupancySet></dynamicObstacle>\
        <planningProblem id='3'><initialState><position><point><x>1</x><y>1</y></point></position>\
        <orientation><exact>0</exact></orientation><velocity><exact>0</exact></velocity><time><exact>0</exact></time></initialState>\
        <goalState><time><intervalStart>1</intervalStart><intervalEnd>2</intervalEnd></time></goalState></planningProblem>\
        </commonRoad>";

    /// The kinds that a scenario does not use.
    fn unused(text: &str) -> Vec<String> {
        let read = read(text.as_bytes(), "a.xml").unwrap();
        let found = read
            .diagnostics
            .into_iter()
            .filter(|d| d.severity == Severity::Unused);
        found.map(|d| d.element).collect()
    }

    #[test]
    fn an_element_or_attribute_planted_anywhere_is_counted() {
        assert_eq!(unused(SCENARIO), Vec::<String>::new());
        let mut planted = 0;
        // The root's own attributes are kept.
        for (at, _) in SCENARIO.match_indices('>') {
            let before = &SCENARIO[..at];
            let tag = before.rsplit_once('<').unwrap().1;
            if tag.starts_with('/') {
                continue;
            }
            let name = tag.split(' ').next().unwrap();
            let (start, end) = (&SCENARIO[..=at], &SCENARIO[at + 1..]);
            let found = unused(&format!("{start}<odd><point>1</point></odd>{end}"));
            assert_eq!(found.len(), 1, "in <{name}>: {found:?}");
            // Any element in it is a tag.
            let odd = if name == "scenarioTags" {
                "odd/point"
            } else {
                "odd"
            };
            assert!(found[0].ends_with(&format!("{name}/{odd}")), "{found:?}");
            if name != "commonRoad" {
                let found = unused(&format!("{before} odd='1'>{end}"));
                assert_eq!(found.len(), 1, "<{name}>: {found:?}");
                assert!(found[0].ends_with(&format!("{name}@odd")), "{found:?}");
            }
            planted += 1;
        }
        assert!(planted > 50);
        let limit = SCENARIO.replace("</lanelet>", "<speedLimit>9</speedLimit></lanelet>");
        assert_eq!(unused(&limit), ["commonRoad/lanelet/speedLimit"]);
    }
}
