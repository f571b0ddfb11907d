//! Reading an experiment file: every value with the line it stands in, and every mistake.

use std::collections::BTreeMap;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::keys::{KEYS, Values};
use nearmiss_base::system::{TomlText, shown_value, unknown};
use nearmiss_study::evaluation::Lead;
use nearmiss_study::evaluation::report::{Axis, Measure, PivotRequest};

/// Values of one key, at most: more are no choice of a person.
const MOST_MEMBERS: usize = 10_000;

/// The text of an experiment file, and what is wrong with it.
pub(super) struct Reading<'a> {
    toml: TomlText<'a>,
    table: DeTable<'a>,
}

impl<'a> Reading<'a> {
    /// Reads the keys; unknown ones are noted as mistakes.
    pub fn new(text: &'a str) -> Self {
        let mut toml = TomlText::new(text);
        let table = toml.table().unwrap_or_default();
        for key in table.keys() {
            let name = key.get_ref().as_ref();
            if KEYS.iter().all(|known| known.name != name) {
                let known = KEYS.iter().map(|known| known.name);
                toml.mistake(&key.span(), unknown("key", name, known));
            }
        }
        Self { toml, table }
    }

    /// A text.
    pub fn text(&mut self, key: &'static str) -> Option<String> {
        self.value(key, |value| value.as_str().map(Into::into))
    }

    /// A whole number in the bounds of its key.
    pub fn whole(&mut self, key: &'static str) -> Option<u32> {
        let Values::Whole(least, most) = values(key) else {
            return None;
        };
        self.value(key, |value| {
            let number: i64 = value.as_integer()?.as_str().parse().ok()?;
            let within = (least..=most).contains(&number);
            within.then(|| u32::try_from(number).ok()).flatten()
        })
    }

    /// A number in the bounds of its key.
    pub fn number(&mut self, key: &'static str) -> Option<f64> {
        let Values::Number(least, most) = values(key) else {
            return None;
        };
        self.value(key, |value| {
            number(value).filter(|number| (least..=most).contains(number))
        })
    }

    /// A number in the bounds of its key, or several.
    pub fn numbers(&mut self, key: &'static str) -> Vec<f64> {
        let Values::OneOrMoreNumbers(least, most) = values(key) else {
            return Vec::new();
        };
        self.each(key, |value| {
            let within = number(value).filter(|number| (least..=most).contains(number));
            within.map(Ok)
        })
    }

    /// A whole number in the bounds of its key, or several.
    pub fn wholes(&mut self, key: &'static str) -> Vec<u64> {
        let Values::OneOrMoreWhole(least, most) = values(key) else {
            return Vec::new();
        };
        self.each(key, |value| {
            let number = whole(value).filter(|number| (least..=most).contains(number));
            number.and_then(|number| u64::try_from(number).ok()).map(Ok)
        })
    }

    /// A split: its share, and its seed if it has one.
    pub fn split(&mut self, key: &'static str) -> Option<(f64, Option<u64>)> {
        self.value(key, |value| {
            let table = value.as_table()?;
            let known = |name: &str| matches!(name, "test" | "seed");
            if !table.keys().all(|name| known(name.get_ref())) {
                return None;
            }
            let share = table.get("test").and_then(|share| number(share.get_ref()));
            let share = share.filter(|share| *share > 0.0 && *share < 1.0)?;
            let seed = match table.get("seed") {
                None => None,
                Some(seed) => Some(u64::try_from(whole(seed.get_ref())?).ok()?),
            };
            Some((share, seed))
        })
    }

