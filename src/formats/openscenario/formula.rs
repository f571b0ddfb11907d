//! Numbers that follow from parameters: evaluated here, and written as expressions that players evaluate.
//!
//! Written are operators and functions of the standard's version 1.2, and [`Formula::atan`].

use std::fmt;
use std::ops::{Add, Div, Mul, Sub};
use std::sync::Arc;

use crate::commonroad::writer::number;

/// A number that follows from parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula(Arc<Node>);

#[derive(Debug, PartialEq)]
enum Node {
    Number(f64),
    /// The value at a place, with its name.
    Parameter(usize, &'static str),
    Two(char, Formula, Formula),
    Min(Formula, f64),
    Max(Formula, f64),
    Atan(Formula),
}

impl From<f64> for Formula {
    fn from(number: f64) -> Self {
        Self(Arc::new(Node::Number(number)))
    }
}

impl Formula {
    /// The value at a place of those that [`Self::value`] gets; expressions call it by its name.
    #[must_use]
    pub fn parameter(place: usize, name: &'static str) -> Self {
        Self(Arc::new(Node::Parameter(place, name)))
    }

    /// It, but no more than this.
    #[must_use]
    pub fn at_most(&self, most: f64) -> Self {
        self.applied(|of| Node::Min(of, most))
    }

    /// It, but no less than this.
    #[must_use]
    pub fn at_least(&self, least: f64) -> Self {
        self.applied(|of| Node::Max(of, least))
    }

    /// Its arc tangent, radians.
    #[must_use]
    pub fn atan(&self) -> Self {
        self.applied(Node::Atan)
    }

    /// Its value with these parameters.
    #[must_use]
    pub fn value(&self, parameters: &[f64]) -> f64 {
        let value = |of: &Self| of.value(parameters);
        match &*self.0 {
            Node::Number(number) => *number,
            Node::Parameter(place, _) => parameters.get(*place).copied().unwrap_or(f64::NAN),
            Node::Two(sign, a, b) => worked_out(*sign, value(a), value(b)),
            Node::Min(of, most) => value(of).min(*most),
            Node::Max(of, least) => value(of).max(*least),
            Node::Atan(of) => value(of).atan(),
        }
    }

    fn constant(&self) -> Option<f64> {
        match *self.0 {
            Node::Number(number) => Some(number),
            _ => None,
        }
    }

    /// What follows from numbers alone is a number.
    fn applied(&self, node: impl FnOnce(Self) -> Node) -> Self {
        let applied = Self(Arc::new(node(self.clone())));
        match self.constant() {
            Some(_) => applied.value(&[]).into(),
            None => applied,
        }
    }

    fn joined(sign: char, a: Self, b: Self) -> Self {
        match (sign, a.constant(), b.constant()) {
            (_, Some(a), Some(b)) => worked_out(sign, a, b).into(),
            ('+', Some(0.0), _) | ('*', Some(1.0), _) => b,
            ('+' | '-', _, Some(0.0)) | ('*' | '/', _, Some(1.0)) => a,
            ('*', Some(0.0), _) | ('*', _, Some(0.0)) => 0.0.into(),
            _ => Self(Arc::new(Node::Two(sign, a, b))),
        }
    }
}

fn worked_out(sign: char, a: f64, b: f64) -> f64 {
    match sign {
        '+' => a + b,
        '-' => a - b,
        '*' => a * b,
        _ => a / b,
    }
}

macro_rules! operators {
    ($($operator:ident $function:ident $sign:literal)*) => {$(
        impl<F: Into<Formula>> $operator<F> for &Formula {
            type Output = Formula;
            fn $function(self, other: F) -> Formula {
                Formula::joined($sign, self.clone(), other.into())
            }
        }
        impl<F: Into<Formula>> $operator<F> for Formula {
            type Output = Formula;
            fn $function(self, other: F) -> Formula {
                Formula::joined($sign, self, other.into())
            }
        }
    )*};
}

operators! {
    Add add '+'
    Sub sub '-'
    Mul mul '*'
    Div div '/'
}

impl From<&Formula> for Formula {
    fn from(formula: &Formula) -> Self {
        formula.clone()
    }
}

/// As an attribute has it: `${…}`, or a number.
impl fmt::Display for Formula {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.constant() {
            Some(value) => f.write_str(&number(value)),
            None => write!(f, "${{{}}}", Within(self)),
        }
    }
}

/// A formula within an expression.
struct Within<'a>(&'a Formula);

impl fmt::Display for Within<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &*self.0.0 {
            Node::Number(value) if *value < 0.0 => write!(f, "({})", number(*value)),
            Node::Number(value) => f.write_str(&number(*value)),
            Node::Parameter(_, name) => write!(f, "${name}"),
            Node::Two(sign, a, b) => write!(f, "({} {sign} {})", Within(a), Within(b)),
            Node::Min(of, most) => write!(f, "min({}, {})", Within(of), number(*most)),
            Node::Max(of, least) => write!(f, "max({}, {})", Within(of), number(*least)),
            Node::Atan(of) => write!(f, "atan({})", Within(of)),
        }
    }
}
