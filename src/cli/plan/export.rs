//! `plan --table FILE`: one row a drive, as CSV, JSON lines or Parquet.

use std::path::{Path, PathBuf};

use super::document::DriveRecord;
use crate::many_files::RunJournal;
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

/// The columns of drives, and behind them one for each rule with what became of it.
fn columns() -> Vec<Column> {
    let rules = Rule::ALL.iter().map(|rule| Column {
        name: format!("rule_{}", rule.name()).into(),
        ..Column::new("", Kind::Text, "", "what became of the traffic rule").optional()
    });
    nearmiss_record::columns::<DriveRecord>()
        .into_iter()
        .chain(rules)
        .collect()
}

/// The table in the making; none where none is asked for.
pub struct Export {
    file: PathBuf,
    format: Format,
    spreadsheet: ForSpreadsheet,
    target: Target,
    rows: Vec<Row>,
}

impl Export {
    /// Begins a table in this file.
    ///
    /// # Errors
    /// Its ending is unknown, or it cannot be written, or it exists and is not that of the run that is continued.
    pub fn begin(
        (file, spreadsheet): (Option<&Path>, ForSpreadsheet),
        overwrite: bool,
        run: &RunJournal,
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
        let run_folder = run.folder().filter(|_| !overwrite && file.exists());
        if let Some(folder) = run_folder.filter(|_| !run.wrote_table(file)) {
            return Err(Failure::input(format!(
                "--table {}: exists, and is not the table of the run in {} or was changed since; name another file, or replace it with --overwrite",
                file.display(),
                folder.display()
            )));
        }
        Ok(Some(Self {
            file: file.to_path_buf(),
            format,
            spreadsheet,
            target: Target::begin(Some(file), overwrite || run_folder.is_some())?,
            rows: Vec::new(),
        }))
    }

    /// Adds a drive.
    ///
    /// # Errors
    /// Never in practice: a record has a row.
    pub fn add(&mut self, drive: &DriveRecord) -> Outcome {
        let mut row = nearmiss_record::row(drive).map_err(Failure::input)?;
        row.extend(Rule::ALL.iter().map(|rule| {
            let found = drive.rules.iter().find(|one| one.rule == rule.name());
            found.map_or(Cell::None(""), |one| one.status.clone().into())
        }));
        self.rows.push(row);
        Ok(())
    }

    /// Writes the table of a run.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(self, run: &RunJournal) -> Outcome {
        let mut table = Table::new("drives", columns());
        table.for_spreadsheet = self.spreadsheet.is_asked();
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
        run.note_table(&self.file)
    }
}
