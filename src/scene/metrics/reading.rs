//! The value of a measure, or the reason why there is none.

/// The value of a measure for one obstacle at one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reading {
    /// A finite number in the measure's unit.
    Value(f64),
    /// No value, and why.
    None(NoValue),
}

/// Why a measure has no value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NoValue {
    /// One of the two is absent at this step.
    Absent,
    /// The other is a region that an obstacle may cover, of an occupancy set, whose velocity nobody knows.
    Occupancy,
    /// They do not come closer along this direction.
    NotApproaching,
    /// The bodies overlap along this axis of the ego's frame, so there is no gap to close.
    Overlapping,
    /// With their present motion they do not touch within the horizon.
    NoContact,
    /// The ego has no route on the road; [`super::Context::road`] says why.
    NoRoute,
    /// The ego or the other is nowhere beside the ego's route.
    OffRoute,
    /// The other stands on no lane that the ego stands on.
    OtherLane,
    /// The other is behind the ego along its route.
    Behind,
    /// The bodies overlap along the ego's route, so there is no gap.
    Beside,
    /// The bodies touch, so there is no gap.
    Contact,
    /// The ego hardly moves along its route.
    Standing,
    /// In the recording the ego does not get to where the other is now.
    NotReached,
    /// The recorded bodies do not overlap at this step or later.
    NoRecordedOverlap,
    /// The recorded bodies never touch, at no step and between none.
    NeverTouched,
    /// A start at an earlier step avoids the recorded overlap, none from this step on does.
    TooLate,
    /// No start at any step of the recording avoids the recorded overlap.
    NeverAvoided,
    /// The two paths have no place in common, or one of the two stands all the time.
    NoConflictArea,
    /// Both are in the conflict area at the same time.
    Together,
    /// The recording begins or ends inside the conflict area.
    CutOff,
}

impl NoValue {
    /// In words, for tables and tips.
    #[must_use]
    pub fn reason(self) -> &'static str {
        match self {
            Self::Absent => "not there",
            Self::Occupancy => "an occupancy set, which has no velocity",
            Self::NotApproaching => "not approaching",
            Self::Overlapping => "bodies overlap along this axis",
            Self::NoContact => "no contact within the horizon",
            Self::NoRoute => "the ego has no route",
            Self::OffRoute => "not beside the ego's route",
            Self::OtherLane => "other lane",
            Self::Behind => "behind",
            Self::Beside => "beside",
            Self::Contact => "the bodies touch",
            Self::Standing => "the ego hardly moves",
            Self::NotReached => "not reached in the recording",
            Self::NoRecordedOverlap => "no recorded overlap to come",
            Self::NeverTouched => "no recorded contact",
            Self::TooLate => "too late",
            Self::NeverAvoided => "avoids it at no recorded step",
            Self::NoConflictArea => "no conflict area",
            Self::Together => "in the conflict area together",
            Self::CutOff => "the recording begins or ends in the conflict area",
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

impl From<Result<f64, NoValue>> for Reading {
    /// A number that is not finite is none: it stands for something out of reach.
    fn from(result: Result<f64, NoValue>) -> Self {
        match result {
            Ok(value) if value.is_finite() => Self::Value(value),
            Ok(_) => Self::None(NoValue::NoContact),
            Err(why) => Self::None(why),
        }
    }
}
