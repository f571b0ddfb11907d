//! The family of an encounter: what is varied, all drivers in its cases, and the boundary in words.

use std::str::FromStr;

use nearmiss_drive::driver::{DRIVERS, DriverVerdict};
use nearmiss_drive::generation::{EncounterFamily, Values, Varied};
use nearmiss_formats::{Entry, VariedMotion};
use nearmiss_record::{Cell, Column, Kind, Row};
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::Scene;
use rayon::prelude::*;

use super::{Driven, FamilyResults, Outcome, Panel, Seat, Source};
use crate::{INDEX_RADIUS, VariantOrigin};

/// A parameter to vary, `gap`, `gap=2..20` or `gap=2..20:0.5`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vary {
    varied: Varied,
    range: Option<Range>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Range {
    from: f64,
    to: f64,
    step: Option<f64>,
}

impl FromStr for Vary {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, range) = match text.split_once('=') {
            Some((name, range)) => (name, Some(range)),
            None => (text, None),
        };
        let varied: Varied = name.trim().parse()?;
        let range = range.map(str::parse).transpose();
        Ok(Self {
            varied,
            range: range.map_err(|why: String| format!("{name}: {why}"))?,
        })
    }
}

impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = || format!("`{text}` is no range; write 2..20, or 2..20:0.5 with its step");
        let number = |text: &str| match text.trim().parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(form()),
        };
        let (from, rest) = text.split_once("..").ok_or_else(form)?;
        let (to, step) = match rest.split_once(':') {
            Some((to, step)) => (to, Some(number(step)?)),
            None => (rest, None),
        };
        let (from, to) = (number(from)?, number(to)?);
        if from > to {
            return Err(format!("`{text}` ends before it begins"));
        }
        if step.is_some_and(|step| step <= 0.0) {
            return Err(format!("the step of `{text}` is not above 0"));
        }
        Ok(Self { from, to, step })
    }
}

/// Values of an axis, and of the panels, where no step is told.
const ALONG: usize = 21;
const PANELS: usize = 5;

/// No family has more cases.
const MOST: usize = 20_000;

/// A value that is so near to an end of a range is in it, as a share of its step.
const ROUNDING: f64 = 1e-6;

impl Vary {
    /// Its values, about `count` where no step is told; around the recorded one where no range is.
    fn values(&self, family: &EncounterFamily<'_>, count: usize) -> Result<Vec<f64>, String> {
        let (name, dt) = (self.varied.name(), family.dt());
        let base = family.base(self.varied)?;
        let is_start = self.varied == Varied::Start;
        let usual = match self.varied {
            Varied::Gap => 1.0,
            Varied::Closing => 0.5,
            Varied::LateralSpeed => 0.1,
            Varied::Start => (0.1 / dt).round().max(1.0) * dt,
        };
        let Some(Range { from, to, step }) = self.range else {
            let (reach, step) = match count {
                PANELS => (2, 5.0 * usual),
                _ => (10, usual),
            };
            let all = (-reach..=reach).map(|i| base + f64::from(i) * step);
            return Ok(all.filter(|value| self.is_allowed(*value)).collect());
        };
        let step = step.unwrap_or_else(|| round_step((to - from) / (count - 1) as f64));
        let step = match step {
            step if !is_start => step,
            step if self.range.is_some_and(|range| range.step.is_none()) => {
                (step / dt).ceil().max(1.0) * dt
            }
            step => step,
        };
        if is_start {
            let most = family.seconds();
            if from < -most || to > most {
                return Err(format!(
                    "{name} is within ±{most:.1} s, the length of the recording"
                ));
            }
            let whole = |value: f64| ((value / dt).round() * dt - value).abs() < ROUNDING;
            if let Some(broken) = [from, step].into_iter().find(|value| !whole(*value)) {
                return Err(format!(
                    "{name} moves in whole time steps of {dt} s, and not by {broken} s"
                ));
            }
        }
        if !self.is_allowed(from) {
            return Err(format!("{name} is above 0, and not {from}"));
        }
        let last = ((to - from) / step + ROUNDING).floor();
        if last >= MOST as f64 {
            return Err(format!(
                "{name} has {} values; take a longer step",
                last + 1.0
            ));
        }
        Ok((0..=last as usize)
            .map(|i| from + i as f64 * step)
            .collect())
    }

    fn is_allowed(&self, value: f64) -> bool {
        self.varied != Varied::LateralSpeed || value > 0.0
    }
}

/// The next 1, 2 or 5 of a power of ten.
fn round_step(least: f64) -> f64 {
    if least <= 0.0 {
        return 1.0;
    }
    let power = 10_f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    let fits = |step: &f64| *step >= least * (1.0 - ROUNDING);
    steps.into_iter().find(fits).unwrap_or(least)
}

/// Cases of an encounter: each value of a parameter with each of the others.
#[derive(Debug, Clone)]
pub struct EncounterCases {
    /// Scenario, encounter and manoeuvre.
    pub name: String,
    /// In the order that was asked for: across, up, and that of the panels; each with its recorded value and its values.
    axes: Vec<Axis>,
}

