//! `plan --table FILE`: one row a drive, as CSV, JSON lines or Parquet.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;

use crate::many_files::FinishedFiles;
use crate::output::{
    self, Cell, Column, ForSpreadsheet, Format, Kind, Row, Table, TableWriter, Target,
};
use crate::{Failure, Outcome};
use nearmiss_scene::traffic_rules::Rule;

/// What the endings of names ask for.
const ENDINGS: &[(&str, Format)] = &[
    ("csv", Format::Csv),
    ("json", Format::Json),
    ("jsonl", Format::Json),
    ("parquet", Format::Parquet),
];

/// The columns, and where their values are in what `plan --format json` prints; lists are joined by spaces, lines of standard
/// error by line breaks. Behind them each rule has a column with what became of it.
const COLUMNS: [(&str, &str, Kind, &str); 42] = [
    ("scenario", "/scenario", Kind::Text, ""),
    ("file", "/file", Kind::Text, ""),
    ("hash", "/hash", Kind::Text, ""),
    ("planner", "/planner", Kind::Text, ""),
    ("planner_name", "/external_planner/name", Kind::Text, ""),
    (
        "planner_version",
        "/external_planner/version",
        Kind::Text,
        "",
    ),
    ("planning_problem", "/planning_problem", Kind::Integer, ""),
    ("prediction", "/prediction", Kind::Text, ""),
    ("traffic", "/traffic", Kind::Text, ""),
    ("vehicle", "/vehicle", Kind::Integer, ""),
    ("outcome", "/outcome", Kind::Text, ""),
    ("collision_with", "/collision_with", Kind::Integer, ""),
    ("collision_step", "/collision_step", Kind::Integer, ""),
    ("collision_kind", "/collision_kind", Kind::Text, ""),
    ("hit_from_behind", "/hit_from_behind", Kind::Text, ""),
    ("steps", "/steps", Kind::Integer, ""),
    ("cycles", "/cycles", Kind::Integer, ""),
    ("emergency_cycles", "/emergency_cycles", Kind::Integer, ""),
    ("near_misses", "/near_misses", Kind::Integer, ""),
    (
        "largest_deceleration",
        "/largest_deceleration",
        Kind::Float,
        "m/s²",
    ),
    ("mean_jerk", "/mean_jerk", Kind::Float, "m/s³"),
    ("max_jerk", "/max_jerk", Kind::Float, "m/s³"),
    ("seconds_to_goal", "/seconds_to_goal", Kind::Float, "s"),
    ("median_cycle_ms", "/median_cycle_ms", Kind::Float, "ms"),
    ("longest_cycle_ms", "/longest_cycle_ms", Kind::Float, "ms"),
    (
        "median_overhead_ms",
        "/external_planner/median_overhead_ms",
        Kind::Float,
        "ms",
    ),
    (
        "undrivable",
        "/external_planner/undrivable",
        Kind::Integer,
        "",
    ),
    ("planner_error", "/external_planner/error", Kind::Text, ""),
    (
        "planner_error_step",
        "/external_planner/error_step",
        Kind::Integer,
        "",
    ),
    (
        "planner_message",
        "/external_planner/message",
        Kind::Text,
        "",
    ),
    ("planner_stderr", "/external_planner/stderr", Kind::Text, ""),
    (
        "first_undrivable_step",
        "/external_planner/first_undrivable_step",
        Kind::Integer,
        "",
    ),
    (
        "first_undrivable",
        "/external_planner/first_undrivable",
        Kind::Text,
        "",
    ),
    (
        "worst_undrivable",
        "/external_planner/worst_undrivable/bound",
        Kind::Text,
        "",
    ),
    (
        "worst_undrivable_step",
        "/external_planner/worst_undrivable/step",
        Kind::Integer,
        "",
    ),
    (
        "worst_undrivable_value",
        "/external_planner/worst_undrivable/value",
        Kind::Float,
        "",
    ),
    (
        "worst_undrivable_limit",
        "/external_planner/worst_undrivable/limit",
        Kind::Float,
        "",
    ),
    (
        "worst_undrivable_unit",
        "/external_planner/worst_undrivable/unit",
        Kind::Text,
        "",
    ),
    ("rule_mode", "/rule_mode", Kind::Text, ""),
    ("rules_broken", "/rules_broken", Kind::Text, ""),
    (
        "recorded_rules_broken",
        "/recorded_rules_broken",
        Kind::Text,
        "",
    ),
    ("note", "/note", Kind::Text, ""),
];

