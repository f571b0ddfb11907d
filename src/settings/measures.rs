//! `[measure.ID]` of `config.toml`: measures of the user's own, as formulas.

use std::path::Path;

use nearmiss_base::system::{KeyLines, Mistake};
use nearmiss_record::fields::Fields;
use nearmiss_scene::metrics::{Danger, OwnMeasure, OwnMeasures, OwnMistake};
use toml::{Table, Value};

use super::config::wrong;
use super::folders::text_if_there;
use super::{Config, ConfigError};

nearmiss_record::fields! {
    /// A measure of the user's own.
    pub struct MeasureTable {
        "measure" {
            /// Formula over measures and states: `ttc < 2 ? 1 : distance / speed`.
            formula [required]: String;
            /// Name [default: the id in words].
            name: Option<String>;
            /// Unit, to check the formula against [default: that of the formula].
            unit: Option<String>;
            /// Dangerous direction [default: none].
            danger: Option<String>, Takes::OneOf(&["low", "high", "none"]);
            /// Critical value [default: none].
            threshold: Option<f64>;
        }
    }
}

impl MeasureTable {
    fn measure<'t>(&'t self, id: &'t str) -> OwnMeasure<'t> {
        OwnMeasure {
            id,
            formula: &self.formula,
            name: self.name.as_deref(),
            unit: self.unit.as_deref(),
            danger: match self.danger.as_deref() {
                Some("low") => Danger::Low,
                Some("high") => Danger::High,
                _ => Danger::Neutral,
            },
            threshold: self.threshold,
        }
    }
}

impl Config {
    /// The measures of a configuration file, whatever else is wrong with it; none where it is not there or no TOML.
    ///
    /// # Errors
    /// Everything that is wrong with them.
    pub fn measures(file: &Path) -> Result<OwnMeasures, ConfigError> {
        let text = text_if_there(file).ok().flatten().unwrap_or_default();
        let table: Table = toml::from_str(&text).unwrap_or_default();
        let Some(section) = table.get("measure").and_then(Value::as_table) else {
            return Ok(OwnMeasures::default());
        };
        read(section).map_err(|found| {
            let lines = KeyLines::new(&text);
            let mistake = |(path, words): (Vec<String>, String)| {
                let path = std::iter::once("measure").chain(path.iter().map(String::as_str));
                let line = lines.line(&path.collect::<Vec<_>>());
                Mistake { line, words }
            };
            ConfigError {
                file: file.display().to_string(),
                mistakes: found.into_iter().map(mistake).collect(),
            }
        })
    }
}

/// What is wrong with the section, as other sections say it.
pub(super) fn mistakes(section: &Table) -> Vec<(Vec<String>, String)> {
    read(section).err().unwrap_or_default()
}

/// The measures; or the names that lead to each mistake, and a message.
fn read(section: &Table) -> Result<OwnMeasures, Vec<(Vec<String>, String)>> {
    let mut found = Vec::new();
    let mut tables = Vec::new();
    for (id, value) in section {
        let Value::Table(table) = value else {
            let message = format!("measure.{id}: expected a table, [measure.{id}]");
            found.push((vec![id.clone()], message));
            continue;
        };
        if !table.contains_key("formula") {
            let message = format!("measure.{id}: formula is missing");
            found.push((vec![id.clone()], message));
        }
        for (key, value) in table {
            let message = wrong::<MeasureTable>(&format!("measure.{id}."), key, value);
            found.extend(message.map(|message| (vec![id.clone(), key.clone()], message)));
        }
        if let Ok(table) = MeasureTable::from_table(table) {
            tables.push((id, table));
        }
    }
    if !found.is_empty() {
        return Err(found);
    }
    let said = tables.iter().map(|(id, table)| table.measure(id));
    let said: Vec<OwnMeasure<'_>> = said.collect();
    OwnMeasures::new(&said).map_err(|mistakes| {
        let mistake = |one: OwnMistake| {
            let path = std::iter::once(one.id).chain(one.key.map(str::to_string));
            let path: Vec<String> = path.collect();
            let message = format!("measure.{}: {}", path.join("."), one.words);
            (path, message)
        };
        mistakes.into_iter().map(mistake).collect()
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn said(text: &str) -> Vec<String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("config.toml");
        std::fs::write(&file, text).unwrap();
        let error = Config::measures(&file).unwrap_err();
        // The whole file says the same.
        let whole = Config::read(&file).unwrap_err();
        let words = |error: &ConfigError| {
            let each = error.mistakes.iter();
            each.map(|m| format!("{}: {}", m.line.unwrap_or_default(), m.words))
                .collect::<Vec<_>>()
        };
        assert!(words(&error).iter().all(|one| words(&whole).contains(one)));
        words(&error)
    }

    #[test]
    fn mistakes_have_line_key_and_column() {
        let text = "mouse = true\n[measure.mine]\nformula = \"ttc + distance\"\n[measure.ttc]\nformula = \"1\"\n";
        let found = said(text);
        assert!(
            found[0].starts_with(
                "3: measure.mine.formula: column 1, `[ttc + distance]`: a sum needs one unit"
            ),
            "{found:?}"
        );
        assert_eq!(
            found[1],
            "4: measure.ttc: the id is taken; choose another one"
        );
        let found = said("[measure]\na = 1\n[measure.b]\nformla = \"1\"\ndanger = \"much\"\n");
        for (found, start) in found.iter().zip([
            "2: measure.a: expected a table, [measure.a]",
            "3: measure.b: formula is missing",
            "5: measure.b.danger",
            "4: unknown key `measure.b.formla`; did you mean `formula`?",
        ]) {
            assert!(found.starts_with(start), "{found}");
        }
    }

    #[test]
    fn what_else_is_wrong_keeps_no_measure_away() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("config.toml");
        assert!(Config::measures(&file).is_ok());
        let text = "mouse = 3\n[measure.mine]\nformula = \"ttc\"\nunit = \"s\"\ndanger = \"low\"\nthreshold = 2\n";
        std::fs::write(&file, text).unwrap();
        assert!(Config::read(&file).is_err());
        assert!(Config::measures(&file).is_ok());
    }
}