#[derive(Debug, Clone)]
struct Axis {
    varied: Varied,
    recorded: f64,
    values: Vec<f64>,
}

impl Axis {
    /// `gap (m)`.
    fn title(&self) -> String {
        let name = self.varied.name().replace('_', " ");
        format!("{name} ({})", self.varied.unit())
    }

    fn range(&self) -> (Varied, [f64; 2]) {
        let (first, last) = (self.values.first(), self.values.last());
        let end = |value: Option<&f64>| value.copied().unwrap_or(self.recorded);
        // What was recorded is one of the values that are meant.
        let [least, most] = [end(first).min(self.recorded), end(last).max(self.recorded)];
        (self.varied, [least, most])
    }
}

/// A value with as many digits as it needs, at most two.
fn short(value: f64) -> String {
    // Zero without its sign.
    (((value * 100.0).round() + 0.0) / 100.0).to_string()
}

impl EncounterCases {
    /// The cases of the most severe encounter in the scene of an entry, and the family that they are of.
    ///
    /// # Errors
    /// There is none that could be varied so, or a parameter has no meaning in it; or there are too many cases.
    pub fn of<'s>(
        entry: &Entry,
        scene: &'s Scene,
        thresholds: &'s Thresholds,
        asked: &[Vary],
    ) -> Result<(Self, EncounterFamily<'s>), String> {
        let family = EncounterFamily::of(
            scene,
            thresholds,
            INDEX_RADIUS,
            VariantOrigin::certified(entry, scene)?,
        )?;
        let name = visible(&entry.name);
        let mut axes: Vec<Axis> = Vec::new();
        for (place, vary) in asked.iter().enumerate() {
            let varied = vary.varied;
            if axes.iter().any(|axis| axis.varied == varied) {
                return Err(format!("{} is named twice", varied.name()));
            }
            axes.push(Axis {
                varied,
                recorded: family.base(varied)?,
                values: vary.values(&family, if place < 2 { ALONG } else { PANELS })?,
            });
        }
        if axes.len() > 3 {
            return Err("three parameters are the most".into());
        }
        let count: usize = axes.iter().map(|axis| axis.values.len()).product();
        if count > MOST {
            return Err(format!("{count} cases, at most {MOST}; take longer steps"));
        }
        let starts = axes.iter().filter(|axis| axis.varied == Varied::Start);
        let starts: Vec<f64> = starts.flat_map(|axis| axis.values.clone()).collect();
        let cases = Self {
            name: format!("{name}, {}", family.words()),
            axes,
        };
        Ok((cases, family.with_starts(&starts)))
    }

    /// The motion of the other road user for other programs, with these parameters.
    #[must_use]
    pub fn varied(&self, family: &EncounterFamily<'_>) -> VariedMotion {
        let ranges: Vec<_> = self.axes.iter().map(Axis::range).collect();
        family.varied(&ranges)
    }

    /// The axes in the order of parameters: what cases of a panel have in common first.
    fn in_order(&self) -> impl Iterator<Item = &Axis> {
        let (inside, common) = self.axes.split_at(self.axes.len().min(2));
        common.iter().chain(inside)
    }

    /// All of them: each with its parameters in that order, and the values of the family.
    fn grid(&self, family: &EncounterFamily<'_>) -> Vec<(Vec<f64>, Values)> {
        let mut grid = vec![(Vec::new(), family.recorded())];
        for axis in self.in_order() {
            let with = |(parameters, values): &(Vec<f64>, Values), value: f64| {
                let (mut parameters, mut values) = (parameters.clone(), *values);
                parameters.push(value);
                values[axis.varied as usize] = value;
                (parameters, values)
            };
            let each = |case| axis.values.iter().map(move |value| (case, *value));
            grid = { grid.iter() }
                .flat_map(each)
                .map(|(case, value)| with(case, value))
                .collect();
        }
        grid
    }

    /// The axes of the figure, with units.
    pub(super) fn axes(&self) -> [String; 2] {
        [0, 1].map(|place| self.axes.get(place).map(Axis::title).unwrap_or_default())
    }

    /// Whether a figure has both its axes.
    #[must_use]
    pub fn has_figure(&self) -> bool {
        self.axes.len() > 1
    }

    /// Where the recorded case lies on the axes of a panel; not in a panel whose third parameter is farther from the recorded
    /// one than from the next panel's.
    pub(super) fn recorded(&self, common: &[f64]) -> Option<(f64, f64)> {
        let [across, up, rest @ ..] = &self.axes[..] else {
            return None;
        };
        let is_here = { rest.iter().zip(common) }.all(|(axis, value)| {
            let half = axis.values.get(1).map_or(0.0, |next| next - axis.values[0]) / 2.0;
            (value - axis.recorded).abs() <= half
        });
        is_here.then_some((across.recorded, up.recorded))
    }

    /// What the cases of a panel have in common.
    pub(super) fn panel_name(&self, common: &[f64]) -> String {
        let third = self.axes.get(2).zip(common.first());
        let name = third.map(|(axis, value)| {
            let name = axis.varied.name().replace('_', " ");
            format!("{name} {} {}", short(*value), axis.varied.unit())
        });
        name.unwrap_or_default()
    }
}

