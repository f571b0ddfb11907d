//! What commands write: data on standard output or into a file, as text or as a table; words on standard error.

pub use nearmiss_base::system::counted;
pub use nearmiss_record::{
    Align, Cell, Column, Encoded, Format, Kind, Row, Table, line, lines as table_lines,
};
pub use nearmiss_study::evaluation::local_time as local;

use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use nearmiss_base::system::{NewFile, SaveError};

use super::{Failure, Outcome, json};

/// Writes text; a reader that closed the pipe ends the program's output, not the program.
pub fn text(text: &str) -> Result<(), Failure> {
    try_text(text).map(drop)
}

/// Writes text, and returns whether it is still read: false where the pipe is closed.
pub fn try_text(text: &str) -> Result<bool, Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(false),
        Err(e) => Err(Failure::system("standard output", &e)),
        Ok(()) => Ok(true),
    }
}

/// Says one line on standard error, with the control characters of file names and messages shown instead of obeyed.
pub fn say(words: &str) {
    // Nothing can be done about a standard error that is gone.
    let _ = writeln!(io::stderr().lock(), "{}", visible(words));
}

/// Says several lines on standard error, as [`say`] does one.
pub fn lines(words: &str) {
    words.trim_end().lines().for_each(say);
}

/// Writes one JSON object on one line, with the version of its form.
pub fn json(value: &impl serde::Serialize) -> Result<(), Failure> {
    text(&json_line(value)?)
}

/// Writes an output as one JSON object on one line, with the version of its form.
pub fn document(output: &impl json::Output) -> Result<(), Failure> {
    text(&document_line(output)?)
}

/// An output as one JSON object on one line, with the version of its form.
pub fn document_line(output: &impl json::Output) -> Result<String, Failure> {
    json_line(&output.document().map_err(Failure::input)?)
}

/// One JSON object as a line that no terminal obeys, with the version of its form.
pub fn json_line(value: &impl serde::Serialize) -> Result<String, Failure> {
    nearmiss_record::json_line(value).map_err(Failure::input)
}

/// Writes records of CSV.
pub fn csv<R>(records: impl IntoIterator<Item = R>) -> Outcome
where
    R: IntoIterator<Item: AsRef<str>>,
{
    text(&String::from_utf8_lossy(&nearmiss_record::csv(records)))
}

/// A table that goes to a file or to standard output.
pub type TableWriter = nearmiss_record::TableWriter<Target>;

/// Formats of tables for programs, on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum TableFormat {
    /// CSV with a header.
    Csv,
    /// JSON lines: one object per row.
    #[value(alias = "jsonl")]
    Json,
    /// Apache Parquet, with units and meanings as metadata.
    Parquet,
    /// Apache Arrow IPC stream, with units and meanings as metadata.
    Arrow,
}

impl From<TableFormat> for Format {
    fn from(format: TableFormat) -> Self {
        match format {
            TableFormat::Csv => Self::Csv,
            TableFormat::Json => Self::Json,
            TableFormat::Parquet => Self::Parquet,
            TableFormat::Arrow => Self::Arrow,
        }
    }
}

impl TableFormat {
    /// What the endings of names ask for.
    pub const ENDINGS: &[(&str, Self)] = &[
        ("csv", Self::Csv),
        ("json", Self::Json),
        ("jsonl", Self::Json),
        ("ndjson", Self::Json),
        ("parquet", Self::Parquet),
        ("arrow", Self::Arrow),
        ("arrows", Self::Arrow),
    ];

    /// These endings, in words.
    pub const KNOWN: &str = ".csv, .json, .jsonl, .ndjson, .parquet and .arrow";
}

/// Formats of what is a page or a text table for people, and a table for programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum PageFormat {
    /// Human-readable text.
    #[value(alias = "text")]
    Table,
    /// CSV with a header: one row per item.
    Csv,
    /// JSON: one object; several as JSON lines.
    #[value(alias = "jsonl")]
    Json,
    /// Apache Parquet, with units and meanings as metadata: one row per item.
    Parquet,
    /// Apache Arrow IPC stream, with the same rows and metadata.
    Arrow,
}

impl PageFormat {
    /// The format that is asked for, or that the file's name asks for.
    pub fn of(asked: Option<Self>, file: Option<&Path>) -> Result<Self, Failure> {
        let known = (
            Self::ENDINGS,
            ".txt, .csv, .json, .jsonl, .ndjson, .parquet and .arrow",
        );
        format_of(asked, file, Self::Table, known)
    }

