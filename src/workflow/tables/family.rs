//! The families of UN Regulation 157: the table of their cases, the boundary of preventability, and its figure.

use nearmiss_drive::driver::family::{Case, CaseResult, Family};
use nearmiss_drive::driver::{DRIVERS, DriverModel};
use nearmiss_record::{Cell, Column, Kind, Row, Table};
use nearmiss_render::{BoundaryChart, BoundaryPanel, Palette, Provenance};
use rayon::prelude::*;

use super::{meanings, rounded};

/// How wide lanes are where a driver knows them, metres.
const LANE: f64 = 3.5;

/// The lateral speeds of the boundary for people, m/s, where a grid has them.
const SHOWN: [f64; 4] = [0.5, 1.0, 1.5, 2.5];

/// So many panels of cut-outs beside each other.
const BESIDE: usize = 5;

/// A driver in a family.
struct Seat {
    id: String,
    name: String,
    driver: &'static DriverModel,
    /// How wide lanes are, metres, if it knows them.
    lanes: Option<f64>,
}

/// The parameters of a case, and the result of each driver; `None` where one has no rule.
type Driven = (Vec<f64>, Vec<Option<CaseResult>>);

/// A family with what comes of its cases.
pub struct FamilyResults {
    family: Family,
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
    /// Whether a driver avoids the cases, by the horizontal, then the vertical axis; empty without a rule.
    fn avoided(&self, driver: usize) -> Vec<bool> {
        let results = self.cases.iter().filter_map(|(_, results)| results[driver]);
        results
            .map(|result| result.closing_speed.is_none())
            .collect()
    }
}

/// What a case has in common with the others of its panel.
fn common((parameters, _): &Driven) -> &[f64] {
    &parameters[..parameters.len() - 2]
}

/// Where it stands in it.
fn place((parameters, _): &Driven) -> (f64, f64) {
    let end = parameters.len();
    (parameters[end - 2], parameters[end - 1])
}

/// Speeds of the grids are whole km/h.
fn kmh(speed: f64) -> i64 {
    (speed * 3.6).round() as i64
}

