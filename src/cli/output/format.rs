//! `--format` of commands that print text or JSON.

/// How results are printed.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct FormatOption {
    /// Form of the output.
    #[arg(long, value_enum, default_value = "table")]
    format: PrintedFormat,
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

impl FormatOption {
    /// Whether JSON is printed.
    pub fn is_json(self) -> bool {
        self.format == PrintedFormat::Json
    }
}
