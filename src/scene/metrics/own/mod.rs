//! Measures of the user's own: formulas over measures and states, read from the configuration and then known everywhere.

mod formula;
mod parse;
mod tokens;
mod unit;

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use nearmiss_base::system::available;

use super::measure::Compute;
use super::{Danger, MEASURES, Measure, Mirrored, SCENE_MEASURES, Threshold};
use formula::{Number, Operand};
use unit::Unit;

pub use formula::{Formula, STATES};

/// A measure as the user writes it.
#[derive(Debug, Clone)]
pub struct OwnMeasure<'t> {
    /// Its id.
    pub id: &'t str,
    /// Its formula.
    pub formula: &'t str,
    /// Its name; else the id in words.
    pub name: Option<&'t str>,
    /// The unit that its values must have.
    pub unit: Option<&'t str>,
    /// Which values are dangerous.
    pub danger: Danger,
    /// The critical value.
    pub threshold: Option<f64>,
}

/// What is wrong with a measure of the user's.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OwnMistake {
    /// Its id.
    pub id: String,
    /// The key that is wrong; none where it is the id.
    pub key: Option<&'static str>,
    /// What is wrong, where in the formula, and what to do.
    pub words: String,
}

/// Measures of the user's that were checked.
#[derive(Debug, Default)]
pub struct OwnMeasures {
    all: Vec<Checked>,
}

#[derive(Debug)]
struct Checked {
    id: String,
    name: String,
    unit: Unit,
    danger: Danger,
    threshold: Option<f64>,
    formula: Arc<Formula>,
}

/// Those that are in use.
static OWN: OnceLock<Registered> = OnceLock::new();

#[derive(Debug)]
struct Registered {
    measures: &'static [Measure],
    thresholds: Vec<Threshold>,
}

/// Every measure in the order of columns: the shipped ones, then those of the user.
pub fn measures() -> impl Iterator<Item = &'static Measure> + Clone {
    let own = OWN.get().map_or(&[][..], |own| own.measures);
    MEASURES.iter().chain(own)
}

/// The critical values of the user's measures.
pub(super) fn own_thresholds() -> impl Iterator<Item = &'static Threshold> {
    OWN.get().into_iter().flat_map(|own| &own.thresholds)
}

/// The user's measures as `id = formula`: what runs that are continued must have in common.
#[must_use]
pub fn own_formulas() -> Vec<String> {
    let own = measures().filter_map(|m| Some(format!("{} = {}", m.id, m.formula()?)));
    own.collect()
}

/// The file that the sources of measures and thresholds name.
const FILE: &str = "config.toml";

/// Most measures of the user's: their columns are in every table.
const MOST: usize = 32;

/// Words that are columns of tables, terms of filters or orders of lists, or stand for something in formulas.
const TAKEN: [&str; 30] = [
    "all",
    "answers",
    "duration",
    "obstacles",
    "severity",
    "name",
    "found",
    "verdicts",
    "scenario",
    "file",
    "hash",
    "ego",
    "step",
    "time",
    "obstacle",
    "relative_direction",
    "provenance",
    "sha256",
    "ego_source",
    "ego_id",
    "obstacle_id",
    "obstacle_type",
    "first_step",
    "last_step",
    "start",
    "end",
    "manoeuvre",
    "road",
    "severity_name",
    "worst_step",
];

/// The end of columns that say why there is no value.
const REASON: &str = "_reason";

impl OwnMeasures {
    /// Checks measures. They may use each other, in any order.
    ///
    /// # Errors
    /// Everything that is wrong with ids, formulas, units and thresholds.
    pub fn new(said: &[OwnMeasure<'_>]) -> Result<Self, Vec<OwnMistake>> {
        let mut checker = Checker {
            said: said.iter().map(|one| (one.id, one)).collect(),
            slots: BTreeMap::new(),
            mistakes: Vec::new(),
        };
        if let Some(first) = said.get(MOST) {
            checker.wrong(
                first.id,
                None,
                format!("more than {MOST} measures; remove some"),
            );
        }
        let some = said.iter().take(MOST);
        let all: Vec<Checked> = some.filter_map(|one| checker.checked(one)).collect();
        if checker.mistakes.is_empty() {
            Ok(Self { all })
        } else {
            Err(checker.mistakes)
        }
    }

    /// Puts them in use for the rest of the program's run. Only the first call counts, and it must come before thresholds
    /// are read.
    pub fn register(self) {
        OWN.get_or_init(|| Registered {
            thresholds: { self.all.iter() }.filter_map(Checked::threshold).collect(),
            measures: self
                .all
                .into_iter()
                .map(Checked::measure)
                .collect::<Vec<_>>()
                .leak(),
        });
    }
}

impl Checked {
    fn threshold(&self) -> Option<Threshold> {
        Some(Threshold {
            measure: self.id.clone(),
            value: self.threshold?,
            name: "critical".into(),
            source: FILE.into(),
            strict: false,
            own: false,
        })
    }

    /// The measure; it lives as long as the program.
    fn measure(self) -> Measure {
        let formula: &'static Arc<Formula> = Box::leak(Box::new(self.formula));
        // Of one that is an operand alone the sign turns as that of the operand.
        let mirrored = match &formula.root {
            Number::Of(Operand::Measure(measure)) => measure.mirrored,
            _ => Mirrored::Kept,
        };
        Measure {
            id: self.id.leak(),
            name: self.name.leak(),
            unit: self.unit.to_string().leak(),
            danger: self.danger,
            mirrored,
            reads_ahead: formula.facts.reads_ahead,
            source: format!("{FILE}: {}", formula.text).leak(),
            compute: Compute::Formula(formula),
        }
    }
}

/// What is known of the formula of an id.
enum Slot {
    /// It is being read: the formula that asks is part of it.
    Open,
    Read(Arc<Formula>),
    Wrong,
}

struct Checker<'t> {
    said: BTreeMap<&'t str, &'t OwnMeasure<'t>>,
    slots: BTreeMap<&'t str, Slot>,
    mistakes: Vec<OwnMistake>,
}

