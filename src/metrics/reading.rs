//! The value of a measure, or the reason why there is none.

/// What a measure says about one obstacle at one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reading {
    /// A finite number in the measure's unit.
    Value(f64),
    /// There is no number, and this is why.
    None(NoValue),
}

/// Why a measure has no value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NoValue {
    /// One of the two is not there at this step.
    Absent,
    /// They do not come closer along this direction.
    NotApproaching,
    /// With their present velocities they do not touch within the horizon.
    NoContact,
}

impl NoValue {
    /// In words, for tables and tips.
    #[must_use]
    pub fn reason(self) -> &'static str {
        match self {
            Self::Absent => "not there",
            Self::NotApproaching => "not approaching",
            Self::NoContact => "no contact within the horizon",
        }
    }
}

impl Reading {
    /// The number, if there is one.
    #[must_use]
    pub fn value(self) -> Option<f64> {
        match self {
            Self::Value(value) => Some(value),
            Self::None(_) => None,
        }
    }
}
