//! The families of UN Regulation 157: all drivers in the cases of the grid, and the boundary in words.

use nearmiss_drive::driver::family::{Case, CaseResult, Family};
use nearmiss_drive::driver::{DRIVERS, DriverModel};
use nearmiss_record::{Cell, Column, Kind, Row};
use rayon::prelude::*;

use super::{Driven, FamilyResults, Outcome, Seat, Source, rounded};

/// How wide lanes are where a driver knows them, metres.
const LANE: f64 = 3.5;

/// The lateral speeds of the boundary for people, m/s, where a grid has them.
const SHOWN: [f64; 4] = [0.5, 1.0, 1.5, 2.5];

/// Speeds of the grids are whole km/h.
pub(super) fn kmh(speed: f64) -> i64 {
    (speed * 3.6).round() as i64
}

/// The axes of the figure, with units.
pub(super) fn axes(family: Family) -> [&'static str; 2] {
    match family {
        Family::CutIn => ["gap (m)", "lateral speed (m/s)"],
        Family::CutOut => [
            "from who leaves the lane to who stands (m)",
            "lateral speed (m/s)",
        ],
        Family::Braking => ["speed (km/h)", "deceleration ahead (m/s²)"],
    }
}

/// What the cases of a panel have in common.
pub(super) fn panel_name(common: &[f64]) -> String {
    match *common {
        [speed, other] => format!("{} km/h, other {}", kmh(speed), kmh(other)),
        [speed] => format!("{} km/h", kmh(speed)),
        _ => String::new(),
    }
}

/// The parameters of its cases.
fn parameters(family: Family) -> Vec<Column> {
    let ego = ("ego_speed", "m/s", "the ego's speed at the begin");
    let parameters = match family {
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
    let columns = parameters.map(|(n, unit, s)| Column::new(n, Kind::Number, unit, s));
    columns.collect()
}

impl From<CaseResult> for Outcome {
    fn from(result: CaseResult) -> Self {
        let avoids = result.closing_speed.is_none();
        Self {
            word: if avoids { "avoided" } else { "not_avoided" },
            closing_speed: result.closing_speed,
            avoids: Some(avoids),
        }
    }
}

/// A driver, and how wide lanes are, metres, if it knows them.
type Knowing = (Seat, &'static DriverModel, Option<f64>);

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
        let mut drivers: Vec<Knowing> = { DRIVERS.iter() }
            .map(|driver| (Seat::of(driver), driver, None))
            .collect();
        if family == Family::CutIn {
            // The one whose source sees a cut-in by the lanes.
            let known = DRIVERS.iter().filter(|driver| driver.id == "cc");
            drivers.extend(known.map(|driver| {
                let seat = Seat {
                    id: format!("{}_lanes", driver.id),
                    name: format!("{} that knows the lanes, {LANE} m wide", driver.name),
                };
                (seat, driver, Some(LANE))
            }));
        }
        let driven = |case: Case| {
            let results = drivers.iter().map(|(_, driver, lanes)| match lanes {
                Some(width) => case.with_lanes(driver, *width),
                None => case.with(driver),
            });
            Driven {
                parameters: case.parameters(),
                outcomes: Ok(results.map(|result| result.map(Outcome::from)).collect()),
            }
        };
        let cases = grid.into_par_iter().map(driven).collect();
        Ok(Self {
            source: Source::Regulation(family),
            parameters: parameters(family),
            seats: drivers.into_iter().map(|(seat, ..)| seat).collect(),
            cases,
        })
    }

    /// The boundary for people, see [`FamilyResults::boundary`].
    pub(super) fn regulation_boundary(&self, family: Family) -> (Vec<Column>, Vec<Row>, String) {
        let lateral = ("lateral", "m/s");
        let (own, unit, sentence) = match family {
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
        let ruled = self.ruled();
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
            if family == Family::Braking {
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
        (columns, rows, sentence.into())
    }
}
