//! The measures of the metrics frame: their columns, and their words in sentences.

use std::borrow::Cow;

use super::table::{Column, column};
use crate::metrics::{Danger, Measure, MeasureList};

/// A measure that is told at every step.
pub(super) struct Said {
    pub id: &'static str,
    /// Its title where it has one of its own.
    title: Cow<'static, str>,
    /// Words of the prose before the number.
    pub before: Cow<'static, str>,
    /// Words after it: its unit.
    pub after: Cow<'static, str>,
    /// Whether it belongs to the one before it.
    pub continues: bool,
}

/// A measure of which the worst value over the window is told.
pub(super) struct Worst {
    pub id: &'static str,
    title: Cow<'static, str>,
    /// Words of the prose before the number.
    pub before: Cow<'static, str>,
    /// Words after it: its unit.
    pub after: Cow<'static, str>,
}

/// The measures of a description.
pub(super) struct MeasureColumns {
    pub said: Vec<Said>,
    pub worst: Vec<Worst>,
}

/// The usual measures: id, title, words of the prose before and after.
const SAID: [[&str; 4]; 7] = [
    ["distance", "distance [m]", "distance ", " m"],
    [
        "ttc_long",
        "ttc long [s]",
        "time to close the gap longitudinal ",
        " s",
    ],
    ["ttc_lat", "ttc lat [s]", "lateral ", " s"],
    ["ttc", "ttc [s]", "time to collision ", " s"],
    ["time_gap", "time gap [s]", "time gap ", " s"],
    ["drac", "drac [m/s²]", "deceleration needed ", " m/s²"],
    ["risk", "risk", "risk score ", ""],
];

/// The usual measures whose worst values over the window are told.
const WORST: [[&str; 4]; 4] = [
    ["distance", "min distance [m]", "smallest distance ", " m"],
    ["ttc", "min ttc [s]", "smallest time to collision ", " s"],
    [
        "drac",
        "max drac [m/s²]",
        "largest deceleration needed ",
        " m/s²",
    ],
    ["risk", "min risk", "lowest risk score ", ""],
];

impl MeasureColumns {
    /// Those of the chosen measures; the usual ones for `None`.
    pub fn new(chosen: Option<&MeasureList>) -> Self {
        let Some(chosen) = chosen else {
            let said = SAID.map(|[id, title, before, after]| Said {
                id,
                title: title.into(),
                before: before.into(),
                after: after.into(),
                continues: id == "ttc_lat",
            });
            let worst = WORST.map(|[id, title, before, after]| Worst {
                id,
                title: title.into(),
                before: before.into(),
                after: after.into(),
            });
            return Self {
                said: said.into(),
                worst: worst.into(),
            };
        };
        let said = chosen.iter().map(|measure| Said {
            id: measure.id,
            title: title(measure).into(),
            before: format!("{} ", measure.name).into(),
            after: unit(measure).into(),
            continues: false,
        });
        // Where neither side is dangerous there is no worst value.
        let graded = chosen.iter().filter(|m| m.danger != Danger::Neutral);
        let worst = graded.map(|measure| Worst {
            id: measure.id,
            title: format!("{} {}", measure.danger.extreme(), title(measure)).into(),
            before: match measure.danger {
                Danger::High => format!("largest {} ", measure.name).into(),
                Danger::Low | Danger::Neutral => format!("smallest {} ", measure.name).into(),
            },
            after: unit(measure).into(),
        });
        Self {
            said: said.collect(),
            worst: worst.collect(),
        }
    }

    /// The columns of every step.
    pub fn columns(&self) -> Vec<Column> {
        let columns = self.said.iter().map(|one| Column {
            title: one.title.clone(),
            quantity: one.id,
        });
        columns.collect()
    }

    /// The columns of the worst values: two for each measure, the value and its time.
    pub fn worst_columns(&self) -> Vec<Column> {
        let columns = self.worst.iter().flat_map(|one| {
            let value = Column {
                title: one.title.clone(),
                quantity: one.id,
            };
            [value, column("at t [s]", "time")]
        });
        columns.collect()
    }
}

/// What a measure is called in the tables of the metrics frame: `ttc long`.
#[must_use]
pub fn measure_column(measure: &Measure) -> String {
    measure.id.replace('_', " ")
}

/// The title of its column, with its unit: `ttc long [s]`.
fn title(measure: &Measure) -> String {
    let name = measure_column(measure);
    match measure.unit {
        "" => name,
        unit => format!("{name} [{unit}]"),
    }
}

fn unit(measure: &Measure) -> String {
    match measure.unit {
        "" => String::new(),
        unit => format!(" {unit}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chosen_measures_are_titled_as_the_usual_ones() {
        let ids = SAID.map(|[id, ..]| id);
        let chosen = MeasureList::of(ids).ok();
        let titles = |columns: &MeasureColumns| {
            let titles = columns.columns().into_iter().map(|c| c.title.into_owned());
            titles.collect::<Vec<_>>()
        };
        let usual = titles(&MeasureColumns::new(None));
        assert_eq!(titles(&MeasureColumns::new(chosen.as_ref())), usual);
        let neutral = MeasureList::parse("v_rel_long").ok();
        assert!(MeasureColumns::new(neutral.as_ref()).worst.is_empty());
    }
}
