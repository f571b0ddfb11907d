//! `plan --table FILE`: one row a drive, as CSV, JSON lines or Parquet.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::cli::output::{self, Cell, Column, Format, Kind, Row, Table, TableWriter, Target};
use crate::cli::{Failure, Outcome};

/// What the endings of names ask for.
const ENDINGS: &[(&str, Format)] = &[
    ("csv", Format::Csv),
    ("json", Format::Json),
    ("jsonl", Format::Json),
    ("parquet", Format::Parquet),
];

/// The columns: fields of `plan --json`, those of `external_planner` behind a point.
const COLUMNS: [(&str, Kind, &str); 27] = [
    ("scenario", Kind::Text, ""),
    ("file", Kind::Text, ""),
    ("planner", Kind::Text, ""),
    ("external_planner.name", Kind::Text, ""),
    ("external_planner.version", Kind::Text, ""),
    ("planning_problem", Kind::Integer, ""),
    ("prediction", Kind::Text, ""),
    ("traffic", Kind::Text, ""),
    ("vehicle", Kind::Integer, ""),
    ("outcome", Kind::Text, ""),
    ("collision_with", Kind::Integer, ""),
    ("collision_step", Kind::Integer, ""),
    ("collision_kind", Kind::Text, ""),
    ("hit_from_behind", Kind::Text, ""),
    ("steps", Kind::Integer, ""),
    ("cycles", Kind::Integer, ""),
    ("emergency_cycles", Kind::Integer, ""),
    ("near_misses", Kind::Integer, ""),
    ("largest_deceleration", Kind::Float, "m/s²"),
    ("mean_jerk", Kind::Float, "m/s³"),
    ("max_jerk", Kind::Float, "m/s³"),
    ("seconds_to_goal", Kind::Float, "s"),
    ("median_cycle_ms", Kind::Float, "ms"),
    ("longest_cycle_ms", Kind::Float, "ms"),
    ("external_planner.median_overhead_ms", Kind::Float, "ms"),
    ("external_planner.undrivable", Kind::Integer, ""),
    ("external_planner.error", Kind::Text, ""),
];

/// The table in the making; none where none is asked for.
pub struct Export {
    file: PathBuf,
    format: Format,
    target: Target,
    rows: Vec<Row>,
}

impl Export {
    /// Begins a table in this file.
    ///
    /// # Errors
    /// Its ending is unknown, or it cannot be written.
    pub fn begin(file: Option<&Path>, overwrite: bool) -> Result<Option<Self>, Failure> {
        let Some(file) = file else {
            return Ok(None);
        };
        let format = output::format_of_name(file, ENDINGS).ok_or_else(|| {
            Failure::input(format!(
                "--table {}: unknown file extension; known are .csv, .json, .jsonl and .parquet",
                file.display()
            ))
        })?;
        Ok(Some(Self {
            file: file.to_path_buf(),
            format,
            target: Target::begin(Some(file), overwrite)?,
            rows: Vec::new(),
        }))
    }

    /// Adds a drive, as `plan --json` prints it.
    pub fn add(&mut self, drive: &Value) {
        let cell = |(name, kind, _): &(&str, Kind, &str)| {
            let value = match name.split_once('.') {
                Some((outer, inner)) => &drive[outer][inner],
                None => &drive[*name],
            };
            match (kind, value.as_f64()) {
                // Whole numbers, too.
                (Kind::Float, Some(number)) => Cell::finite(number),
                _ => Cell::from_json(value),
            }
        };
        self.rows.push(COLUMNS.iter().map(cell).collect());
    }

    /// Writes the table.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(self) -> Outcome {
        let columns = COLUMNS.iter().map(|(name, kind, unit)| {
            let name = name.rsplit('.').next().unwrap_or(name);
            let name = match name {
                "name" => "planner_name",
                "version" => "planner_version",
                "error" => "planner_error",
                name => name,
            };
            Column::new(name, *kind, unit, "nearmiss help planners").optional()
        });
        let table = Table::new("drives", columns.collect());
        let rows = table.encode(self.format, self.rows);
        let written =
            TableWriter::begin(self.target, self.format, &table).and_then(|mut writer| {
                writer.write(rows)?;
                writer.finish()
            });
        match output::written(Some(&self.file), written)? {
            Some(target) => target.finish(),
            None => Ok(()),
        }
    }
}