/// The columns of the rules.
const RULES: [(&str, Rule); Rule::ALL.len()] = [
    ("rule_safe_distance", Rule::SafeDistance),
    ("rule_unnecessary_braking", Rule::UnnecessaryBraking),
    ("rule_speed_limit", Rule::SpeedLimit),
    ("rule_stop_sign", Rule::StopSign),
    ("rule_red_light", Rule::RedLight),
    ("rule_right_before_left", Rule::RightBeforeLeft),
    ("rule_priority", Rule::Priority),
    ("rule_left_turn", Rule::LeftTurn),
];

/// The table in the making; none where none is asked for.
pub struct Export {
    file: PathBuf,
    format: Format,
    spreadsheet: ForSpreadsheet,
    target: Target,
    rows: Vec<Row>,
    /// The run that is continued.
    finished: Option<Arc<FinishedFiles>>,
}

impl Export {
    /// Begins a table in this file.
    ///
    /// # Errors
    /// Its ending is unknown, or it cannot be written, or it exists and is not that of the run that is continued.
    pub fn begin(
        (file, spreadsheet): (Option<&Path>, ForSpreadsheet),
        overwrite: bool,
        finished: Option<Arc<FinishedFiles>>,
    ) -> Result<Option<Self>, Failure> {
        let Some(file) = file else {
            spreadsheet.check(false)?;
            return Ok(None);
        };
        let format = output::format_of_name(file, ENDINGS).ok_or_else(|| {
            Failure::input(format!(
                "--table {}: unknown file extension; known are .csv, .json, .jsonl and .parquet",
                file.display()
            ))
        })?;
        spreadsheet.check(format == Format::Csv)?;
        let own = finished.as_ref().filter(|_| !overwrite && file.exists());
        if let Some(run) = own.filter(|run| !run.wrote_table(file)) {
            return Err(Failure::input(format!(
                "--table {}: exists, and is not the table of the run in {} or was changed since; name another file, or replace it with --overwrite",
                file.display(),
                run.folder().display()
            )));
        }
        Ok(Some(Self {
            file: file.to_path_buf(),
            format,
            spreadsheet,
            target: Target::begin(Some(file), overwrite || own.is_some())?,
            rows: Vec::new(),
            finished,
        }))
    }

    /// Adds a drive, as `plan --format json` prints it.
    pub fn add(&mut self, drive: &Value) {
        let nothing = Value::Null;
        let cell = |(_, place, kind, _): &(&str, &str, Kind, &str)| {
            let value = drive.pointer(place).unwrap_or(&nothing);
            match (kind, value.as_f64(), value.as_array()) {
                // Whole numbers, too.
                (Kind::Float, Some(number), _) => Cell::finite(number),
                (_, _, Some(list)) => {
                    let between = if place.ends_with("stderr") { "\n" } else { " " };
                    let words: Vec<&str> = list.iter().filter_map(Value::as_str).collect();
                    Cell::from_json(&words.join(between).into())
                }
                _ => Cell::from_json(value),
            }
        };
        let rules = drive["rules"].as_array();
        let rule = |rule: Rule| {
            let mut all = rules.into_iter().flatten();
            let found = all.find(|one| one["rule"] == rule.name());
            Cell::from_json(found.map_or(&nothing, |one| &one["status"]))
        };
        let cells = COLUMNS.iter().map(cell);
        let rules = RULES.iter().map(|(_, one)| rule(*one));
        self.rows.push(cells.chain(rules).collect());
    }

    /// Writes the table.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(self) -> Outcome {
        let source = "nearmiss help planners";
        let columns = COLUMNS
            .iter()
            .map(|(name, _, kind, unit)| Column::new(name, *kind, unit, source).optional());
        let rules = RULES
            .iter()
            .map(|(name, _)| Column::new(name, Kind::Text, "", source).optional());
        let mut table = Table::new("drives", columns.chain(rules).collect());
        table.spreadsheet = self.spreadsheet;
        let rows = table.encode(self.format, self.rows);
        let written =
            TableWriter::begin(self.target, self.format, &table).and_then(|mut writer| {
                writer.write(rows)?;
                writer.finish()
            });
        match output::written(Some(&self.file), written)? {
            Some(target) => target.finish()?,
            None => return Ok(()),
        }
        { self.finished.as_ref() }.map_or(Ok(()), |run| run.note_table(&self.file))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rule_has_a_column_of_its_name() {
        for rule in Rule::ALL {
            let name = format!("rule_{}", rule.name());
            assert!(RULES.contains(&(name.as_str(), rule)), "{name}");
        }
    }
}
