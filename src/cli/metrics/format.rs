//! Formats of the measures.

use std::path::Path;

use crate::{Failure, output};

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Format {
    /// CSV with a header.
    Csv,
    /// JSON lines: one object per row.
    Json,
    /// Apache Parquet with units and sources as metadata; needs a file.
    Parquet,
}

/// What the endings of names ask for.
const ENDINGS: &[(&str, Format)] = &[
    ("csv", Format::Csv),
    ("json", Format::Json),
    ("jsonl", Format::Json),
    ("ndjson", Format::Json),
    ("parquet", Format::Parquet),
];

impl Format {
    /// The format that was asked for, or that the file's name asks for; both must agree.
    pub fn chosen(asked: Option<Self>, file: Option<&Path>) -> Result<Self, Failure> {
        let named = file.and_then(|file| Some((file, output::format_of_name(file, ENDINGS)?)));
        if let (Some(asked), Some((file, named))) = (asked, named)
            && asked != named
        {
            return Err(Failure::input(format!(
                "--format {} contradicts the file name {} ({}); drop --format or rename the file",
                asked.of_table().name(),
                file.display(),
                named.of_table().name()
            )));
        }
        let known = ".csv, .json, .jsonl, .ndjson and .parquet";
        output::format_of(asked, file, Self::Csv, (ENDINGS, known))
    }

    pub fn of_table(self) -> output::Format {
        match self {
            Self::Csv => output::Format::Csv,
            Self::Json => output::Format::Json,
            Self::Parquet => output::Format::Parquet,
        }
    }
}