impl FamilyResults {
    /// All drivers in all cases of the grid, or in those with these speeds of the ego (km/h).
    ///
    /// # Errors
    /// The grid has no such speed; the message names those that it has.
    pub fn of(family: Family, speeds: &[i64]) -> Result<Self, String> {
        let speed = |case: &Case| kmh(case.parameters()[0]);
        let mut grid = Case::grid(family);
        let mut known: Vec<i64> = grid.iter().map(speed).collect();
        known.dedup();
        if let Some(other) = speeds.iter().find(|asked| !known.contains(asked)) {
            let known: Vec<String> = known.iter().map(i64::to_string).collect();
            let (name, known) = (family.name(), known.join(", "));
            return Err(format!("{name} has no case with {other} km/h, but {known}"));
        }
        grid.retain(|case| speeds.is_empty() || speeds.contains(&speed(case)));
        let seat = |driver: &'static DriverModel| Seat {
            id: driver.id.into(),
            name: driver.name.into(),
            driver,
            lanes: None,
        };
        let mut seats: Vec<Seat> = DRIVERS.iter().map(seat).collect();
        if family == Family::CutIn {
            // The one whose source sees a cut-in by the lanes.
            let known = DRIVERS.iter().filter(|driver| driver.id == "cc");
            seats.extend(known.map(|driver| Seat {
                id: format!("{}_lanes", driver.id),
                name: format!("{} that knows the lanes, {LANE} m wide", driver.name),
                lanes: Some(LANE),
                ..seat(driver)
            }));
        }
        let driven = |case: Case| {
            let results = seats.iter().map(|seat| match seat.lanes {
                Some(width) => case.with_lanes(seat.driver, width),
                None => case.with(seat.driver),
            });
            (case.parameters(), results.collect())
        };
        let cases = grid.into_par_iter().map(driven).collect();
        Ok(Self {
            family,
            seats,
            cases,
        })
    }

    /// The table: a row for each case.
    #[must_use]
    pub fn table(&self) -> Table {
        let ego = ("ego_speed", "m/s", "the ego's speed at the begin");
        let parameters = match self.family {
            Family::CutIn => vec![
                ego,
                ("other_speed", "m/s", "of who cuts in"),
                ("gap", "m", "to who cuts in, once it has its lateral speed"),
                ("lateral_speed", "m/s", "of who cuts in"),
            ],
            Family::CutOut => vec![
                ego,
                ("front_gap", "m", "from who leaves the lane to who stands"),
                ("lateral_speed", "m/s", "of who leaves the lane"),
            ],
            Family::Braking => vec![ego, ("deceleration", "m/s²", "of who is ahead")],
        };
        let parameters = parameters.into_iter();
        let parameters = parameters.map(|(n, unit, s)| Column::new(n, Kind::Number, unit, s));
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
        let mut table = Table::new("family", parameters.chain(results).collect());
        table.metadata = vec![
            ("version", env!("CARGO_PKG_VERSION").into()),
            ("family", self.family.name().into()),
            ("columns", meanings(&table).to_string()),
        ];
        table
    }

    /// Its rows.
    #[must_use]
    pub fn rows(&self) -> Vec<Row> {
        let number = |value: f64| Cell::finite(rounded(value));
        let result = |result: &Option<CaseResult>| match result.map(|one| one.closing_speed) {
            None => [Cell::None(""), Cell::None("")],
            Some(None) => ["avoided".into(), Cell::None("")],
            Some(Some(closing)) => ["not_avoided".into(), number(closing)],
        };
        let row = |(parameters, results): &Driven| {
            let parameters = parameters.iter().map(|value| number(*value));
            parameters.chain(results.iter().flat_map(result)).collect()
        };
        self.cases.iter().map(row).collect()
    }

    fn panels(&self) -> impl Iterator<Item = Panel<'_>> {
        let alike = self.cases.chunk_by(|a, b| common(a) == common(b));
        alike.map(|cases| {
            let columns = cases.chunk_by(|a, b| place(a).0 == place(b).0);
            let across: Vec<f64> = columns.map(|column| place(&column[0]).0).collect();
            let column = &cases[..cases.len() / across.len()];
            Panel {
                common: common(&cases[0]),
                up: column.iter().map(|case| place(case).1).collect(),
                across,
                cases,
            }
        })
    }

    /// The boundary for people, with what it is in a sentence: of each driver with a rule the smallest gap of the grid from
    /// which on it avoids contact (m), or the hardest deceleration up to which it does (m/s²).
    #[must_use]
    pub fn boundary(&self) -> (Vec<Column>, Vec<Row>, &'static str) {
        let lateral = ("lateral", "m/s");
        let (own, unit, sentence) = match self.family {
            Family::CutIn => (
                lateral,
                "m",
                "the smallest gap of the grid from which on a driver avoids contact; -: there is none",
            ),
            Family::CutOut => (
                lateral,
                "m",
                "how far from who leaves the lane who stands has to be, in the grid, for a driver to avoid contact; \
                 -: farther",
            ),
            Family::Braking => (
                ("ego", "km/h"),
                "m/s²",
                "the hardest braking ahead, of the grid, up to which a driver avoids contact; -: there is none",
            ),
        };
        let mut ruled: Vec<usize> = (0..self.seats.len()).collect();
        ruled.retain(|driver| { self.cases.iter() }.any(|(_, results)| results[*driver].is_some()));
        let (mut rows, mut count) = (Vec::new(), 0);
        for panel in self.panels() {
            count = panel.common.len();
            let (across, up) = (&panel.across, &panel.up);
            let avoided: Vec<_> = ruled.iter().map(|driver| panel.avoided(*driver)).collect();
            // Cases with their values, from those that are easiest to avoid.
            let mut add = |own: Cell, line: Vec<(usize, f64)>| {
                let limits = avoided.iter().map(|avoided| {
                    let safe = line.iter().take_while(|(case, _)| avoided[*case]);
                    safe.last()
                        .map_or(Cell::None(""), |(_, limit)| Cell::finite(*limit))
                });
                let speeds = { panel.common.iter() }.map(|speed| Cell::Integer(kmh(*speed)));
                rows.push(speeds.chain([own]).chain(limits).collect());
            };
            if self.family == Family::Braking {
                for (i, speed) in across.iter().enumerate() {
                    let line = up.iter().enumerate();
                    let line = line.map(|(j, value)| (i * up.len() + j, *value));
                    add(Cell::Integer(kmh(*speed)), line.collect());
                }
                continue;
            }
            for (j, lateral) in up.iter().enumerate() {
                if SHOWN.iter().any(|shown| (shown - lateral).abs() < 1e-6) {
                    let line = across.iter().enumerate().rev();
                    let line = line.map(|(i, value)| (i * up.len() + j, *value));
                    add(Cell::finite(rounded(*lateral)), line.collect());
                }
            }
        }
        let speeds = [("ego", "km/h"), ("other", "km/h")].into_iter().take(count);
        let ids = ruled.iter().map(|driver| (&*self.seats[*driver].id, unit));
        let column = |(title, unit): (&str, &'static str)| Column {
            title: title.to_owned().into(),
            decimals: (unit == "m/s²").then_some(1),
            ..Column::new("", Kind::Number, unit, "")
        };
        let columns = speeds.chain([own]).chain(ids).map(column).collect();
        (columns, rows, sentence)
    }

    /// The figure, with the axes of the regulation's annex.
    #[must_use]
    pub fn chart(&self) -> BoundaryChart {
        let (across, up) = match self.family {
            Family::CutIn => ("gap (m)", "lateral speed (m/s)"),
            Family::CutOut => (
                "from who leaves the lane to who stands (m)",
                "lateral speed (m/s)",
            ),
            Family::Braking => ("speed (km/h)", "deceleration ahead (m/s²)"),
        };
        let mut rows: Vec<Vec<BoundaryPanel>> = Vec::new();
        let mut before = None;
        for panel in self.panels() {
            let name = match *panel.common {
                [speed, other] => format!("{} km/h, other {}", kmh(speed), kmh(other)),
                [speed] => format!("{} km/h", kmh(speed)),
                _ => String::new(),
            };
            let in_kmh = |speed: &f64| kmh(*speed) as f64;
            let drawn = BoundaryPanel {
                name,
                avoided: (0..self.seats.len())
                    .map(|seat| panel.avoided(seat))
                    .collect(),
                across: match self.family {
                    Family::Braking => panel.across.iter().map(in_kmh).collect(),
                    _ => panel.across,
                },
                up: panel.up,
            };
            // Cut-ins have a row for each speed.
            let speed = panel.common.first().copied();
            let has_room = rows.last().is_some_and(|row| row.len() < BESIDE);
            let goes_on = has_room && (self.family != Family::CutIn || before == speed);
            before = speed;
            match rows.last_mut().filter(|_| goes_on) {
                Some(row) => row.push(drawn),
                None => rows.push(vec![drawn]),
            }
        }
        let name = self.family.name();
        let program = concat!("nearmiss ", env!("CARGO_PKG_VERSION"));
        BoundaryChart {
            across: across.into(),
            up: up.into(),
            drivers: self.seats.iter().map(|seat| seat.id.clone()).collect(),
            rows,
            palette: Palette::paper(),
            provenance: Provenance {
                title: format!("nearmiss, boundary of preventability, {name}"),
                description: format!(
                    "UN Regulation 157, family {name}: {} cases, and which drivers avoid contact.",
                    self.cases.len()
                ),
                facts: vec![("program", program.into())],
            },
        }
    }
}
