//! Counts what stands in a file and is not used: elements and attributes, by their paths of names.

use super::{Element, SourceLocation, Xml, short};
use crate::commonroad::error::ReadError;

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
    pub(super) fn count_attributes(&self, element: Element<'a>) {
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
    pub(super) fn count_unused(&self, last: &str, at: usize) {
        let open = self.path.iter().map(|open| short(open.name));
        let last: String = last.chars().take(90).collect();
        let kind = open.chain([last]).collect::<Vec<_>>().join("/");
        self.diagnostics.unused(kind, || self.line_of(at));
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
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
