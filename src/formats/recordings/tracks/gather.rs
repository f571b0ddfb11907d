//! Rows of a table as they are gathered, column by column: which track each is of, and which are taken.

use std::collections::{BTreeMap, HashMap};

use super::batch::{Batch, Values};
use super::columns::Role;
use super::text::BadCell;

/// No table has more rows.
const MOST_ROWS: usize = 20_000_000;

/// Rows as they are read, column by column.
#[derive(Debug, Default)]
pub struct Rows {
    /// Of the roles that the table has, without texts.
    pub(super) numbers: BTreeMap<Role, Vec<f64>>,
    /// The place of each row's track.
    pub(super) track: Vec<u32>,
    pub(super) lines: Vec<u32>,
    pub(super) tracks: Vec<Named>,
    pub(super) places: HashMap<(String, String), u32>,
    /// Numbers with a decimal comma.
    pub(super) commas: usize,
    /// Lines that are the header once more.
    pub(super) headers: usize,
    /// Values of keys that no column has.
    pub(super) unknown: usize,
    /// Rows without a time, place or name, and the first one's line.
    pub(super) incomplete: (usize, u32),
    /// Which rows are taken; else all.
    pub(super) only: Option<Slice>,
    /// Who is in a table that has no column for it.
    pub(super) whose: String,
}

/// Some rows of a table.
#[derive(Debug, Clone)]
pub struct Slice {
    /// The column of times, and from when to when, in its unit.
    pub clock: Role,
    /// Both included.
    pub times: (f64, f64),
    /// The name of their scenario; else of any.
    pub scenario: Option<String>,
}

impl Rows {
    /// None yet, and none but those of `slice`.
    pub fn only(slice: Slice) -> Self {
        Self {
            only: Some(slice),
            ..Self::default()
        }
    }
}

/// A track as the table names it.
#[derive(Debug, Default, Clone)]
pub(super) struct Named {
    pub(super) name: String,
    pub(super) scenario: String,
    pub(super) class: String,
    pub(super) is_ego: bool,
}

/// Parts the name of a predicted trajectory into the road user and the mode.
pub(super) const MODE: &str = ", mode ";

/// What names of an ego are.
const EGO: [&str; 7] = ["ego", "av", "sdc", "self", "host", "hero", "ego_vehicle"];

impl Rows {
    /// Adds those of a batch; `roles` are those of its columns.
    ///
    /// # Errors
    /// There are too many.
    pub fn add(&mut self, roles: &[Role], mut batch: Batch) -> Result<(), BadCell> {
        batch.join_times(roles);
        self.commas += batch.commas;
        self.headers += batch.headers;
        self.unknown += batch.unknown;
        // Also those that are left out: they take as long.
        let count = self.lines.len() + self.incomplete.0;
        if count + batch.lines.len() > MOST_ROWS {
            return Err(BadCell {
                line: count,
                column: String::new(),
                message: format!("more than {MOST_ROWS} rows; split the table"),
            });
        }
        let texts = |role: Role| {
            let place = roles.iter().position(|r| *r == role)?;
            match &batch.values[place] {
                Values::Texts(places, texts) => Some((places, &texts.texts)),
                Values::Numbers(_) => None,
            }
        };
        let text = |of: Option<(&Vec<u32>, &Vec<String>)>, row: usize| -> String {
            of.map_or_else(String::new, |(places, texts)| {
                texts[places[row] as usize].clone()
            })
        };
        let numbers: Vec<(Role, &Vec<f64>)> = roles
            .iter()
            .zip(&batch.values)
            .filter_map(|(role, values)| match values {
                Values::Numbers(numbers) => Some((*role, numbers)),
                Values::Texts(..) => None,
            })
            .collect();
        let needed: Vec<&Vec<f64>> = numbers
            .iter()
            .filter(|(role, _)| NEEDED.contains(role))
            .map(|(_, numbers)| *numbers)
            .collect();
        let (ids, scenarios) = (texts(Role::Id), texts(Role::Scenario));
        let (classes, egos, modes) = (texts(Role::Class), texts(Role::Ego), texts(Role::Mode));
        let only = self.only.clone();
        let is_wanted = |row: usize| -> bool {
            let Some(only) = &only else {
                return true;
            };
            let clock = numbers.iter().find(|(role, _)| *role == only.clock);
            let time = clock.map_or(only.times.0, |(_, values)| values[row]);
            let is_of = |name: &String| plain_number(text(scenarios, row)) == *name;
            // A row without a time is told as such.
            !(time < only.times.0 || time > only.times.1)
                && only.scenario.as_ref().is_none_or(is_of)
        };
        let before = self.track.len();
        // Names of this batch are those of tracks that are known by number.
        let mut known: HashMap<[u32; 3], u32> = HashMap::new();
        let mut kept = Vec::with_capacity(batch.lines.len());
        for (row, line) in batch.lines.iter().enumerate() {
            if !is_wanted(row) {
                continue;
            }
            let id = ids.map_or(0, |(places, _)| places[row]);
            let is_named = ids.is_none_or(|(_, texts)| !texts[id as usize].is_empty());
            if !is_named || needed.iter().any(|values| values[row].is_nan()) {
                self.incomplete.0 += 1;
                if self.incomplete.1 == 0 {
                    self.incomplete.1 = *line;
                }
                continue;
            }
            let scenario = scenarios.map_or(0, |(places, _)| places[row]);
            let mode = modes.map_or(0, |(places, _)| places[row]);
            let track = match known.get(&[id, scenario, mode]) {
                Some(track) => *track,
                None => {
                    let name = match ids {
                        Some(_) => plain_number(text(ids, row)),
                        None => self.whose.clone(),
                    };
                    let named = Named {
                        name: match modes {
                            Some(_) => format!("{name}{MODE}{}", text(modes, row)),
                            None => name,
                        },
                        scenario: plain_number(text(scenarios, row)),
                        class: text(classes, row),
                        is_ego: false,
                    };
                    let track = self.track_of(named);
                    known.insert([id, scenario, mode], track);
                    track
                }
            };
            if egos.is_some() && is_yes(&text(egos, row)) {
                self.tracks[track as usize].is_ego = true;
            }
            kept.push(row);
            self.track.push(track);
            self.lines.push(*line);
        }
        for (role, values) in numbers {
            let all = self.numbers.entry(role).or_default();
            // Another table of the recording may lack columns.
            all.resize(before, f64::NAN);
            if kept.len() == values.len() {
                all.extend(values);
            } else {
                all.extend(kept.iter().map(|row| values[*row]));
            }
        }
        let count = self.track.len();
        self.numbers
            .values_mut()
            .for_each(|all| all.resize(count, f64::NAN));
        Ok(())
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.lines.len()
    }

