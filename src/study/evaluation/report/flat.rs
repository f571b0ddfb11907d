//! Reports as flat rows for CSV and Parquet: one for each cell, comparison or value of an axis; unrounded.

use std::borrow::Cow;

use super::contents::rows_of;
use super::{Report, ReportSubject};
use nearmiss_record::{Cell, Column, Kind, Record, Row, Table, columns};

/// Rows with their columns.
#[derive(Debug, Clone)]
pub struct FlatRows {
    /// The columns.
    pub table: Table,
    /// A cell for each.
    pub rows: Vec<Row>,
}

impl FlatRows {
    /// The rows of parts of a report, with the batch, the truth and, where it is one, the part of its split as the last
    /// columns.
    #[must_use]
    pub fn new<R: Record>(parts: &[(&ReportSubject, Vec<R>)]) -> Self {
        let text = |name| Column::new(name, Kind::Text, "", "").optional();
        let has_split = parts.iter().any(|(about, _)| about.split.is_some());
        let mut columns = columns::<R>();
        columns.extend([text("batch"), text("truth")]);
        columns.extend(has_split.then(|| text("split")));
        let word = |word: Option<String>| word.map_or(Cell::None(""), Cell::from);
        let of_part = |(about, records): &(&ReportSubject, Vec<R>)| {
            let mut rows = rows_of(records);
            for row in &mut rows {
                let truth = Some(about.truth.words.clone());
                row.extend([word(about.batch.clone()), word(truth)]);
                row.extend(has_split.then(|| word(about.split.map(String::from))));
            }
            rows
        };
        Self {
            rows: parts.iter().flat_map(of_part).collect(),
            table: Table::new("report", columns),
        }
    }

    /// The same under other names of columns; those without one are left out.
    pub(super) fn renamed(mut self, name: impl Fn(&str) -> Option<Cow<'static, str>>) -> Self {
        let names: Vec<_> = { self.table.columns.iter() }
            .map(|column| name(&column.name))
            .collect();
        for row in &mut self.rows {
            let kept = row.drain(..).zip(&names);
            *row = kept
                .filter_map(|(cell, name)| name.as_ref().map(|_| cell))
                .collect();
        }
        let columns = self.table.columns.drain(..).zip(names);
        let columns = columns.filter_map(|(column, name)| {
            Some(Column {
                name: name?,
                ..column
            })
        });
        self.table.columns = columns.collect();
        self
    }

    /// As CSV with a header.
    #[must_use]
    pub fn csv(self) -> String {
        String::from_utf8_lossy(&self.table.csv(self.rows)).into_owned()
    }
}

impl Report {
    /// The cells, one row each.
    #[must_use]
    pub fn rows(&self) -> FlatRows {
        FlatRows::new(&[(&self.about, self.cells.clone())])
    }

    /// The comparisons of ways, one row each.
    #[must_use]
    pub fn pair_rows(&self) -> FlatRows {
        FlatRows::new(&[(&self.about, self.pairs.clone())])
    }
}
