//! Filter terms about events of an index: manoeuvre, other road user, road, and parameters.

use nearmiss_base::system::unknown;
use nearmiss_scene::corpus::{Event, EventKind, Parameter, RoadType};
use nearmiss_scene::scenario::ObstacleType;

use super::index_terms::{AnyOf, WindowTest, in_order, parse_value, place};
use super::terms::{Comparison, compared, number_in};
use super::without_spaces;

/// A filter of events: terms side by side, which all hold.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EventFilter {
    /// Each with whether it is negated.
    tests: Vec<(EventTest, bool)>,
    words: Vec<String>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum EventTest {
    Kind(AnyOf),
    /// The other's type or the road, as of windows.
    Window(WindowTest),
    Compared(Parameter, Comparison, f64),
}

/// Whether an event fits a filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fit {
    Fits,
    FitsNot,
    /// As far as it is known: a parameter that is compared is missing.
    Unmeasured,
}

impl EventFilter {
    /// Reads terms such as `manoeuvre:cut_in gap<12 closing>5 road:highway`.
    ///
    /// # Errors
    /// One is wrong, or has no value.
    pub fn read(text: &str) -> Result<Self, String> {
        let mut filter = Self::default();
        for word in without_spaces(text).split_whitespace() {
            let (bare, negated) = match word.strip_prefix('!') {
                Some(rest) => (rest, true),
                None => (word, false),
            };
            let test = match (bare.split_once(':'), compared(bare)) {
                (Some(("manoeuvre" | "maneuver", value)), _) => {
                    let words = EventKind::ALL.map(EventKind::name);
                    parse_value("manoeuvre", value, &in_order(&words))?.map(EventTest::Kind)
                }
                (Some((key @ ("actor" | "road"), value)), _) => {
                    match WindowTest::read(key, value) {
                        Some(test) => test?.map(EventTest::Window),
                        None => None,
                    }
                }
                (None, Some((key, how, value))) => {
                    let parameter = Parameter::parse(key).ok_or_else(|| {
                        unknown("parameter", key, Parameter::ALL.map(Parameter::name))
                    })?;
                    let value = number_in(key, value)?;
                    value.map(|value| EventTest::Compared(parameter, how, value))
                }
                _ => {
                    return Err(format!(
                        "`{word}` is no term of events; available: manoeuvre: actor: road: {}",
                        Parameter::ALL.map(Parameter::name).join(" ")
                    ));
                }
            };
            let test = test.ok_or_else(|| format!("`{word}` has no value"))?;
            filter.tests.push((test, negated));
            filter.words.push(word.to_string());
        }
        Ok(filter)
    }

    /// All events of a kind; it is no word of the filter.
    pub(crate) fn of_kind(kind: EventKind) -> Self {
        let test = EventTest::Kind(AnyOf::one(kind as usize));
        Self {
            tests: vec![(test, false)],
            words: Vec::new(),
        }
    }

    /// Events at least as extreme: of the same manoeuvre, and each parameter that has a dangerous direction is as far in it or
    /// farther, rounded to hundredths towards the harmless side.
    #[must_use]
    pub fn like(event: &Event) -> Self {
        let mut filter = Self::of_kind(event.manoeuvre);
        let kind = format!("manoeuvre:{}", event.manoeuvre.name());
        filter.words.push(kind);
        for parameter in Parameter::ALL {
            let Some((value, is_low)) = parameter.of(event).zip(parameter.extreme_is_low()) else {
                continue;
            };
            let (how, sign, value) = if is_low {
                (Comparison::AtMost, "<=", (100.0 * value).ceil() / 100.0)
            } else {
                (Comparison::AtLeast, ">=", (100.0 * value).floor() / 100.0)
            };
            // Without a sign where it is 0.
            let value = value + 0.0;
            let test = EventTest::Compared(parameter, how, value);
            filter.tests.push((test, false));
            filter
                .words
                .push(format!("{}{sign}{value}", parameter.name()));
        }
        filter
    }

    /// What fits both.
    #[must_use]
    pub fn and(mut self, other: &Self) -> Self {
        self.tests.extend(&other.tests);
        self.words.extend_from_slice(&other.words);
        self
    }

    /// Its terms.
    #[must_use]
    pub fn words(&self) -> String {
        self.words.join(" ")
    }

    /// Whether events of a kind may fit.
    #[must_use]
    pub fn asks_for(&self, kind: EventKind) -> bool {
        let of_kind = |test: &EventTest| match test {
            EventTest::Kind(any) => Some(any.has(kind as usize)),
            _ => None,
        };
        { self.tests.iter() }.all(|(test, negated)| of_kind(test).is_none_or(|is| is != *negated))
    }

    /// The greatest gap that it compares with, metres.
    #[must_use]
    pub fn widest_gap(&self) -> Option<f64> {
        let gaps = self.tests.iter().filter_map(|(test, _)| match test {
            EventTest::Compared(Parameter::Gap, _, value) => Some(*value),
            _ => None,
        });
        gaps.max_by(f64::total_cmp)
    }

    /// Whether an event fits.
    pub(crate) fn fit(&self, event: &Event) -> Fit {
        let mut fit = Fit::Fits;
        for (test, negated) in &self.tests {
            let holds = match test {
                EventTest::Kind(any) => any.has(event.manoeuvre as usize),
                EventTest::Window(WindowTest::Actor(any)) => {
                    any.has(place(&ObstacleType::ALL, &event.obstacle_type))
                }
                EventTest::Window(WindowTest::Road(any)) => {
                    any.has(place(&RoadType::ALL, &event.road))
                }
                EventTest::Window(_) => true,
                EventTest::Compared(parameter, how, value) => match parameter.of(event) {
                    Some(own) => how.holds(own, *value),
                    None => {
                        fit = Fit::Unmeasured;
                        continue;
                    }
                },
            };
            if holds == *negated {
                return Fit::FitsNot;
            }
        }
        fit
    }
}