    const ENDINGS: &[(&str, Self)] = &[
        ("txt", Self::Table),
        ("csv", Self::Csv),
        ("json", Self::Json),
        ("jsonl", Self::Json),
        ("ndjson", Self::Json),
        ("parquet", Self::Parquet),
        ("arrow", Self::Arrow),
        ("arrows", Self::Arrow),
    ];

    /// The format of a table for programs; none of text.
    pub fn of_table(self) -> Option<Format> {
        match self {
            Self::Table => None,
            Self::Csv => Some(Format::Csv),
            Self::Json => Some(Format::Json),
            Self::Parquet => Some(Format::Parquet),
            Self::Arrow => Some(Format::Arrow),
        }
    }
}

/// Writes a whole table.
pub fn save_table(
    table: &Table,
    format: Format,
    rows: Vec<Row>,
    target: Target,
    file: Option<&Path>,
) -> Outcome {
    let encoded = table.encode(format, rows);
    let done = TableWriter::begin(target, format, table).and_then(|mut writer| {
        writer.write(encoded)?;
        writer.finish()
    });
    match written(file, done)? {
        Some(target) => target.finish(),
        None => Ok(()),
    }
}

/// Refuses a format that a terminal cannot take.
pub fn check_format(format: Format, file: Option<&std::path::Path>) -> Outcome {
    let is_binary = matches!(format, Format::Parquet | Format::Arrow);
    if is_binary && file.is_none() && io::stdout().is_terminal() {
        let name = format.name();
        return Err(Failure::input(format!(
            "{name} is not for a terminal: -o FILE, or a pipe"
        )));
    }
    Ok(())
}

/// So many of all scenarios: `2 of 7 scenarios`, and of a single one `the scenario`.
#[must_use]
pub fn of_scenarios(count: usize, all: usize) -> String {
    match all {
        1 => "the scenario".into(),
        _ => format!("{count} of {all} scenarios"),
    }
}

/// Text from outside with its control characters shown instead of obeyed.
#[must_use]
pub fn visible(text: &str) -> String {
    nearmiss_scene::description::visible(text).into_owned()
}

/// How results are printed.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct FormatOption {
    /// Output format [default: table].
    #[arg(long, value_enum)]
    format: Option<PrintedFormat>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
enum PrintedFormat {
    /// Human-readable text.
    #[default]
    #[value(alias = "text")]
    Table,
    /// JSON: one object; several as JSON lines.
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
        let format = format_of(self.format, file, PrintedFormat::Table, known)?;
        Ok(format == PrintedFormat::Json)
    }
}

/// The option for it, on the command line.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct ForSpreadsheet {
    /// Make CSV safe for spreadsheets: prefix text that would run as a formula with an apostrophe.
    #[arg(long)]
    for_spreadsheet: bool,
}

impl ForSpreadsheet {
    /// Refuses it for other formats, and where nothing is written.
    pub fn check(self, is_csv: bool) -> Outcome {
        if self.for_spreadsheet && !is_csv {
            Err(Failure::input(
                "--for-spreadsheet is for CSV alone; choose it as the format",
            ))
        } else {
            Ok(())
        }
    }

    /// Whether it was asked for.
    pub fn is_asked(self) -> bool {
        self.for_spreadsheet
    }

    /// CSV as it was asked for.
    pub fn applied(self, csv: Vec<u8>) -> Vec<u8> {
        if self.for_spreadsheet {
            without_formulas(&csv)
        } else {
            csv
        }
    }
}

/// The same CSV, whose cells are no formulas.
fn without_formulas(csv: &[u8]) -> Vec<u8> {
    let mut reader = csv::ReaderBuilder::new();
    let reader = reader.has_headers(false).flexible(true).from_reader(csv);
    let mut writer = csv::WriterBuilder::new()
        .flexible(true)
        .from_writer(Vec::new());
    for record in reader.into_byte_records().flatten() {
        let cells = record.iter().map(|cell| {
            if std::str::from_utf8(cell).is_ok_and(nearmiss_record::begins_formula) {
                [b"'", cell].concat()
            } else {
                cell.to_vec()
            }
        });
        // Writing to memory does not fail.
        let _ = writer.write_record(cells);
    }
    writer.into_inner().unwrap_or_default()
}

/// The file that a command writes, on the command line.
#[derive(Debug, clap::Args)]
pub struct OutputFile {
    /// File to write; - is standard output [default: standard output].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing file.
    #[arg(long, requires = "output")]
    overwrite: bool,
}

impl OutputFile {
    /// The file; `None` for standard output.
    pub fn file(&self) -> Option<&Path> {
        file_of(self.output.as_deref())
    }