    /// A table: each name with its texts.
    pub fn texts_by_name(&mut self, key: &'static str) -> BTreeMap<String, Vec<String>> {
        let texts = |value: &DeValue<'_>| match value.as_array() {
            None => value.as_str().map(|text| vec![text.to_string()]),
            Some(all) => all
                .iter()
                .map(|one| one.get_ref().as_str().map(str::to_string))
                .collect(),
        };
        let found = self.value(key, |value| {
            let entries = value.as_table()?.iter();
            entries
                .map(|(name, value)| Some((name.get_ref().to_string(), texts(value.get_ref())?)))
                .collect()
        });
        found.unwrap_or_default()
    }

    /// True or false.
    pub fn boolean(&mut self, key: &'static str) -> Option<bool> {
        self.value(key, |value| value.as_bool())
    }

    /// Truth values, one or several.
    pub fn booleans(&mut self, key: &'static str) -> Vec<bool> {
        self.each(key, |value| value.as_bool().map(Ok))
    }

    /// A list of texts, each as `parse` reads it.
    pub fn list<T>(
        &mut self,
        key: &'static str,
        parse: impl Fn(&str) -> Result<T, String>,
    ) -> Vec<T> {
        self.each(key, |value| value.as_str().map(&parse))
    }

    /// Leads: seconds, or `end`.
    pub fn leads(&mut self, key: &'static str) -> Vec<Lead> {
        self.each(key, |value| {
            let word = value
                .as_str()
                .map(str::to_string)
                .or_else(|| number(value).map(|seconds| seconds.to_string()))?;
            Some(word.parse())
        })
    }

    /// Tables over axes.
    pub fn tables(&mut self, key: &'static str) -> Vec<PivotRequest> {
        self.each(key, |value| {
            let table = value.as_table()?;
            let known = ["rows", "columns", "measure", "against"];
            if let Some(other) = table
                .keys()
                .find(|name| !known.contains(&name.get_ref().as_ref()))
            {
                return Some(Err(unknown("key", other.get_ref(), known)));
            }
            let text = |name: &str| match table.get(name) {
                None => Some(None),
                Some(value) => value.get_ref().as_str().map(Some),
            };
            let (rows, columns) = (text("rows")??, text("columns")?);
            let (measure, against) = (text("measure")?, text("against")?);
            let read = || {
                let request = PivotRequest {
                    rows: Axis::parse(rows)?,
                    columns: columns.map(Axis::parse).transpose()?,
                    measure: measure.map(Measure::parse).transpose()?.unwrap_or_default(),
                    against: against.map(str::to_string),
                };
                let checked = request.check();
                checked.map_err(|(part, words)| format!("{part}: {words}"))?;
                Ok(request)
            };
            Some(read())
        })
    }

    /// Two different names.
    pub fn pair(&mut self, key: &'static str) -> Option<(String, String)> {
        self.value(key, |value| match value.as_array()?.iter().as_slice() {
            [a, b] => {
                let (a, b) = (a.get_ref().as_str()?, b.get_ref().as_str()?);
                (a != b).then(|| (a.to_string(), b.to_string()))
            }
            _ => None,
        })
    }

    /// Notes that a key is needed.
    pub fn needed(&mut self, key: &str, what: &str) {
        if !self.table.contains_key(key) {
            self.toml
                .mistake(&(0..0), format!("{key} is missing: {what}"));
        }
    }

    /// Notes a mistake in a key's value.
    pub fn mistake(&mut self, key: &str, words: &str) {
        let span = self.table.get(key).map_or(0..0, Spanned::span);
        self.toml.mistake(&span, format!("{key}: {words}"));
    }

    /// Whether nothing is wrong.
    ///
    /// # Errors
    /// Every mistake on a line of its own, with file and line.
    pub fn checked(self, file: &str) -> Result<(), String> {
        self.toml
            .checked(file)
            .map_err(|mistakes| mistakes.join("\n"))
    }

    fn value<T>(
        &mut self,
        key: &'static str,
        read: impl Fn(&DeValue<'_>) -> Option<T>,
    ) -> Option<T> {
        let value = self.table.get(key)?;
        let found = read(value.get_ref());
        if found.is_none() {
            let shown = shown_value(value.get_ref());
            let words = format!("{key} = {shown}: {}", values(key).expected());
            self.toml.mistake(&value.span(), words);
        }
        found
    }

    /// The members of a list; `read` finds nothing in a value of the wrong kind.
    fn each<T>(
        &mut self,
        key: &'static str,
        read: impl Fn(&DeValue<'_>) -> Option<Result<T, String>>,
    ) -> Vec<T> {
        let Some(value) = self.table.get(key) else {
            return Vec::new();
        };
        let is_single = values(key).takes_one() && value.get_ref().as_array().is_none();
        let single = std::slice::from_ref(value);
        let members = value.get_ref().as_array();
        let members = members.map(|members| members.iter().as_slice());
        let Some(members) = members.or(is_single.then_some(single)) else {
            let shown = shown_value(value.get_ref());
            let words = format!("{key} = {shown}: {}", values(key).expected());
            self.toml.mistake(&value.span(), words);
            return Vec::new();
        };
        // Scenarios may be named one by one.
        if members.len() > MOST_MEMBERS && key != "scenarios" {
            let words = format!("{key}: {} values, at most {MOST_MEMBERS}", members.len());
            self.toml.mistake(&value.span(), words);
            return Vec::new();
        }
        let mut found = Vec::new();
        for member in members.iter() {
            match read(member.get_ref()) {
                Some(Ok(one)) => found.push(one),
                Some(Err(why)) => self.toml.mistake(&member.span(), format!("{key}: {why}")),
                None => {
                    let shown = shown_value(member.get_ref());
                    let sign = if is_single { " =" } else { ":" };
                    let words = format!("{key}{sign} {shown}: {}", values(key).expected());
                    self.toml.mistake(&member.span(), words);
                }
            }
        }
        found
    }
}

/// The values that a key takes.
fn values(name: &str) -> Values {
    let known = KEYS.iter().find(|key| key.name == name);
    known.map_or(Values::Text, |key| key.values)
}

fn whole(value: &DeValue<'_>) -> Option<i64> {
    value.as_integer()?.as_str().parse().ok()
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    let whole = value.as_integer().map(|whole| whole.as_str());
    let digits = whole.or_else(|| Some(value.as_float()?.as_str()))?;
    digits.parse().ok()
}