    /// The first value of each track in a column.
    pub fn firsts(&self, role: Role) -> Vec<Option<f64>> {
        let mut found = vec![None; self.tracks.len()];
        let values = self.numbers.get(&role).map_or(&[][..], Vec::as_slice);
        for (track, value) in self.track.iter().zip(values) {
            let first = &mut found[*track as usize];
            *first = first.or(Some(*value).filter(|value| value.is_finite()));
        }
        found
    }

    fn track_of(&mut self, named: Named) -> u32 {
        let key = (named.scenario.clone(), named.name.clone());
        let next = u32::try_from(self.tracks.len()).unwrap_or(u32::MAX);
        let place = *self.places.entry(key).or_insert(next);
        if place == next {
            let is_ego = EGO.contains(&named.name.to_lowercase().as_str())
                || EGO.contains(&named.class.to_lowercase().as_str());
            self.tracks.push(Named { is_ego, ..named });
        }
        place
    }
}

/// Without these a row says nothing.
const NEEDED: [Role; 6] = [
    Role::Time,
    Role::Frame,
    Role::X,
    Role::Y,
    Role::Latitude,
    Role::Longitude,
];

/// A whole number that was written as `12.0`, as pandas does where a column has gaps, or as `1.2e+01`, as NumPy does.
pub fn plain_number(text: String) -> String {
    match text.parse::<f64>() {
        Ok(value) if text.contains('.') && value.fract() == 0.0 && value.abs() < 1e15 => {
            (value as i64).to_string()
        }
        _ => text,
    }
}

fn is_yes(text: &str) -> bool {
    let lower = text.to_lowercase();
    let is_one = lower.parse::<f64>().is_ok_and(|value| value == 1.0);
    is_one || matches!(lower.as_str(), "true" | "yes" | "y") || EGO.contains(&lower.as_str())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn rows_that_are_left_out_are_counted_and_bounded() {
        let row = |id: &str| {
            let of = |name: &str, is_text| super::super::Wanted {
                name: name.into(),
                is_text,
            };
            let mut batch = Batch::new(&[of("id", true), of("time", false)]);
            batch.push(0, id, b',').unwrap();
            batch.push(1, "0.1", b',').unwrap();
            batch.lines.push(7);
            batch
        };
        let roles = [Role::Id, Role::Time];
        let mut rows = Rows::default();
        for id in ["", "a", ""] {
            rows.add(&roles, row(id)).unwrap();
        }
        assert_eq!((rows.count(), rows.incomplete), (1, (2, 7)));
        rows.incomplete.0 = MOST_ROWS - 1;
        let full = rows.add(&roles, row("")).unwrap_err().message;
        assert!(full.contains("more than"), "{full}");
    }
}
