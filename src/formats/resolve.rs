//! The path that an argument means: a file, or a bundled scenario by the beginning of its name.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::address::{self, Address};
use super::{bundled, commonroad, dispatch};
use nearmiss_base::system::{available, did_you_mean};

/// The path that an argument means: itself, or the bundled scenario whose name begins so, if it is the only one.
///
/// # Errors
/// There is no such file or scenario, with what was probably meant; or several scenarios begin so: in words.
pub fn resolved(argument: &Path) -> Result<PathBuf, String> {
    let missing = matches!(argument.symlink_metadata(), Err(e) if e.kind() == ErrorKind::NotFound);
    let is_part = || Address::of(argument).part.is_some();
    if !missing || argument == Path::new("-") || is_part() {
        return Ok(argument.to_path_buf());
    }
    let names: Vec<String> = bundled().into_iter().map(|e| e.name).collect();
    let said = argument.to_string_lossy();
    let wanted = said.to_lowercase();
    let begin = |name: &&String| !wanted.is_empty() && name.to_lowercase().starts_with(&wanted);
    let found: Vec<&String> = names.iter().filter(begin).collect();
    match &found[..] {
        _ if names.iter().any(|name| *name == said) => Ok(argument.to_path_buf()),
        [name] => Ok(PathBuf::from(name)),
        [] if let Some(window) = window_named(argument) => Ok(window),
        [] => Err(format!(
            "{}: no such file or bundled scenario{}",
            argument.display(),
            instead(argument, &names)
        )),
        several => {
            let first: Vec<&str> = several.iter().take(SUGGESTED).map(|n| n.as_str()).collect();
            let more = several.len() - first.len();
            let more = match more {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            Err(format!(
                "{}: ambiguous; matches {}{more}",
                argument.display(),
                first.join(", ")
            ))
        }
    }
}

/// The window of a recording that lists call so: `fcd-track-6-79.2s` is `fcd.xml#track=6@79.2s`.
fn window_named(argument: &Path) -> Option<PathBuf> {
    let wanted = argument.file_name()?.to_str()?;
    let folder = argument
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let files = folder.unwrap_or_else(|| Path::new(".")).read_dir().ok()?;
    let names = files
        .flatten()
        .take(MOST_FILES)
        .map(|file| file.file_name());
    names.into_iter().find_map(|name| {
        let file = argument.with_file_name(name);
        let stem = address::plain_name(&commonroad::scenario_name(&file));
        let window = wanted.strip_prefix(&stem)?.strip_prefix("-track-")?;
        let timed = window.rsplit_once('-').filter(|(_, time)| is_time(time));
        let part = match timed {
            Some((track, time)) => format!("track={track}@{time}"),
            None => format!("track={window}"),
        };
        dispatch::is_recording(&file).then(|| Address::path(&file, &part))
    })
}

/// Whether a text is a time such as `79.2s`.
fn is_time(text: &str) -> bool {
    let seconds = text.strip_suffix('s').map(str::parse::<f64>);
    seconds.is_some_and(|seconds| seconds.is_ok())
}

/// Scenarios that are named where several begin alike.
const SUGGESTED: usize = 3;

/// What is called nearly like a path that does not exist: bundled scenarios, or files in its folder.
fn instead(path: &Path, bundled: &[String]) -> String {
    let Some(folder) = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
    else {
        return available(&path.to_string_lossy(), bundled.iter().map(String::as_str));
    };
    let files = folder
        .read_dir()
        .into_iter()
        .flatten()
        .flatten()
        .map(|file| file.file_name().to_string_lossy().into_owned());
    let files: Vec<String> = files.take(MOST_FILES).collect();
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    did_you_mean(&name, files.iter().map(String::as_str))
}

/// Files of a folder that are compared with a name.
const MOST_FILES: usize = 10_000;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn the_name_of_a_window_means_its_address() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("fcd.xml"), "<fcd-export>").unwrap();
        std::fs::write(at("other.xml"), "<net>").unwrap();
        for (name, address) in [
            ("fcd-track-6-79.2s", "fcd.xml#track=6@79.2s"),
            ("fcd-track-a-b", "fcd.xml#track=a-b"),
        ] {
            assert_eq!(resolved(&at(name)), Ok(at(address)));
        }
        assert!(resolved(&at("other-track-6-79.2s")).is_err());
        assert!(resolved(&at("fcd-6")).is_err());
    }
}
