//! Families of cases: the table of all of them, the boundary of preventability, and its figure. Those of UN Regulation 157, and
//! those of a recorded encounter.

mod encounter;
mod regulation;

use nearmiss_drive::driver::DriverModel;
use nearmiss_drive::driver::family::Family;
use nearmiss_record::{Cell, Column, Kind, Row, Table};
use nearmiss_render::{BoundaryChart, BoundaryPanel, Palette, Provenance};

use super::{meanings, rounded};
pub use encounter::{EncounterCases, Vary};

/// So many panels beside each other, where they have no rows of their own.
const BESIDE: usize = 5;

/// A driver in a family.
struct Seat {
    id: String,
    name: String,
}

impl Seat {
    fn of(driver: &DriverModel) -> Self {
        Self {
            id: driver.id.into(),
            name: driver.name.into(),
        }
    }
}

/// What comes of a case with a driver.
struct Outcome {
    /// Its word in tables.
    word: &'static str,
    /// Closing speed at the contact, m/s.
    closing_speed: Option<f64>,
    /// Whether there is no contact, or one; `None` where that decides nothing.
    avoids: Option<bool>,
}

/// A case.
struct Driven {
    /// Its parameters; the last two are the axes of its panel.
    parameters: Vec<f64>,
    /// The outcome of each driver, `None` where one has no rule; or why the case could not be.
    outcomes: Result<Vec<Option<Outcome>>, String>,
}

/// What families differ in beside their cases.
enum Source {
    Regulation(Family),
    Encounter(EncounterCases),
}

/// A family with what comes of its cases.
pub struct FamilyResults {
    source: Source,
    /// What the parameters are.
    parameters: Vec<Column>,
    seats: Vec<Seat>,
    cases: Vec<Driven>,
}

/// The cases that differ in their last two parameters alone: the horizontal and the vertical axis of the figure.
struct Panel<'a> {
    common: &'a [f64],
    across: Vec<f64>,
    up: Vec<f64>,
    cases: &'a [Driven],
}

impl Panel<'_> {
    /// Whether a driver has no contact in the cases, by the horizontal, then the vertical axis; empty where it decides none.
    fn avoided(&self, driver: usize) -> Vec<bool> {
        let decided = { self.cases.iter() }.any(|case| case.avoids(driver).is_some());
        let cases = self.cases.iter().filter(|_| decided);
        cases
            .map(|case| case.avoids(driver) != Some(false))
            .collect()
    }
}

impl Driven {
    /// What it has in common with the others of its panel.
    fn common(&self) -> &[f64] {
        &self.parameters[..self.parameters.len().saturating_sub(2)]
    }

    /// Where it stands in it.
    fn place(&self) -> [f64; 2] {
        match self.parameters[..] {
            [.., across, up] => [across, up],
            [across] => [across, 0.0],
            [] => [0.0; 2],
        }
    }

    /// Whether it could be driven, but a driver decides nothing.
    fn is_undecided_by(&self, driver: usize) -> bool {
        self.outcomes.is_ok() && self.avoids(driver).is_none()
    }

    fn avoids(&self, driver: usize) -> Option<bool> {
        self.outcomes.as_ref().ok()?[driver].as_ref()?.avoids
    }
}

impl FamilyResults {
    /// The table: a row for each case.
    #[must_use]
    pub fn table(&self) -> Table {
        let results = self.seats.iter().flat_map(|seat| {
            let contact = Column::new("", Kind::Number, "m/s", "closing speed at its contact");
            let result = Column {
                name: seat.id.clone().into(),
                source: seat.name.clone().into(),
                ..Column::new("", Kind::Text, "", "").optional()
            };
            let name = format!("{}_closing_speed", seat.id).into();
            [
                result,
                Column {
                    name,
                    ..contact.optional()
                },
            ]
        });
        let invalid = matches!(self.source, Source::Encounter(_)).then(|| {
            Column::new(
                "invalid",
                Kind::Text,
                "",
                "why the case could not be; then it has no results",
            )
            .optional()
        });
        let parameters = self.parameters.iter().cloned();
        let mut table = Table::new("family", parameters.chain(invalid).chain(results).collect());
        table.metadata = vec![
            ("version", env!("CARGO_PKG_VERSION").into()),
            ("family", self.name()),
            ("columns", meanings(&table).to_string()),
        ];
        table
    }

    /// Its name.
    fn name(&self) -> String {
        match &self.source {
            Source::Regulation(family) => family.name().into(),
            Source::Encounter(cases) => cases.name.clone(),
        }
    }

    /// Its rows.
    #[must_use]
    pub fn rows(&self) -> Vec<Row> {
        let number = |value: f64| Cell::finite(rounded(value));
        let result = |outcome: Option<&Outcome>| match outcome {
            None => [Cell::None(""), Cell::None("")],
            Some(one) => [
                one.word.into(),
                one.closing_speed.map_or(Cell::None(""), number),
            ],
        };
        let row = |case: &Driven| {
            let parameters = case.parameters.iter().map(|value| number(*value));
            let invalid =
                matches!(self.source, Source::Encounter(_)).then(|| match &case.outcomes {
                    Ok(_) => Cell::None(""),
                    Err(why) => why.clone().into(),
                });
            let outcome = |driver: usize| case.outcomes.as_ref().ok()?[driver].as_ref();
            let results = (0..self.seats.len()).flat_map(|driver| result(outcome(driver)));
            parameters.chain(invalid).chain(results).collect()
        };
        self.cases.iter().map(row).collect()
    }

