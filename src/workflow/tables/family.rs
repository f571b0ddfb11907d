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

/// Unit of decelerations.
const HARD: &str = "m/s²";

/// So many panels beside each other, where a family does not say.
const BESIDE: usize = 5;

/// A driver in a family.
struct Seat {
    id: String,
    /// In words.
    name: String,
    driver: &'static DriverModel,
    /// Whether it knows the lanes.
    lanes: bool,
}

/// A case with the result of each driver; `None` where one has no rule.
type Driven = (Case, Vec<Option<CaseResult>>);

/// A family with what comes of its cases.
pub struct FamilyResults {
    family: Family,
    seats: Vec<Seat>,
    cases: Vec<Driven>,
}

/// The cases that differ in two parameters alone: by the horizontal, then the vertical axis of the figure.
struct Panel<'a> {
    cases: &'a [Driven],
    across: Vec<f64>,
    up: Vec<f64>,
}

impl Panel<'_> {
    /// Whether a driver avoids a case; `None` without a rule.
    fn avoids(&self, driver: usize, across: usize, up: usize) -> Option<bool> {
        let (_, results) = &self.cases[across * self.up.len() + up];
        results[driver].map(|result| result.closing_speed.is_none())
    }
}

/// What the cases of a panel have in common (km/h), and where a case stands in it.
fn place(case: &Case) -> ([Option<i64>; 2], f64, f64) {
    match *case {
        Case::CutIn {
            speed,
            other,
            gap,
            lateral,
        } => ([Some(kmh(speed)), Some(kmh(other))], gap, lateral),
        Case::CutOut {
            speed,
            front,
            lateral,
        } => ([Some(kmh(speed)), None], front, lateral),
        Case::Braking {
            speed,
            deceleration,
        } => ([None, None], kmh(speed) as f64, deceleration),
    }
}

/// Speeds of the grids are whole km/h.
fn kmh(speed: f64) -> i64 {
    (speed * 3.6).round() as i64
}

fn speed(case: &Case) -> i64 {
    let (Case::CutIn { speed, .. } | Case::CutOut { speed, .. } | Case::Braking { speed, .. }) =
        case;
    kmh(*speed)
}

impl FamilyResults {
    /// All drivers in all cases of the grid, or in those with these speeds of the ego (km/h).
    ///
    /// # Errors
    /// The grid has no such speed; the message names those that it has.
    pub fn of(family: Family, speeds: &[i64]) -> Result<Self, String> {
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
            lanes: false,
        };
        let mut seats: Vec<Seat> = DRIVERS.iter().map(seat).collect();
        if family == Family::CutIn {
            // The one whose source sees a cut-in by the lanes.
            seats.extend(
                DRIVERS
                    .iter()
                    .filter(|one| one.id == "cc")
                    .map(|driver| Seat {
                        id: format!("{}_lanes", driver.id),
                        name: format!("{} who knows the lanes, {LANE} m wide", driver.name),
                        driver,
                        lanes: true,
                    }),
            );
        }
        let driven = |case: Case| {
            let results = seats.iter().map(|seat| match seat.lanes {
                true => case.with_lanes(seat.driver, LANE),
                false => case.with(seat.driver),
            });
            (case, results.collect())
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
        let number = |name, unit, source| Column::new(name, Kind::Number, unit, source);
        let lateral = |source| number("lateral_speed", "m/s", source);
        let mut columns = vec![number("ego_speed", "m/s", "the ego's speed at the begin")];
        columns.extend(match self.family {
            Family::CutIn => vec![
                number("other_speed", "m/s", "speed of the vehicle that cuts in"),
                number(
                    "gap",
                    "m",
                    "between both along the road, once it has its lateral speed",
                ),
                lateral("lateral speed of the vehicle that cuts in"),
            ],
            Family::CutOut => vec![
                number(
                    "front_gap",
                    "m",
                    "between the vehicle that leaves the lane and the one that stands",
                ),
                lateral("lateral speed of the vehicle that leaves the lane"),
            ],
            Family::Braking => vec![number(
                "deceleration",
                HARD,
                "how hard the vehicle ahead brakes",
            )],
        });
        columns.extend(self.seats.iter().flat_map(|seat| {
            let column = |name: String, kind, unit, source: String| Column {
                name: name.into(),
                source: source.into(),
                ..Column::new("", kind, unit, "").optional()
            };
            let closing = format!("{}_closing_speed", seat.id);
            let meaning = "closing speed at its contact".into();
            [
                column(seat.id.clone(), Kind::Text, "", seat.name.clone()),
                column(closing, Kind::Number, "m/s", meaning),
            ]
        }));
        let mut table = Table::new("family", columns);
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
        let row = |(case, results): &Driven| {
            let parameters = match *case {
                Case::CutIn {
                    speed,
                    other,
                    gap,
                    lateral,
                } => vec![speed, other, gap, lateral],
                Case::CutOut {
                    speed,
                    front,
                    lateral,
                } => vec![speed, front, lateral],
                Case::Braking {
                    speed,
                    deceleration,
                } => vec![speed, deceleration],
            };
            let results = results.iter().flat_map(|result| match result {
                None => [Cell::None(""), Cell::None("")],
                Some(result) => match result.closing_speed {
                    None => ["avoided".into(), Cell::None("")],
                    Some(closing) => ["not_avoided".into(), number(closing)],
                },
            });
            parameters.into_iter().map(number).chain(results).collect()
        };
        self.cases.iter().map(row).collect()
    }