impl From<&DriverVerdict> for Outcome {
    fn from(verdict: &DriverVerdict) -> Self {
        let result = &verdict.result;
        let contact = result.contact();
        Self {
            word: result.outcome().name(),
            closing_speed: contact.map(|touch| touch.closing_speed),
            avoids: result.decides().then_some(contact.is_none()),
        }
    }
}

impl FamilyResults {
    /// All drivers in all cases of an encounter.
    #[must_use]
    pub fn of_encounter(cases: EncounterCases, family: &EncounterFamily<'_>) -> Self {
        let driven = |(parameters, values): (Vec<f64>, Values)| {
            let outcomes = family.judge(&values).map(|found| {
                let by = |driver: &str| found.by(driver).map(Outcome::from);
                DRIVERS.iter().map(|driver| by(driver.id)).collect()
            });
            Driven {
                parameters,
                outcomes,
            }
        };
        let parameters = cases.in_order().map(|axis| {
            let varied = axis.varied;
            Column::new(varied.name(), Kind::Number, varied.unit(), varied.meaning())
        });
        Self {
            parameters: parameters.collect(),
            seats: DRIVERS.iter().map(Seat::of).collect(),
            cases: cases.grid(family).into_par_iter().map(driven).collect(),
            source: Source::Encounter(cases),
        }
    }

    /// The boundary for people, see [`FamilyResults::boundary`].
    pub(super) fn encounter_boundary(
        &self,
        cases: &EncounterCases,
    ) -> (Vec<Column>, Vec<Row>, String) {
        let ruled = self.ruled();
        let mut rows = Vec::new();
        for panel in self.panels() {
            for (row, up) in panel.up.iter().enumerate() {
                let common = panel.common.iter().chain(cases.has_figure().then_some(up));
                let limits = ruled.iter().map(|driver| {
                    let contact = |case: &Driven| case.avoids(*driver) == Some(false);
                    let undecided = |case: &Driven| case.is_undecided_by(*driver);
                    match (ranges(&panel, row, contact), ranges(&panel, row, undecided)) {
                        (contacts, none) if none == NONE => contacts,
                        (contacts, undecided) if contacts == NONE => format!("n/a {undecided}"),
                        (contacts, undecided) => format!("{contacts}; n/a {undecided}"),
                    }
                });
                let invalid = ranges(&panel, row, |case| case.outcomes.is_err());
                let common = common.map(|value| short(*value));
                let cells = common.chain(limits).chain([invalid]);
                rows.push(cells.map(Cell::from).collect());
            }
        }
        let column = |title: String, unit| Column {
            title: title.into(),
            ..Column::new("", Kind::Text, unit, "")
        };
        let unit = cases.axes.first().map_or("", |axis| axis.varied.unit());
        let above = cases.axes.iter().skip(1).rev();
        let columns = above
            .map(|axis| column(axis.varied.name().replace('_', " "), axis.varied.unit()))
            .chain(
                ruled
                    .iter()
                    .map(|driver| column(self.seats[*driver].id.clone(), unit)),
            )
            .chain([column("invalid".into(), unit)]);
        let recorded = cases.axes.iter().map(|axis| {
            let (name, unit) = (axis.varied.name(), axis.varied.unit());
            format!("{name} {} {unit}", short(axis.recorded))
        });
        let across = cases.axes.first().map_or("", |axis| axis.varied.name());
        let recorded: Vec<String> = recorded.collect();
        let sentence = format!(
            "{}: {}\nvalues of {across} at which a driver does not avoid contact; n/a: which it is not made for, or in \
             which it is hit from behind; invalid: which could not be driven; {} cases",
            cases.name,
            recorded.join(", "),
            self.cases.len()
        );
        (columns.collect(), rows, sentence)
    }
}

/// No value.
const NONE: &str = "-";

/// The values across at which this holds in a row of a panel: `2..6, 9`; [`NONE`] where there are none.
fn ranges(panel: &Panel<'_>, row: usize, holds: impl Fn(&Driven) -> bool) -> String {
    let at = |column: usize| holds(&panel.cases[column * panel.up.len() + row]);
    let columns: Vec<usize> = (0..panel.across.len()).collect();
    let runs = columns
        .chunk_by(|a, b| at(*a) == at(*b))
        .filter(|run| at(run[0]));
    let words = runs.map(|run| {
        let [first, last] = [run[0], run[run.len() - 1]].map(|column| short(panel.across[column]));
        if run.len() == 1 {
            first
        } else {
            format!("{first}..{last}")
        }
    });
    let words: Vec<String> = words.collect();
    if words.is_empty() {
        NONE.into()
    } else {
        words.join(", ")
    }
}
