//! Sort orders of the list.

use std::cmp::Ordering;

use super::Row;
use nearmiss_scene::metrics::{CriticalMoment, Danger, MEASURES, Measure};

/// By what the list is sorted; scenarios of which that is not known come last.
#[derive(Debug, Clone, Copy, Default)]
pub enum Order {
    /// As they were found: by path, the bundled ones as they are.
    #[default]
    Found,
    /// By name.
    Name,
    /// By the moment that matters, the most severe first.
    Severity,
    /// By the most dangerous value of a measure, the most dangerous one first.
    Measure(&'static Measure),
    /// By the number of obstacles, the most first.
    Obstacles,
    /// By their length, the longest first.
    Duration,
    /// By how many stored answers differ from the built-in judge, the most first.
    Verdicts,
}

/// The moment that matters of a scenario.
fn worst(row: &Row) -> Option<&CriticalMoment> {
    row.facts()?.headline.as_ref()?.worst()
}

impl PartialEq for Order {
    fn eq(&self, other: &Self) -> bool {
        self.id() == other.id()
    }
}

impl Order {
    /// Every one but the measures.
    pub const PLAIN: [Self; 6] = [
        Self::Found,
        Self::Name,
        Self::Severity,
        Self::Obstacles,
        Self::Duration,
        Self::Verdicts,
    ];

    /// A word for it.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            Self::Found => "found",
            Self::Name => "name",
            Self::Severity => "severity",
            Self::Measure(measure) => measure.id,
            Self::Obstacles => "obstacles",
            Self::Duration => "duration",
            Self::Verdicts => "verdicts",
        }
    }

    /// The one with an id.
    #[must_use]
    pub fn parse(id: &str) -> Option<Self> {
        let mut plain = Self::PLAIN.into_iter();
        let measure = || MEASURES.iter().find(|m| m.id == id).map(Self::Measure);
        plain.find(|order| order.id() == id).or_else(measure)
    }

    /// Describes which scenarios come first; for measures, their name.
    #[must_use]
    pub fn doc(self) -> &'static str {
        match self {
            Self::Found => "by path",
            Self::Name => "by name, ignoring folders",
            Self::Severity => {
                "the most severe moment first: contact, courses to contact, close passes"
            }
            Self::Measure(measure) => measure.name,
            Self::Obstacles => "the most obstacles first",
            Self::Duration => "the longest first",
            Self::Verdicts => "the most stored answers that differ from the built-in judge first",
        }
    }

    /// The unit of what it sorts by.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Measure(measure) => measure.unit,
            Self::Duration => "s",
            _ => "",
        }
    }

    /// Whether it needs facts known only after a scenario was read.
    #[must_use]
    pub fn needs_facts(self) -> bool {
        !matches!(self, Self::Found | Self::Name)
    }

    /// Orders two scenarios; what is not known comes last, also where the order is turned around.
    #[must_use]
    pub fn compare(self, turned: bool, a: &Row, b: &Row) -> Ordering {
        let turn = |order: Ordering| if turned { order.reverse() } else { order };
        let numbers = |of: &dyn Fn(&Row) -> Option<f64>, danger: Danger| match (of(a), of(b)) {
            (Some(x), Some(y)) => turn(danger.compare(x, y)),
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (None, None) => Ordering::Equal,
        };
        match self {
            Self::Found => turn(a.rank.cmp(&b.rank)),
            Self::Name => turn(a.entry.name.cmp(&b.entry.name)),
            Self::Severity => match (worst(a), worst(b)) {
                (Some(x), Some(y)) => turn(x.compare_across(y)),
                (Some(_), None) => Ordering::Less,
                (None, Some(_)) => Ordering::Greater,
                (None, None) => Ordering::Equal,
            },
            Self::Measure(m) => numbers(&|row| row.value_of(m).flatten(), m.danger),
            Self::Obstacles => numbers(&|row| Some(row.facts()?.obstacles as f64), Danger::High),
            Self::Duration => numbers(&|row| Some(row.facts()?.seconds), Danger::High),
            Self::Verdicts => {
                let differ = |row: &Row| Some(row.facts()?.tally()).filter(|t| t.count() > 0);
                let part = |row: &Row| differ(row).map(|t| f64::from(t.differ));
                let count = |row: &Row| differ(row).map(|t| f64::from(t.count()));
                numbers(&part, Danger::High).then_with(|| numbers(&count, Danger::High))
            }
        }
        .then(a.rank.cmp(&b.rank))
    }
}
