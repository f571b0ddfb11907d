//! What differs between two scenarios: what is said of each, elements by their ids, motions step by step.

mod elements;

use std::collections::BTreeMap;

use nearmiss_base::geometry::{Footprint, Point, Shape};
use schemars::JsonSchema;
use serde::Serialize;

use super::{Ego, Quantity, Scenario};
use elements::{about, egos, lanelets, lights, obstacles, problems, signs};

/// Numbers nearer than this are the same: metres, radians, m/s, m/s².
const SAME: f64 = 1e-3;

/// What differs between two scenarios; empty lists where nothing does.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct Differences {
    /// What is said of the scenarios as a whole.
    pub about: Vec<FieldDifference>,
    /// Elements that differ, by kind: ego, obstacle, lanelet, sign, light, intersection, planning problem.
    pub elements: Vec<ElementDifferences>,
}

/// The elements of one kind that differ.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ElementDifferences {
    /// Which kind.
    pub kind: &'static str,
    /// Ids that the first scenario alone has.
    pub only_in_a: Vec<i64>,
    /// Ids that the second one alone has.
    pub only_in_b: Vec<i64>,
    /// Those of both that differ.
    pub changed: Vec<Changed>,
}

/// An element that differs.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Changed {
    /// Its id.
    pub id: i64,
    /// In what.
    pub fields: Vec<FieldDifference>,
}

/// What differs: words of both, or a number and where it is largest.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct FieldDifference {
    /// Which property.
    pub field: &'static str,
    /// What the first one says.
    pub a: Option<String>,
    /// What the second one says.
    pub b: Option<String>,
    /// The largest difference.
    pub by: Option<f64>,
    /// Unit of that.
    pub unit: Option<&'static str>,
    /// The time step with the largest difference, or the first one that differs.
    pub step: Option<i64>,
}

impl Differences {
    /// Compares two scenarios and their egos, where both have one. Motions are compared at the steps of both; numbers
    /// that differ by less than 0.001 m, rad, m/s or m/s² are equal.
    #[must_use]
    pub fn between(a: (&Scenario, Option<&Ego>), b: (&Scenario, Option<&Ego>)) -> Self {
        let ((a, own_a), (b, own_b)) = (a, b);
        let (roads, others) = (&a.network, &b.network);
        let ego = |ego: Option<&Ego>| ego.into_iter().cloned().collect::<Vec<_>>();
        let elements = [
            of_kind("ego", &ego(own_a), &ego(own_b), |e| e.id, egos),
            of_kind("obstacle", &a.obstacles, &b.obstacles, |o| o.id, obstacles),
            of_kind(
                "lanelet",
                &roads.lanelets,
                &others.lanelets,
                |l| l.id,
                lanelets,
            ),
            of_kind("sign", &roads.signs, &others.signs, |s| s.id, signs),
            of_kind("light", &roads.lights, &others.lights, |l| l.id, lights),
            of_kind(
                "intersection",
                &roads.intersections,
                &others.intersections,
                |i| i.id,
                |a, b, found| found.other("roads", a == b),
            ),
            of_kind(
                "planning problem",
                &a.planning_problems,
                &b.planning_problems,
                |p| p.id,
                problems,
            ),
        ];
        Self {
            about: about(a, b).0,
            elements: elements.into_iter().flatten().collect(),
        }
    }

    /// Whether nothing differs.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.about.is_empty() && self.elements.is_empty()
    }
}

/// The elements of a kind that differ; nothing where none does. Of several with one id the first is meant.
fn of_kind<T>(
    kind: &'static str,
    a: &[T],
    b: &[T],
    id: impl Fn(&T) -> i64,
    compare: impl Fn(&T, &T, &mut Found),
) -> Option<ElementDifferences> {
    let by_id = |all: &[T]| -> BTreeMap<i64, usize> {
        { all.iter().enumerate().rev() }
            .map(|(place, one)| (id(one), place))
            .collect()
    };
    let (of_a, of_b) = (by_id(a), by_id(b));
    let only = |of: &BTreeMap<i64, usize>, other: &BTreeMap<i64, usize>| -> Vec<i64> {
        of.keys()
            .filter(|id| !other.contains_key(id))
            .copied()
            .collect()
    };
    let changed = of_a.iter().filter_map(|(id, place)| {
        let mut found = Found::default();
        compare(&a[*place], &b[*of_b.get(id)?], &mut found);
        (!found.0.is_empty()).then_some(Changed {
            id: *id,
            fields: found.0,
        })
    });
    let found = ElementDifferences {
        kind,
        only_in_a: only(&of_a, &of_b),
        only_in_b: only(&of_b, &of_a),
        changed: changed.collect(),
    };
    let same = found.only_in_a.is_empty() && found.only_in_b.is_empty() && found.changed.is_empty();
    (!same).then_some(found)
}

