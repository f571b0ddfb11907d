//! A short list of measures, chosen by id, such as the columns of a description.

use super::{MEASURES, Measure};
use nearmiss_base::system::unknown;

/// Measures chosen by id, each once, in the order in which they were named.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct MeasureList {
    /// Places in [`MEASURES`]; those from `count` on are 0.
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
    pub fn of<'a>(ids: impl IntoIterator<Item = &'a str>) -> Result<Self, String> {
        let mut list = Self {
            places: [0; Self::MOST],
            count: 0,
        };
        for id in ids.into_iter().map(str::trim) {
            let place = MEASURES.iter().position(|measure| measure.id == id);
            let Some(place) = place.and_then(|place| u8::try_from(place).ok()) else {
                return Err(unknown("measure", id, MEASURES.iter().map(|m| m.id)));
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
    /// As [`Self::of`].
    pub fn parse(text: &str) -> Result<Self, String> {
        Self::of(text.split(','))
    }

    fn len(&self) -> usize {
        usize::from(self.count)
    }

    /// The measures, as they were named.
    pub fn iter(&self) -> impl Iterator<Item = &'static Measure> + use<> {
        let places = self.places;
        (0..self.len()).map(move |at| &MEASURES[usize::from(places[at])])
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::measure;

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
