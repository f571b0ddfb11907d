//! The output of pictures: standard output, a file or a folder, written atomically.

use std::path::{Path, PathBuf};

use super::Render;
use crate::cli::Failure;
use crate::cli::open::clash;
use crate::cli::output::Target;
use crate::formats::Entry;
use crate::render::Format;

/// Where pictures go, and how they are written.
pub struct Destination {
    place: Place,
    /// How.
    pub format: Format,
    overwrite: bool,
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
            (true, _) => 2,
            (false, at) => at,
        };
        let film = arguments.format == Some(Format::Gif);
        let several = entries.len() > 1 || (steps > 1 && !film);
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
                    "--format {} does not go with the name {}; leave --format out or name another file",
                    asked.name(),
                    path.display()
                )));
            }
            (None, None, Place::File(path)) => {
                let folder = match path.extension() {
                    None if several => ", and makes a folder of this one",
                    _ => "",
                };
                return Err(Failure::input(format!(
                    "{}: the ending does not say how to write it; the known ones are .svg, .png and .gif, --format says \
                     it for any name{folder}",
                    path.display()
                )));
            }
            (asked, named, _) => asked.or(named).unwrap_or(Format::Svg),
        };
        if format == Format::Gif && steps < 2 {
            return Err(Failure::input(
                "GIF needs several pictures: --all, or several moments with --at",
            ));
        }
        let target = Self {
            place,
            format,
            overwrite: arguments.overwrite,
        };
        match &target.place {
            Place::Folder(_) => target.without_clash(entries),
            _ if entries.len() > 1 => Err(Failure::input(format!(
                "pictures of {} scenarios need a folder: -o FOLDER, with --format if it does not exist yet",
                entries.len()
            ))),
            Place::Stdout if steps > 1 && format != Format::Gif => Err(Failure::input(
                "several pictures need files: -o FOLDER, or -o NAME.svg or NAME.png, which are numbered",
            )),
            _ => Ok(target),
        }
    }

    fn without_clash(self, entries: &[Entry]) -> Result<Self, Failure> {
        match clash(entries) {
            Some((a, b)) => Err(Failure::input(format!(
                "{} and {} would both be drawn as {}; draw them into folders of their own",
                a.display(),
                b.display(),
                a.name
            ))),
            None => Ok(self),
        }
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
        self.begin(entry, step)?.save(bytes)
    }
}