/// Properties that differ, so far.
#[derive(Default)]
struct Found(Vec<FieldDifference>);

impl Found {
    /// What is said in words.
    fn words(&mut self, field: &'static str, a: Option<String>, b: Option<String>) {
        if a != b {
            self.0.push(FieldDifference {
                field,
                a,
                b,
                ..FieldDifference::default()
            });
        }
    }

    /// Ids, or other things with names.
    fn list<T: ToString + PartialEq>(&mut self, field: &'static str, a: &[T], b: &[T]) {
        if a != b {
            let words = |all: &[T]| {
                let all: Vec<String> = all.iter().map(T::to_string).collect();
                if all.is_empty() {
                    "none".into()
                } else {
                    all.join(", ")
                }
            };
            self.words(field, Some(words(a)), Some(words(b)));
        }
    }

    /// What has no short words.
    fn other(&mut self, field: &'static str, same: bool) {
        if !same {
            self.0.push(FieldDifference {
                field,
                ..FieldDifference::default()
            });
        }
    }

    /// A number, and the step at which it is; only where it is more than rounding.
    fn number(&mut self, field: &'static str, by: f64, unit: &'static str, step: Option<i64>) {
        // What is no number differs.
        if by.is_nan() || by > SAME {
            self.0.push(FieldDifference {
                field,
                by: Some(by),
                unit: Some(unit).filter(|unit| !unit.is_empty()),
                step,
                ..FieldDifference::default()
            });
        }
    }

    /// Lines point by point.
    fn line(&mut self, field: &'static str, a: &[Point], b: &[Point]) {
        if a.len() == b.len() {
            self.number(field, farthest(a, b), "m", None);
        } else {
            let points = |line: &[Point]| Some(format!("{} points", line.len()));
            self.words(field, points(a), points(b));
        }
    }

    fn place(&mut self, a: Option<&Point>, b: Option<&Point>) {
        match (a, b) {
            (Some(a), Some(b)) => self.number("position", (a - b).norm(), "m", None),
            _ => self.other("position", a == b),
        }
    }

    fn body(&mut self, a: Option<&Footprint>, b: Option<&Footprint>) {
        let sizes = a.zip(b).map(|(a, b)| (a.shape().size(), b.shape().size()));
        let near = sizes.is_some_and(|((length, width), (other, broad))| {
            (length - other).abs() <= SAME && (width - broad).abs() <= SAME
        });
        match a.zip(b) {
            Some((a, b)) if near => self.other("shape", same_shape(a.shape(), b.shape())),
            _ => {
                let words = |of: &Footprint| {
                    let (length, width) = of.shape().size();
                    format!("{length:.3} m × {width:.3} m")
                };
                self.words("size", a.map(words), b.map(words));
            }
        }
    }

    fn quantity(&mut self, field: &'static str, unit: &'static str, of: [Option<Quantity>; 2]) {
        match of {
            [Some(a), Some(b)] => self.number(field, apart(a, b), unit, None),
            [a, b] => self.other(field, a == b),
        }
    }
}

fn farthest(a: &[Point], b: &[Point]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// The larger difference of the ends.
fn apart(a: Quantity, b: Quantity) -> f64 {
    let ends = |quantity| match quantity {
        Quantity::Exact(value) => (value, value),
        Quantity::Interval(from, to) => (from, to),
    };
    let ((a, to), (b, until)) = (ends(a), ends(b));
    (a - b).abs().max((to - until).abs())
}

/// Whether two regions of the world are the same.
fn same_shape(a: &Shape, b: &Shape) -> bool {
    let (a, b) = (a.outlines(), b.outlines());
    a.len() == b.len() && { a.iter().zip(&b) }
        .all(|(a, b)| a.len() == b.len() && farthest(a, b) <= SAME)
}
