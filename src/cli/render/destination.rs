//! The output of pictures: standard output, a file or a folder, written atomically.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::Render;
use crate::Failure;
use crate::many_files::holds;
use crate::open::clash;
use crate::output::Target;
use nearmiss_formats::Entry;
use nearmiss_render::Format;

/// Where pictures go, and how they are written.
pub struct Destination {
    place: Place,
    /// How.
    pub format: Format,
    overwrite: bool,
    /// Files that an earlier run wrote may be there.
    resumed: bool,
    /// Files of the present scenario.
    written: Mutex<Vec<PathBuf>>,
}

enum Place {
    Stdout,
    File(PathBuf),
    Folder(PathBuf),
}

impl Destination {
    /// The one that was asked for.
    pub fn new(arguments: &Render, entries: &[Entry]) -> Result<Self, Failure> {
        let steps = match (arguments.all, arguments.at.len()) {
            _ if arguments.is_grid() => 1,
            (true, _) => 2,
            (false, at) => at,
        };
        let film = arguments.format == Some(Format::Gif);
        let several =
            entries.len() > 1 || arguments.many.part.shard.is_some() || (steps > 1 && !film);
        // Several pictures have no room in one file; without --format, an ending that was left out is asked for.
        let new_folder = |path: &Path| {
            several && arguments.format.is_some() && path.extension().is_none() && !path.exists()
        };
        let place = match &arguments.output {
            None => Place::Stdout,
            Some(path) if path.as_os_str() == "-" => Place::Stdout,
            Some(path) if path.is_dir() || new_folder(path) => Place::Folder(path.clone()),
            Some(path) => Place::File(path.clone()),
        };
        let of_name = match &place {
            Place::File(path) => Format::of_file(path),
            _ => None,
        };
        let format = match (arguments.format, of_name, &place) {
            (Some(asked), Some(named), Place::File(path)) if asked != named => {
                return Err(Failure::input(format!(
                    "--format {} contradicts the file name {}; drop --format or rename the file",
                    asked.name(),
                    path.display()
                )));
            }
            (None, None, Place::File(path)) => {
                let folder = match path.extension() {
                    None if several => ", and makes this a folder",
                    _ => "",
                };
                return Err(Failure::input(format!(
                    "{}: unknown file extension; known are .svg, .png and .gif; --format works with any name{folder}",
                    path.display()
                )));
            }
            (asked, named, _) => asked.or(named).unwrap_or(Format::Svg),
        };
        if format == Format::Gif && arguments.is_grid() {
            return Err(Failure::input(
                "a grid is one picture, not a film: use .svg or .png",
            ));
        }
        if format == Format::Gif && steps < 2 {
            return Err(Failure::input(
                "GIF needs several pictures: use --all, or several moments with --at",
            ));
        }
        let target = Self {
            place,
            format,
            overwrite: arguments.overwrite,
            resumed: arguments.many.resume,
            written: Mutex::default(),
        };
        match &target.place {
            Place::Folder(_) => target.without_clash(entries),
            _ if entries.len() > 1 => Err(Failure::input(format!(
                "pictures of {} scenarios need a folder: -o FOLDER, with --format if it does not exist yet",
                entries.len()
            ))),
            Place::Stdout if steps > 1 && format != Format::Gif => Err(Failure::input(
                "several pictures need -o FOLDER, or -o NAME.svg or NAME.png for numbered files",
            )),
            _ => Ok(target),
        }
    }

    fn without_clash(self, entries: &[Entry]) -> Result<Self, Failure> {
        match clash(entries) {
            Some((a, b)) => Err(Failure::input(format!(
                "{} and {} would both be drawn as {}; draw them into separate folders",
                a.display(),
                b.display(),
                a.name
            ))),
            None => Ok(self),
        }
    }

    /// The folder, if pictures go into one.
    pub fn folder(&self) -> Option<&Path> {
        match &self.place {
            Place::Folder(folder) => Some(folder),
            _ => None,
        }
    }

    /// The files that were written since it was asked last.
    pub fn take_written(&self) -> Vec<PathBuf> {
        std::mem::take(&mut *self.written.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// The file of a scenario, numbered by its step where there are several.
    fn path(&self, entry: &Entry, step: Option<i64>) -> Option<PathBuf> {
        let ending = self.format.name();
        let number = step.map_or(String::new(), |step| format!("_{step:04}"));
        match &self.place {
            Place::Stdout => None,
            Place::Folder(folder) => Some(folder.join(format!("{}{number}.{ending}", entry.name))),
            Place::File(path) if step.is_none() => Some(path.clone()),
            Place::File(path) => {
                let stem = path.file_stem().unwrap_or_default().to_string_lossy();
                let ending = path
                    .extension()
                    .map_or(ending.into(), |e| e.to_string_lossy());
                Some(path.with_file_name(format!("{stem}{number}.{ending}")))
            }
        }
    }

    /// Begins the file of a scenario.
    pub fn begin(&self, entry: &Entry, step: Option<i64>) -> Result<Target, Failure> {
        let path = self.path(entry, step);
        if let (Place::Folder(folder), Some(_)) = (&self.place, &path) {
            // Not before there is something to put into it.
            std::fs::create_dir_all(folder).map_err(|e| Failure::system(folder.display(), &e))?;
        }
        Target::begin_whole(path.as_deref(), self.overwrite)
    }

    /// Writes a whole picture.
    pub fn save(&self, entry: &Entry, step: Option<i64>, bytes: &[u8]) -> Result<(), Failure> {
        let path = self.path(entry, step);
        if let Some(path) = &path {
            let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
            written.push(path.clone());
        }
        match path {
            Some(path) if self.resumed && holds(&path, bytes) => Ok(()),
            _ => self.begin(entry, step)?.save(bytes),
        }
    }
}
