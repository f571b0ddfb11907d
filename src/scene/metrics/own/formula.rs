//! A formula of the user's: what it is made of, and its value in an encounter.

use std::sync::Arc;

use super::super::{Encounter, Measure, NoValue, Reading};
use super::unit::Unit;

/// A formula that was read and whose units agree.
#[derive(Debug)]
pub struct Formula {
    /// As it is written.
    pub text: String,
    /// What gives the value.
    pub root: Number,
    /// The unit of the value; none where it is made of bare numbers alone.
    pub unit: Option<Unit>,
    /// What follows from the operands.
    pub facts: Facts,
}

/// What a formula inherits from its operands.
#[derive(Debug, Clone, Copy)]
pub struct Facts {
    /// Whether one of them reads recorded steps to come.
    pub reads_ahead: bool,
    /// Whether all of them are of places or of the ego, so that regions of occupancy sets have values.
    pub of_places: bool,
    /// How many parts are worked out, those of the user's other measures counted each time.
    pub size: usize,
}

/// A part that is a number.
#[derive(Debug)]
pub enum Number {
    Literal(f64),
    Of(Operand),
    One(fn(f64) -> f64, Box<Number>),
    Two(fn(f64, f64) -> f64, Box<(Number, Number)>),
    Power(Box<Number>, i32),
    Choice(Box<(Condition, Number, Number)>),
}

/// A part that holds or does not.
#[derive(Debug)]
pub enum Condition {
    Compared(fn(&f64, &f64) -> bool, Box<(Number, Number)>),
    Not(Box<Condition>),
    Both(Box<(Condition, Condition)>),
    Either(Box<(Condition, Condition)>),
}

/// What a name stands for.
#[derive(Debug, Clone)]
pub enum Operand {
    State(&'static State),
    Measure(&'static Measure),
    Own(Arc<Formula>),
}

/// A state that formulas name.
#[derive(Debug)]
pub struct State {
    /// The names in formulas, the plainest first.
    pub names: &'static [&'static str],
    /// Its unit.
    pub unit: &'static str,
    /// What it is.
    pub doc: &'static str,
    of_ego: bool,
    read: fn(&Encounter<'_>) -> f64,
}

/// The states that formulas may name.
pub const STATES: &[State] = &[
    State {
        names: &["speed", "ego.speed"],
        unit: "m/s",
        doc: "speed of the ego, in reverse too",
        of_ego: true,
        read: |e| e.ego.velocity.abs(),
    },
    State {
        names: &["acceleration", "ego.acceleration"],
        unit: "m/s²",
        doc: "acceleration of the ego along its heading",
        of_ego: true,
        read: |e| e.ego.acceleration,
    },
    State {
        names: &["obstacle.speed"],
        unit: "m/s",
        doc: "speed of the obstacle, in reverse too",
        of_ego: false,
        read: |e| e.other.velocity.abs(),
    },
    State {
        names: &["obstacle.acceleration"],
        unit: "m/s²",
        doc: "acceleration of the obstacle along its heading",
        of_ego: false,
        read: |e| e.other.acceleration,
    },
    State {
        names: &["heading_difference"],
        unit: "",
        doc: "angle between the two headings, 0 to π rad",
        of_ego: false,
        read: |e| {
            let (ego, other) = (e.ego.pose.forward(), e.other.pose.forward());
            ego.perp(&other).abs().atan2(ego.dot(&other))
        },
    },
];

impl Operand {
    /// Its unit; none where a formula is made of bare numbers alone.
    pub fn unit(&self) -> Option<Unit> {
        match self {
            Self::State(state) => Unit::parse(state.unit),
            Self::Measure(measure) => Unit::parse(measure.unit),
            Self::Own(formula) => formula.unit,
        }
    }

    pub fn facts(&self) -> Facts {
        match self {
            Self::State(state) => Facts {
                reads_ahead: false,
                of_places: state.of_ego,
                size: 1,
            },
            Self::Measure(measure) => Facts {
                reads_ahead: measure.reads_ahead,
                of_places: measure.is_of_places(),
                size: 1,
            },
            Self::Own(formula) => formula.facts,
        }
    }

    fn value(&self, encounter: &Encounter<'_>) -> Result<f64, NoValue> {
        match self {
            Self::State(state) => Ok((state.read)(encounter)),
            Self::Measure(measure) => match measure.evaluate(encounter) {
                Reading::Value(value) => Ok(value),
                Reading::None(why) => Err(why),
            },
            Self::Own(formula) => formula.root.value(encounter),
        }
    }
}

impl Formula {
    /// Its value in an encounter.
    pub fn reading(&self, encounter: &Encounter<'_>) -> Reading {
        self.root.value(encounter).into()
    }
}

impl Number {
    /// The value; the reason of the first operand without one that is needed.
    fn value(&self, encounter: &Encounter<'_>) -> Result<f64, NoValue> {
        let value = match self {
            Self::Literal(value) => *value,
            Self::Of(operand) => operand.value(encounter)?,
            Self::One(of, part) => of(part.value(encounter)?),
            Self::Two(of, parts) => of(parts.0.value(encounter)?, parts.1.value(encounter)?),
            Self::Power(part, power) => part.value(encounter)?.powi(*power),
            Self::Choice(parts) => {
                let (condition, then, otherwise) = &**parts;
                let chosen = if condition.holds(encounter) {
                    then
                } else {
                    otherwise
                };
                chosen.value(encounter)?
            }
        };
        if value.is_finite() {
            Ok(value)
        } else {
            Err(NoValue::NotFinite)
        }
    }
}

impl Condition {
    /// Whether it holds; no comparison with something that has no value does.
    fn holds(&self, encounter: &Encounter<'_>) -> bool {
        match self {
            Self::Compared(holds, parts) => {
                let (left, right) = (parts.0.value(encounter), parts.1.value(encounter));
                left.ok()
                    .zip(right.ok())
                    .is_some_and(|(left, right)| holds(&left, &right))
            }
            Self::Not(part) => !part.holds(encounter),
            Self::Both(parts) => parts.0.holds(encounter) && parts.1.holds(encounter),
            Self::Either(parts) => parts.0.holds(encounter) || parts.1.holds(encounter),
        }
    }
}
