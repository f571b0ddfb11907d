//! Measures by name; values and lists of them.

use nearmiss_base::system::unknown;

use super::{Measure, measures};

/// The measure with this id.
#[must_use]
pub fn measure(id: &str) -> Option<&'static Measure> {
    measures().find(|m| m.id == id)
}

/// Measures chosen by id, each once, in the order in which they were named.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct MeasureList {
    /// Places in [`measures`]; those from `count` on are 0.
    places: [u8; Self::MOST],
    count: u8,
}

impl MeasureList {
    /// Most measures of a list: more columns no model follows.
    pub const MOST: usize = 12;

    /// The measures with these ids.
    ///
    /// # Errors
    /// An unknown id, with those that it may mean; an id named twice; none, or more than [`Self::MOST`].
    pub fn from_ids<'a>(ids: impl IntoIterator<Item = &'a str>) -> Result<Self, String> {
        let mut list = Self {
            places: [0; Self::MOST],
            count: 0,
        };
        for id in ids.into_iter().map(str::trim) {
            let place = measures().position(|measure| measure.id == id);
            let Some(place) = place.and_then(|place| u8::try_from(place).ok()) else {
                return Err(unknown("measure", id, measures().map(|m| m.id)));
            };
            if list.places[..list.len()].contains(&place) {
                return Err(format!("measure `{id}` is named twice"));
            }
            let Some(free) = list.places.get_mut(usize::from(list.count)) else {
                return Err(format!("more than {} measures", Self::MOST));
            };
            *free = place;
            list.count += 1;
        }
        match list.count {
            0 => Err("no measure is named".into()),
            _ => Ok(list),
        }
    }

    /// The measures in a text such as `ttc,thw,drac`.
    ///
    /// # Errors
    /// As [`Self::from_ids`].
    pub fn parse(text: &str) -> Result<Self, String> {
        Self::from_ids(text.split(','))
    }

    fn len(&self) -> usize {
        usize::from(self.count)
    }

    /// The measures, as they were named.
    pub fn iter(&self) -> impl Iterator<Item = &'static Measure> + use<> {
        let places = self.places;
        (0..self.len()).filter_map(move |at| measures().nth(usize::from(places[at])))
    }

    /// Their ids.
    #[must_use]
    pub fn ids(&self) -> Vec<&'static str> {
        self.iter().map(|measure| measure.id).collect()
    }
}

impl std::fmt::Display for MeasureList {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.ids().join(","))
    }
}

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
    /// The other is a region that an obstacle may cover, of an occupancy set, whose velocity is unknown.
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
    /// The kind of one of the two says nothing of its mass.
    NoMass,
    /// No curve of injuries is published for the people at most risk in such a contact.
    NoCurve,
    /// The contact is harder than the curve of injuries tells.
    BeyondCurve,
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
    /// A formula divides by 0, takes the root of a negative number or the like.
    NotFinite,
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
            Self::NoMass => "no mass for this kind of obstacle",
            Self::NoCurve => "no published injury curve for this contact",
            Self::BeyondCurve => "beyond the range of the injury curve",
            Self::TooLate => "too late",
            Self::NeverAvoided => "avoids it at no recorded step",
            Self::NoConflictArea => "no conflict area",
            Self::Together => "in the conflict area together",
            Self::CutOff => "the recording begins or ends in the conflict area",
            Self::NotFinite => "the formula gives no finite number",
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

#[cfg(test)]
mod tests {
    use super::*;

    use crate::metrics::{MEASURES, measure};

    #[test]
    fn ids_keep_their_order_and_mistakes_are_named() {
        let list = MeasureList::parse("thw, ttc,drac").map(|list| list.to_string());
        assert_eq!(list.as_deref(), Ok("thw,ttc,drac"));
        assert!(measure("thw").is_some() && MEASURES.len() <= usize::from(u8::MAX));
        let wrong = |text: &str| MeasureList::parse(text).expect_err(text);
        assert!(wrong("ttc,darc").contains("drac"), "{}", wrong("ttc,darc"));
        assert!(wrong("ttc,ttc").contains("twice"));
        assert!(wrong("").contains("measure"));
        let many: Vec<&str> = MEASURES.iter().map(|m| m.id).take(13).collect();
        assert!(wrong(&many.join(",")).contains("more than 12"));
    }
}