    /// Whether existing files are replaced.
    pub fn overwrites(&self) -> bool {
        self.overwrite
    }

    /// Begins to write.
    pub fn begin(&self) -> Result<Target, Failure> {
        Target::begin(self.file(), self.overwrite)
    }
}

/// The file that `-o` names; `-` is standard output.
pub fn file_of(output: Option<&Path>) -> Option<&Path> {
    output.filter(|path| *path != Path::new("-"))
}

/// The format that was asked for, or that the ending of the file's name asks for, which must agree; `known` lists the
/// endings.
pub fn format_of<F: Copy + PartialEq>(
    asked: Option<F>,
    file: Option<&Path>,
    default: F,
    (endings, known): (&[(&str, F)], &str),
) -> Result<F, Failure> {
    let named = file.and_then(|file| format_of_name(file, endings));
    // A form without an ending, such as a list of paths, goes into any file.
    let own = asked.and_then(|asked| endings.iter().find(|(_, format)| *format == asked));
    match (asked, file) {
        (Some(format), Some(file)) => match (own, named) {
            (Some((own, _)), Some(named)) if named != format => Err(Failure::input(format!(
                "--format {own} contradicts the file name {}; drop --format or rename the file",
                file.display()
            ))),
            _ => Ok(format),
        },
        (Some(format), None) => Ok(format),
        (None, None) => Ok(default),
        (None, Some(file)) => match named {
            Some(format) => Ok(format),
            // A folder is refused where the file is begun.
            None if file.is_dir() => Ok(default),
            None => Err(Failure::input(format!(
                "{}: unknown file extension; known are {known}; --format works with any name",
                file.display()
            ))),
        },
    }
}

/// The format that a file's name asks for.
pub fn format_of_name<F: Copy>(file: &Path, endings: &[(&str, F)]) -> Option<F> {
    let ending = file.extension()?.to_str()?.to_ascii_lowercase();
    let found = endings.iter().find(|(known, _)| *known == ending);
    found.map(|(_, format)| *format)
}

/// Destination of bytes.
pub struct Target {
    /// The file; `None` for standard output.
    file: Option<PathBuf>,
    out: Out,
}

enum Out {
    Stdout(Lines),
    File(BufWriter<NewFile>),
}

impl Target {
    /// Begins a file, or standard output where there is none.
    pub fn begin(file: Option<&Path>, overwrite: bool) -> Result<Self, Failure> {
        let Some(path) = file else {
            return Ok(Self::stdout(AT_ONCE));
        };
        if path.is_dir() {
            return Err(Failure::input(format!(
                "{}: is a folder; name a file in it",
                path.display()
            )));
        }
        let file = NewFile::begin(path, overwrite).map_err(|error| refused(&error))?;
        Ok(Self {
            file: Some(path.to_path_buf()),
            out: Out::File(BufWriter::new(file)),
        })
    }

    /// The same; standard output, too, gets all or nothing.
    pub fn begin_whole(file: Option<&Path>, overwrite: bool) -> Result<Self, Failure> {
        match file {
            None => Ok(Self::stdout(usize::MAX)),
            file => Self::begin(file, overwrite),
        }
    }

    fn stdout(at_once: usize) -> Self {
        let waiting = Vec::new();
        Self {
            file: None,
            out: Out::Stdout(Lines { waiting, at_once }),
        }
    }

    /// Writes the last of it, and puts a file in its place.
    pub fn finish(self) -> Outcome {
        let file = self.file.as_deref();
        match self.out {
            Out::Stdout(mut lines) => written(file, lines.flush()).map(drop),
            Out::File(out) => {
                let whole = out.into_inner().map_err(io::IntoInnerError::into_error);
                match written(file, whole)? {
                    Some(whole) => whole.finish().map_err(Failure::input),
                    None => Ok(()),
                }
            }
        }
    }

    /// Writes everything, and puts a file in its place.
    pub fn save(mut self, bytes: &[u8]) -> Outcome {
        let done = self.write_all(bytes);
        match written(self.file.as_deref(), done)? {
            Some(()) => self.finish(),
            None => Ok(()),
        }
    }
}

/// What was written to a file or to standard output; `None` where the reader of a pipe has seen enough.
pub fn written<T>(file: Option<&Path>, result: io::Result<T>) -> Result<Option<T>, Failure> {
    match (result, file) {
        (Ok(done), _) => Ok(Some(done)),
        (Err(error), None) if error.kind() == io::ErrorKind::BrokenPipe => Ok(None),
        (Err(error), None) => Err(Failure::system("standard output", &error)),
        (Err(error), Some(path)) => Err(Failure::system(path.display(), &error)),
    }
}

