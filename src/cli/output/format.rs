//! `--format` of commands that print text or JSON.

use std::path::Path;

use crate::Failure;

/// How results are printed.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct FormatOption {
    /// Form of the output [default: table].
    #[arg(long, value_enum)]
    format: Option<PrintedFormat>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
enum PrintedFormat {
    /// Text for people.
    #[default]
    #[value(alias = "text")]
    Table,
    /// JSON: one object; of several, one a line.
    #[value(alias = "jsonl")]
    Json,
}

/// What the endings of names ask for.
const ENDINGS: &[(&str, PrintedFormat)] = &[
    ("txt", PrintedFormat::Table),
    ("json", PrintedFormat::Json),
    ("jsonl", PrintedFormat::Json),
    ("ndjson", PrintedFormat::Json),
];

impl FormatOption {
    /// Whether JSON is printed.
    pub fn is_json(self) -> bool {
        self.format == Some(PrintedFormat::Json)
    }

    /// Whether JSON is written to this file, by the option or by the ending of its name.
    ///
    /// # Errors
    /// The ending asks for neither text nor JSON, or for the other one.
    pub fn is_json_in(self, file: Option<&Path>) -> Result<bool, Failure> {
        let known = (ENDINGS, ".txt, .json and .jsonl");
        let format = super::format_of(self.format, file, PrintedFormat::Table, known)?;
        Ok(format == PrintedFormat::Json)
    }
}
