//! What is in a scenario, in a few lines for people.

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt::Display;
use std::hash::Hash;
use std::ops::Range;

use nearmiss_base::system::counted;

use super::{
    Diagnostic, Header, LONGEST_TRACK, Obstacle, ObstacleRole, Prediction, Scenario, Severity,
};

impl Scenario {
    /// What is in it: a word and what there is to say about it, a line each.
    #[must_use]
    pub fn summary(&self) -> Vec<(&'static str, String)> {
        let (network, header) = (&self.network, &self.header);
        let (first, last) = (self.steps().start, self.steps().end - 1);
        let mut lines = vec![
            (
                "format",
                format!("{}, {} s per step", header.format(), header.time_step_size),
            ),
            (
                "road",
                format!(
                    "{}, {}, {}, {}",
                    counted(network.lanelets.len(), "lanelet"),
                    counted(network.signs.len(), "sign"),
                    counted(network.lights.len(), "light"),
                    counted(network.intersections.len(), "intersection")
                ),
            ),
            ("obstacles", self.kinds()),
            (
                "duration",
                match (last - first) as f64 * header.time_step_size {
                    whole if first == 0 => format!("{whole:.1} s ({} steps)", last + 1),
                    part => format!("{part:.1} s (steps {first} to {last})"),
                },
            ),
            (
                "planning",
                match self.planning_problems.len() {
                    0 => "no planning problem".into(),
                    1 => "1 planning problem".into(),
                    n => format!("{n} planning problems"),
                },
            ),
        ];
        if !self.tags.is_empty() {
            lines.push(("tags", self.tags.join(", ")));
        }
        for name in ["author", "affiliation", "source", "date"] {
            let said = header.attributes.get(name).filter(|s| !s.is_empty());
            lines.extend(said.map(|said| (name, said.clone())));
        }
        lines
    }

    /// The time steps at which anything is said about an obstacle; only step 0 where nothing is.
    #[must_use]
    pub fn steps(&self) -> Range<i64> {
        let own = self.recorded_ego.as_ref().map(|own| &own.obstacle);
        let tracks = self.obstacles.iter().chain(own).map(|o| o.track().steps());
        let regions = self.obstacles.iter().flat_map(|o| match &o.prediction {
            Prediction::Occupancies(regions) => regions.as_slice(),
            _ => &[],
        });
        let all = tracks
            .filter(|steps| !steps.is_empty())
            .chain(regions.map(|r| r.time.from..r.time.to + 1))
            .reduce(|a, b| a.start.min(b.start)..a.end.max(b.end))
            .unwrap_or(0..1);
        all.start..all.end.min(all.start + LONGEST_TRACK + 1)
    }

    /// Ids of the obstacles that could be the ego, each once: those with a body and a trajectory.
    #[must_use]
    pub fn possible_egos(&self) -> Vec<i64> {
        let moving = |o: &&Obstacle| {
            o.role == ObstacleRole::Dynamic && o.footprint.is_some() && o.track().iter().count() > 1
        };
        let mut seen = HashSet::new();
        let ids = self.obstacles.iter().filter(moving).map(|o| o.id);
        ids.filter(|id| seen.insert(*id)).collect()
    }

    fn kinds(&self) -> String {
        let mut kinds = BTreeMap::<String, usize>::new();
        for obstacle in &self.obstacles {
            let kind = format!("{} {}", obstacle.role, obstacle.kind);
            *kinds.entry(kind).or_default() += 1;
        }
        if kinds.is_empty() {
            return "none".into();
        }
        let sets = self.obstacles.iter().filter(|o| o.is_set_based()).count();
        let kinds: Vec<String> = kinds
            .iter()
            .map(|(kind, count)| format!("{count} × {kind}"))
            .collect();
        match sets {
            0 => kinds.join(", "),
            _ => format!("{}; {sets} set-based", kinds.join(", ")),
        }
    }
}

impl Header {
    /// The format that was read, with its version if that is CommonRoad.
    fn format(&self) -> String {
        match (self.other_format, self.version.as_str()) {
            (Some(other), _) => other.into(),
            (None, "") => "CommonRoad of no version".into(),
            (None, version) => format!("CommonRoad {version}"),
        }
    }
}

/// The diagnostics, those that differ in numbers only told once, the most serious first; what is not used, in one
/// sentence at the end.
#[must_use]
pub fn in_short(diagnostics: &[Diagnostic]) -> Vec<(Severity, String)> {
    let all = diagnostics.iter();
    let (unused, others): (Vec<_>, Vec<_>) = all.partition(|d| d.severity == Severity::Unused);
    let shape = |d: &&Diagnostic| (shape(&d.message), d.severity);
    let mut groups = grouped(&others, shape);
    groups.sort_by_key(|(first, _)| std::cmp::Reverse(first.severity));
    let words = |(first, more): (&&Diagnostic, usize)| (first.severity, name_and_more(first, more));
    let mut short: Vec<_> = groups.into_iter().map(words).collect();
    if !unused.is_empty() {
        let kinds = unused
            .iter()
            .map(|kind| match kind.line {
                0 => format!("{} {}", kind.message, kind.element),
                line => format!("{} {} (line {line})", kind.message, kind.element),
            })
            .collect::<Vec<_>>()
            .join(", ");
        short.push((Severity::Unused, format!("{}: {kinds}", Severity::Unused)));
    }
    short
}

/// Sentences in their order, those that differ in numbers only told once.
#[must_use]
pub fn alike(sentences: &[String]) -> Vec<String> {
    let groups = grouped(sentences, |sentence| shape(sentence));
    groups
        .into_iter()
        .map(|(first, more)| name_and_more(first, more))
        .collect()
}

/// Words without their numbers.
fn shape(words: &str) -> String {
    words.chars().filter(|c| !c.is_ascii_digit()).collect()
}

/// The first of each kind, and how many more there are of it.
fn grouped<T, K: Eq + Hash>(all: &[T], kind: impl Fn(&T) -> K) -> Vec<(&T, usize)> {
    let mut places: HashMap<K, usize> = HashMap::new();
    let mut groups: Vec<(&T, usize)> = Vec::new();
    for one in all {
        match places.entry(kind(one)) {
            Entry::Occupied(place) => groups[*place.get()].1 += 1,
            Entry::Vacant(place) => {
                place.insert(groups.len());
                groups.push((one, 0));
            }
        }
    }
    groups
}

fn name_and_more(first: &impl Display, more: usize) -> String {
    match more {
        0 => first.to_string(),
        more => format!("{first} (and {more} more like this)"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_in_numbers_only_is_told_once() {
        let diagnostic = |severity, line, message: &str| Diagnostic {
            severity,
            line,
            element: String::new(),
            message: message.into(),
        };
        let all = [
            diagnostic(Severity::Note, 3, "limit 27.78 as sign 1"),
            diagnostic(Severity::Warning, 9, "no shape"),
            diagnostic(Severity::Note, 12, "limit 13.9 as sign 2"),
            Diagnostic {
                element: "lanelet/hue".into(),
                ..diagnostic(Severity::Unused, 7, "2 ×")
            },
            Diagnostic {
                element: "column dhw".into(),
                ..diagnostic(Severity::Unused, 0, "90 ×")
            },
        ];
        let short = in_short(&all);
        assert_eq!(short.len(), 3);
        assert_eq!(
            short[2].1,
            "not used: 2 × lanelet/hue (line 7), 90 × column dhw"
        );
        assert_eq!(short[0].1, "warning: line 9: no shape");
        assert_eq!(
            short[1].1,
            "note: line 3: limit 27.78 as sign 1 (and 1 more like this)"
        );
    }
}
