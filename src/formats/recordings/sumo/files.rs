//! Files that belong to floating car data, named in its options or beside it, and which net is meant.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::fcd::Recorded;
use super::net::{self, Net};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::report::Report;

/// Files of a folder that are looked at.
const MAX_FILES: usize = 1000;

/// The values of an option in the comment.
fn values<'c>(comment: &'c str, option: &str) -> impl Iterator<Item = &'c str> + use<'c> {
    let begin = format!("<{option} value=\"");
    let value = comment
        .split(&*begin)
        .nth(1)
        .map(|rest| rest.split('"'))
        .and_then(|mut rest| rest.next())
        .unwrap_or_default();
    let names = value.split(',').map(str::trim);
    names.filter(|name| !name.is_empty())
}

/// The name of a file without its folders, also of a path of Windows.
fn plain(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}

/// The files that an option names and that are there: as they are named from the folder of the file, or beside the file,
/// where files may have been moved together.
fn named_by_option(file: &Path, comment: &str, option: &str) -> Vec<PathBuf> {
    let folder = file.parent().unwrap_or_else(|| Path::new(""));
    let paths = values(comment, option).filter_map(|name| {
        let places = [name, plain(name)].map(|name| folder.join(name));
        places.into_iter().find(|path| path.is_file())
    });
    paths.collect()
}

/// Files beside one whose names end so, by name.
fn siblings_ending_in(file: &Path, end: &str) -> Vec<PathBuf> {
    let folder = file
        .parent()
        .filter(|f| !f.as_os_str().is_empty())
        .unwrap_or_else(|| Path::new("."));
    let all = folder
        .read_dir()
        .into_iter()
        .flatten()
        .flatten()
        .take(MAX_FILES);
    let paths = all.map(|entry| entry.path());
    let mut found: Vec<PathBuf> = paths
        .filter(|path| path.to_string_lossy().ends_with(end))
        .collect();
    found.sort();
    found
}

/// The nets that may be those of a file.
pub enum Nets {
    /// The one that SUMO was started with, or that has the name of the file.
    Told(PathBuf),
    /// Those beside it, none of which is told; and the name of the one that SUMO was started with, if it is known.
    Beside(Vec<PathBuf>, Option<String>),
}

/// The nets of a file.
pub fn nets(file: &Path, comment: &str) -> Nets {
    if let Some(named) = named_by_option(file, comment, "net-file")
        .into_iter()
        .next()
    {
        return Nets::Told(named);
    }
    let nets = siblings_ending_in(file, ".net.xml");
    let name = |path: &Path| path.file_name().map(|n| n.to_string_lossy().into_owned());
    let own = name(file).unwrap_or_default();
    let own = format!("{}.net.xml", own.split('.').next().unwrap_or_default());
    match nets.iter().find(|net| name(net).as_ref() == Some(&own)) {
        Some(net) => Nets::Told(net.clone()),
        None => {
            let started_with = values(comment, "net-file").next();
            Nets::Beside(nets, started_with.map(|name| plain(name).to_string()))
        }
    }
}

/// The files that may define types of vehicles.
pub fn with_types(file: &Path, comment: &str) -> Vec<PathBuf> {
    let mut found = named_by_option(file, comment, "route-files");
    found.extend(named_by_option(file, comment, "additional-files"));
    if found.is_empty() {
        found = siblings_ending_in(file, ".rou.xml");
        found.extend(siblings_ending_in(file, ".add.xml"));
    }
    found
}

/// Names of files, for messages.
pub fn in_words(paths: &[PathBuf]) -> String {
    let names = paths
        .iter()
        .take(MAX_LISTED)
        .filter_map(|path| path.file_name());
    let names: Vec<_> = names.map(|name| name.to_string_lossy()).collect();
    let more = match paths.len() - names.len().min(paths.len()) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("{}{more}", names.join(", "))
}

/// So many files are named in a message.
const MAX_LISTED: usize = 5;

/// The net of a recording: the one that it names, or the one beside it in which its edges are. What is wrong is said.
pub fn net(
    file: &Path,
    recorded: &Recorded,
    report: &Report,
) -> Result<Option<(PathBuf, Arc<Net>)>, ReadError> {
    let (nets, started_with) = match nets(file, &recorded.comment) {
        Nets::Told(net) => {
            let read = net::read(&net)?;
            return Ok(Some((net, read)));
        }
        Nets::Beside(nets, started_with) => (nets, started_with),
    };
    let none = |why: String| {
        report
            .at("")
            .warn(format!("no net: {why}; the scenario has no lanes"));
        Ok(None)
    };
    let used = &recorded.edges;
    match &nets[..] {
        [] => none(match started_with {
            Some(name) => format!("{name}, which it was made with, is not beside it"),
            None => "no .net.xml beside it".into(),
        }),
        [only] => {
            let net = net::read(only)?;
            if used.is_empty() || used.iter().any(|edge| net.edges.contains(edge)) {
                Ok(Some((only.clone(), net)))
            } else {
                none(format!(
                    "{}, the only one beside it, has none of its edges, such as `{}`",
                    in_words(&nets),
                    used.first().map_or("", String::as_str)
                ))
            }
        }
        several => {
            // One that is damaged is none of these.
            let all = several
                .iter()
                .filter_map(|path| Some((path, net::read(path).ok()?)));
            let has_all = |net: &Net| used.iter().all(|edge| net.edges.contains(edge));
            let mut fit: Vec<_> = all
                .filter(|(_, net)| !used.is_empty() && has_all(net))
                .collect();
            if fit.len() == 1
                && let Some((path, net)) = fit.pop()
            {
                report.note(format!(
                    "net {}: the only one of {} beside it that has its edges",
                    path.display(),
                    several.len()
                ));
                return Ok(Some((path.clone(), net)));
            }
            let which = match fit.len() {
                0 => "none of them has",
                _ => "several of them have",
            };
            none(format!(
                "{} .net.xml files are beside it ({}), and {which} all its edges; leave only its own",
                several.len(),
                in_words(several)
            ))
        }
    }
}
