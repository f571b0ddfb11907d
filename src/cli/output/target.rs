//! Where data goes: standard output, or a file that is written whole or not at all.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::{Failure, Outcome};
use nearmiss_base::system::{NewFile, SaveError};

/// The file that a command writes, on the command line.
#[derive(Debug, clap::Args)]
pub struct OutputFile {
    /// File to write; - is standard output, which is the default.
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