    fn panels(&self) -> impl Iterator<Item = Panel<'_>> {
        let alike = self.cases.chunk_by(|a, b| a.common() == b.common());
        alike.map(|cases| {
            let columns = cases.chunk_by(|a, b| a.place()[0] == b.place()[0]);
            let across: Vec<f64> = columns.map(|column| column[0].place()[0]).collect();
            let column = &cases[..cases.len() / across.len()];
            Panel {
                common: cases[0].common(),
                up: column.iter().map(|case| case.place()[1]).collect(),
                across,
                cases,
            }
        })
    }

    /// The drivers that decide a case.
    fn ruled(&self) -> Vec<usize> {
        let mut ruled: Vec<usize> = (0..self.seats.len()).collect();
        ruled.retain(|driver| self.cases.iter().any(|case| case.avoids(*driver).is_some()));
        ruled
    }

    /// Which drivers with a rule decide not all cases, in words for the figure.
    fn undecided(&self) -> Option<String> {
        let count = |driver: &usize| {
            let cases = self.cases.iter();
            let count = cases.filter(|case| case.is_undecided_by(*driver)).count();
            (count > 0).then(|| format!("{} {count}", self.seats[*driver].id))
        };
        let all: Vec<String> = self.ruled().iter().filter_map(count).collect();
        let valid = self
            .cases
            .iter()
            .filter(|case| case.outcomes.is_ok())
            .count();
        (!all.is_empty()).then(|| format!("not decided of {valid} cases: {}", all.join(", ")))
    }

    /// The boundary for people, with what it is in a sentence: of the regulation's families of each driver with a rule the
    /// smallest gap of the grid from which on it avoids contact (m), or the hardest deceleration up to which it does (m/s²); of an
    /// encounter's the values of its first parameter at which it does not.
    #[must_use]
    pub fn boundary(&self) -> (Vec<Column>, Vec<Row>, String) {
        match &self.source {
            Source::Regulation(family) => self.regulation_boundary(*family),
            Source::Encounter(cases) => self.encounter_boundary(cases),
        }
    }

    /// The figure: of the regulation's families with the axes of its annex.
    #[must_use]
    pub fn chart(&self) -> BoundaryChart {
        let [across, up] = match &self.source {
            Source::Regulation(family) => regulation::axes(*family).map(String::from),
            Source::Encounter(cases) => cases.axes(),
        };
        let mut rows: Vec<Vec<BoundaryPanel>> = Vec::new();
        let mut before = None;
        for panel in self.panels() {
            let name = match &self.source {
                Source::Regulation(_) => regulation::panel_name(panel.common),
                Source::Encounter(cases) => cases.panel_name(panel.common),
            };
            let in_kmh = |speed: &f64| regulation::kmh(*speed) as f64;
            let drawn = BoundaryPanel {
                name,
                avoided: (0..self.seats.len())
                    .map(|seat| panel.avoided(seat))
                    .collect(),
                invalid: panel
                    .cases
                    .iter()
                    .map(|case| case.outcomes.is_err())
                    .collect(),
                across: match self.source {
                    Source::Regulation(Family::Braking) => {
                        panel.across.iter().map(in_kmh).collect()
                    }
                    _ => panel.across,
                },
                up: panel.up,
                recorded: match &self.source {
                    Source::Regulation(_) => None,
                    Source::Encounter(cases) => cases.recorded(panel.common),
                },
            };
            // Cut-ins have a row for each speed.
            let is_cut_in = matches!(self.source, Source::Regulation(Family::CutIn));
            let speed = panel.common.first().copied();
            let has_room = rows.last().is_some_and(|row| row.len() < BESIDE);
            let goes_on = has_room && (!is_cut_in || before == speed);
            before = speed;
            match rows.last_mut().filter(|_| goes_on) {
                Some(row) => row.push(drawn),
                None => rows.push(vec![drawn]),
            }
        }
        let name = self.name();
        let whose = match self.source {
            Source::Regulation(_) => "UN Regulation 157, family",
            Source::Encounter(_) => "Family of",
        };
        let program = concat!("nearmiss ", env!("CARGO_PKG_VERSION"));
        BoundaryChart {
            across,
            up,
            drivers: self.seats.iter().map(|seat| seat.id.clone()).collect(),
            rows,
            note: match self.source {
                Source::Regulation(_) => None,
                Source::Encounter(_) => self.undecided(),
            },
            palette: Palette::paper(),
            provenance: Provenance {
                title: format!("nearmiss, boundary of preventability, {name}"),
                description: format!(
                    "{whose} {name}: {} cases, and which drivers avoid contact.",
                    self.cases.len()
                ),
                facts: vec![("program", program.into())],
            },
        }
    }
}
