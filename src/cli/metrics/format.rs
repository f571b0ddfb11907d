//! Formats of the measures.

use std::path::Path;

use crate::{Failure, output};

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Format {
    /// CSV with a header.
    Csv,
    /// JSON lines: one object per row.
    #[value(alias = "jsonl")]
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