impl<'t> Checker<'t> {
    fn wrong(&mut self, id: &str, key: Option<&'static str>, words: String) {
        self.mistakes.push(OwnMistake {
            id: id.into(),
            key,
            words,
        });
    }

    fn checked(&mut self, said: &'t OwnMeasure<'t>) -> Option<Checked> {
        if let Err(words) = check_id(said.id) {
            self.wrong(said.id, None, words);
        }
        if said.threshold.is_some() && said.danger == Danger::Neutral {
            let words =
                "no value is dangerous; set danger to \"low\" or \"high\", or remove the threshold";
            self.wrong(said.id, Some("threshold"), words.into());
        }
        let formula = self.formula(said)?;
        let wanted = said.unit.map(|unit| (unit, Unit::parse(unit)));
        let unit = match (wanted, formula.unit) {
            (Some((text, None)), _) => {
                let words = format!(
                    "unknown unit `{}`; units are made of m, s and rad, such as m/s²",
                    text.escape_debug()
                );
                self.wrong(said.id, Some("unit"), words);
                return None;
            }
            (Some((_, Some(wanted))), Some(found)) if wanted != found => {
                let words = format!(
                    "the formula gives {}, not {}; correct one of the two",
                    found.words(),
                    wanted.words()
                );
                self.wrong(said.id, Some("unit"), words);
                return None;
            }
            (Some((_, wanted)), found) => found.or(wanted).unwrap_or_default(),
            (None, found) => found.unwrap_or_default(),
        };
        Some(Checked {
            id: said.id.into(),
            name: said
                .name
                .map_or_else(|| said.id.replace('_', " "), str::to_string),
            unit,
            danger: said.danger,
            threshold: said.threshold,
            formula,
        })
    }

    /// Its formula, read once.
    fn formula(&mut self, said: &'t OwnMeasure<'t>) -> Option<Arc<Formula>> {
        match self.slots.get(said.id) {
            Some(Slot::Read(formula)) => return Some(formula.clone()),
            Some(Slot::Open | Slot::Wrong) => return None,
            None => {}
        }
        self.slots.insert(said.id, Slot::Open);
        let read = parse::parse(said.formula, &mut |name| self.operand(name));
        let (slot, formula) = match read {
            Ok(formula) => {
                let formula = Arc::new(formula);
                (Slot::Read(formula.clone()), Some(formula))
            }
            Err(error) => {
                let words = placed(said.formula, &error);
                self.wrong(said.id, Some("formula"), words);
                (Slot::Wrong, None)
            }
        };
        self.slots.insert(said.id, slot);
        formula
    }

    /// What a name in a formula stands for.
    fn operand(&mut self, name: &str) -> Result<Operand, String> {
        if let Some(state) = STATES.iter().find(|state| state.names.contains(&name)) {
            return Ok(Operand::State(state));
        }
        if let Some(measure) = MEASURES.iter().find(|measure| measure.id == name) {
            return Ok(Operand::Measure(measure));
        }
        if let Some((id, said)) = self.said.get_key_value(name).map(|(id, said)| (*id, *said)) {
            return match (self.formula(said), self.slots.get(id)) {
                (Some(formula), _) => Ok(Operand::Own(formula)),
                (None, Some(Slot::Open)) => Err(format!(
                    "`{name}` is part of itself; a measure needs others"
                )),
                (None, _) => Err(format!(
                    "`{name}` has a mistake of its own; correct it first"
                )),
            };
        }
        let states = STATES.iter().flat_map(|state| state.names).copied();
        let known = MEASURES.iter().map(|measure| measure.id).chain(states);
        let known = known
            .chain(self.said.keys().copied())
            .chain(parse::FUNCTIONS);
        Err(format!("unknown name `{name}`{}", available(name, known)))
    }
}

/// A mistake with its column, the place in the formula in brackets, which no formula has.
fn placed(formula: &str, error: &tokens::FormulaError) -> String {
    let (before, rest) = formula.split_at(error.at.start);
    let (place, after) = rest.split_at(error.at.len());
    let column = before.chars().count() + 1;
    format!(
        "column {column}, `{before}[{place}]{after}`: {}",
        error.words
    )
    .replace(['\n', '\r', '\t'], " ")
}

/// Longest id: it heads columns.
const LONGEST_ID: usize = 24;

fn check_id(id: &str) -> Result<(), String> {
    let is_plain = id.starts_with(|c: char| c.is_ascii_lowercase())
        && id
            .chars()
            .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
    if !is_plain || id.len() > LONGEST_ID {
        return Err(format!(
            "the id must begin with a to z and have a to z, 0 to 9 and _ alone, at most {LONGEST_ID}"
        ));
    }
    let is_taken = MEASURES.iter().any(|m| m.id == id)
        || SCENE_MEASURES.iter().any(|m| m.id == id)
        || STATES.iter().any(|state| state.names.contains(&id))
        || parse::FUNCTIONS.contains(&id)
        || TAKEN.contains(&id)
        || Unit::parse(id).is_some()
        || id.ends_with(REASON);
    if is_taken {
        return Err("the id is taken; choose another one".into());
    }
    Ok(())
}

#[cfg(test)]
mod tests;