    fn panels(&self) -> Vec<Panel<'_>> {
        let chunks = self.cases.chunk_by(|a, b| place(&a.0).0 == place(&b.0).0);
        let panels = chunks.map(|cases| {
            let places = cases.iter().map(|(case, _)| place(case));
            let columns: Vec<_> = places.collect();
            let same = columns.chunk_by(|a, b| a.1 == b.1);
            let across = same.map(|column| column[0].1).collect::<Vec<_>>();
            let up = columns.iter().take(columns.len() / across.len());
            Panel {
                cases,
                up: up.map(|(.., up)| *up).collect(),
                across,
            }
        });
        panels.collect()
    }

    /// The drivers that have a rule in this family.
    fn ruled(&self) -> impl Iterator<Item = (usize, &Seat)> {
        let first = self.cases.first().map(|(_, results)| results);
        let seats = self.seats.iter().enumerate();
        seats.filter(move |(place, _)| first.is_some_and(|results| results[*place].is_some()))
    }

    /// The boundary for people: of each driver with a rule the smallest gap of the grid from which on it avoids contact, or the
    /// hardest deceleration up to which it does; and what that is, in a sentence.
    #[must_use]
    pub fn boundary(&self) -> (Vec<Column>, Vec<Row>, &'static str) {
        let column = |name: &str, unit: &'static str| Column {
            title: name.to_owned().into(),
            decimals: (unit == HARD).then_some(1),
            ..Column::new("", Kind::Number, unit, "")
        };
        let (parameters, sentence): (&[(&str, &'static str)], _) = match self.family {
            Family::CutIn => (
                &[("ego", "km/h"), ("other", "km/h"), ("lateral", "m/s")],
                "m: the smallest gap of the grid from which on the driver avoids contact; -: none",
            ),
            Family::CutOut => (
                &[("ego", "km/h"), ("lateral", "m/s")],
                "m: how far ahead who stands has to be, of the grid, for the driver to avoid contact; -: farther than the \
                 grid goes",
            ),
            Family::Braking => (
                &[("ego", "km/h")],
                "m/s²: the hardest braking ahead, of the grid, up to which the driver avoids contact; -: none",
            ),
        };
        let unit = match self.family {
            Family::Braking => HARD,
            _ => "m",
        };
        let columns = { parameters.iter() }
            .map(|(name, unit)| column(name, unit))
            .chain(self.ruled().map(|(_, seat)| column(&seat.id, unit)));
        let mut rows = Vec::new();
        for panel in self.panels() {
            let common = place(&panel.cases[0].0).0;
            let mut add = |own: f64, limit: &dyn Fn(usize) -> Option<f64>| {
                let limits = self.ruled().map(|(driver, _)| limit(driver));
                let own = std::iter::once(Cell::finite(rounded(own)));
                let common = common.iter().flatten().map(|speed| Cell::Integer(*speed));
                let limits = limits.map(|value| value.map_or(Cell::None(""), Cell::finite));
                rows.push(common.chain(own).chain(limits).collect());
            };
            let avoids = |driver, i, j| panel.avoids(driver, i, j) == Some(true);
            if self.family == Family::Braking {
                for (i, speed) in panel.across.iter().enumerate() {
                    add(*speed, &|driver| {
                        let safe = panel.up.iter().enumerate();
                        let safe = safe.take_while(|(j, _)| avoids(driver, i, *j));
                        safe.last().map(|(_, hardest)| *hardest)
                    });
                }
                continue;
            }
            for (j, lateral) in panel.up.iter().enumerate() {
                if SHOWN.iter().any(|shown| (shown - lateral).abs() < 1e-6) {
                    add(*lateral, &|driver| {
                        let safe = panel.across.iter().enumerate().rev();
                        let safe = safe.take_while(|(i, _)| avoids(driver, *i, j));
                        safe.last().map(|(_, smallest)| *smallest)
                    });
                }
            }
        }
        (columns.collect(), rows, sentence)
    }

    /// The figure, with the axes of the regulation's annex.
    #[must_use]
    pub fn chart(&self) -> BoundaryChart {
        let (across, up) = match self.family {
            Family::CutIn => ("gap (m)", "lateral speed (m/s)"),
            Family::CutOut => (
                "from the leaving vehicle to the one that stands (m)",
                "lateral speed (m/s)",
            ),
            Family::Braking => ("speed of both (km/h)", "deceleration ahead (m/s²)"),
        };
        let mut rows: Vec<Vec<BoundaryPanel>> = Vec::new();
        let mut before = None;
        for panel in self.panels() {
            let ([speed, other], ..) = place(&panel.cases[0].0);
            let name = match (speed, other) {
                (Some(speed), Some(other)) => format!("{speed} km/h, other {other}"),
                (Some(speed), None) => format!("{speed} km/h"),
                _ => String::new(),
            };
            let avoided = (0..self.seats.len()).map(|driver| {
                let cases = panel.cases.iter();
                let result = |(_, results): &Driven| {
                    results[driver].map(|result| result.closing_speed.is_none())
                };
                cases.filter_map(result).collect()
            });
            let drawn = BoundaryPanel {
                name,
                avoided: avoided.collect(),
                across: panel.across,
                up: panel.up,
            };
            // A row for each speed, or as many as have room.
            let goes_on = match other {
                Some(_) => before == speed,
                None => rows.last().is_some_and(|row| row.len() < BESIDE),
            };
            before = speed;
            match rows.last_mut().filter(|_| goes_on) {
                Some(row) => row.push(drawn),
                None => rows.push(vec![drawn]),
            }
        }
        let name = self.family.name();
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
                facts: vec![(
                    "program",
                    concat!("nearmiss ", env!("CARGO_PKG_VERSION")).into(),
                )],
            },
        }
    }
}
