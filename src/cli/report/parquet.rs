//! Reports as Apache Parquet: the rows of CSV in typed columns, with provenance as metadata.

use std::path::Path;

use crate::output::{self, Format, TableWriter, Target};
use crate::{Failure, Outcome};
use nearmiss_study::evaluation::Provenance;
use nearmiss_study::evaluation::report::FlatRows;

/// Writes the rows of a report.
pub fn write(
    (file, target): (Option<&Path>, Target),
    rows: FlatRows,
    provenance: Option<&Provenance>,
) -> Outcome {
    let FlatRows { mut table, rows } = rows;
    table
        .metadata
        .push(("version", env!("CARGO_PKG_VERSION").into()));
    if let Some(provenance) = provenance {
        let provenance = serde_json::to_string(provenance).map_err(Failure::input)?;
        table.metadata.push(("provenance", provenance));
    }
    let rows = table.encode(Format::Parquet, rows);
    let written = TableWriter::begin(target, Format::Parquet, &table).and_then(|mut writer| {
        writer.write(rows)?;
        writer.finish()
    });
    match output::written(file, written)? {
        Some(target) => target.finish(),
        None => Ok(()),
    }
}