/// An error of saving, with what to do on the command line.
pub fn refused(error: &SaveError) -> Failure {
    let hint = match error {
        SaveError::Exists(_) => " (--overwrite)",
        _ => "",
    };
    Failure::input(format!("{error}{hint}"))
}

impl Write for Target {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.out {
            Out::Stdout(out) => out.write(bytes),
            Out::File(out) => out.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.out {
            Out::Stdout(out) => out.flush(),
            Out::File(out) => out.flush(),
        }
    }
}

/// Standard output in whole lines: a program that has to end between two writes leaves no part of a row behind.
struct Lines {
    waiting: Vec<u8>,
    at_once: usize,
}

/// So many bytes of lines are written at once.
const AT_ONCE: usize = 1 << 16;

impl Lines {
    fn write_out(&mut self, until: usize) -> io::Result<()> {
        // What could not be written is not tried again: the reader is gone.
        let lines: Vec<u8> = self.waiting.drain(..until).collect();
        io::stdout().lock().write_all(&lines)
    }
}

impl Write for Lines {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.waiting.extend_from_slice(bytes);
        if self.waiting.len() >= self.at_once
            && let Some(end) = self.waiting.iter().rposition(|byte| *byte == b'\n')
        {
            self.write_out(end + 1)?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.write_out(self.waiting.len())?;
        io::stdout().flush()
    }
}

pub use nearmiss_workflow::rfc3339;

/// A bar, or nothing.
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar over `count` things, called `what`; `to_file` says that standard output stays empty.
    ///
    /// It is not shown where standard error is no terminal, nor where data runs over the same terminal.
    pub fn new(count: usize, what: &str, to_file: bool) -> Self {
        let shown = count > 1 && (to_file || !std::io::stdout().is_terminal());
        let bar = if shown {
            ProgressBar::with_draw_target(Some(count as u64), ProgressDrawTarget::stderr())
        } else {
            ProgressBar::hidden()
        };
        let template = format!("{{wide_bar}} {{pos}}/{{len}} {what}, {{eta}} left");
        if let Ok(style) = ProgressStyle::with_template(&template) {
            bar.set_style(style);
        }
        Self { bar }
    }

    /// The same with its own words, see [`Progress::say`].
    pub fn with_words(count: usize, what: &str) -> Self {
        let progress = Self::new(count, what, true);
        let template = format!("{{wide_bar}} {{pos}}/{{len}} {what}, {{msg}}, {{eta}} left");
        if let Ok(style) = ProgressStyle::with_template(&template) {
            progress.bar.set_style(style);
        }
        progress
    }

    /// How it goes.
    pub fn say(&self, words: String) {
        self.bar.set_message(words);
    }

    /// One more is done.
    pub fn step(&self) {
        self.bar.inc(1);
    }

    /// Prints a message without disturbing the bar.
    pub fn suspend(&self, say: impl FnOnce()) {
        self.bar.suspend(say);
    }
}

/// A bar over things that are counted when the first of them is done, on any thread.
pub struct LateProgress {
    what: &'static str,
    bar: Mutex<Option<Progress>>,
}

impl LateProgress {
    /// A bar over things that are called `what`.
    pub fn new(what: &'static str) -> Self {
        Self {
            what,
            bar: Mutex::default(),
        }
    }

    /// One more of so many is done.
    pub fn step(&self, of: usize) {
        let mut bar = self.bar.lock().unwrap_or_else(PoisonError::into_inner);
        bar.get_or_insert_with(|| Progress::new(of, self.what, true))
            .step();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_are_text_and_numbers_stay() {
        let csv = "name,value,said\n=1+1,-3.5,\"=HYPERLINK(\"\"http://x\"\",\"\"a\"\")\"\n\
                   @SUM,+2e3,\"a, -b\"\n-,inf,-inf\n\"-a\nb\",,'=x\n";
        let wanted = "name,value,said\n'=1+1,-3.5,\"'=HYPERLINK(\"\"http://x\"\",\"\"a\"\")\"\n\
                      '@SUM,+2e3,\"a, -b\"\n'-,inf,-inf\n\"'-a\nb\",,'=x\n";
        let asked = |for_spreadsheet| ForSpreadsheet { for_spreadsheet };
        assert_eq!(asked(true).applied(csv.into()), wanted.as_bytes());
        assert_eq!(asked(false).applied(csv.into()), csv.as_bytes());
        assert!(asked(true).check(false).is_err() && asked(false).check(false).is_ok());
    }
}
