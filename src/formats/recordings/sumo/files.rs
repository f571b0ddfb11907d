//! Files that belong to floating car data: named in the options that SUMO writes at its beginning, or beside it.

use std::path::{Path, PathBuf};

/// Files of a folder that are looked at.
const MOST: usize = 1000;

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
fn named(file: &Path, comment: &str, option: &str) -> Vec<PathBuf> {
    let folder = file.parent().unwrap_or_else(|| Path::new(""));
    let paths = values(comment, option).filter_map(|name| {
        let places = [name, plain(name)].map(|name| folder.join(name));
        places.into_iter().find(|path| path.is_file())
    });
    paths.collect()
}

/// Files beside one whose names end so, by name.
fn beside(file: &Path, end: &str) -> Vec<PathBuf> {
    let folder = file
        .parent()
        .filter(|f| !f.as_os_str().is_empty())
        .unwrap_or_else(|| Path::new("."));
    let all = folder.read_dir().into_iter().flatten().flatten().take(MOST);
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
    if let Some(named) = named(file, comment, "net-file").into_iter().next() {
        return Nets::Told(named);
    }
    let nets = beside(file, ".net.xml");
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
    let mut found = named(file, comment, "route-files");
    found.extend(named(file, comment, "additional-files"));
    if found.is_empty() {
        found = beside(file, ".rou.xml");
        found.extend(beside(file, ".add.xml"));
    }
    found
}

/// Names of files, for messages.
pub fn in_words(paths: &[PathBuf]) -> String {
    let names = paths.iter().take(NAMED).filter_map(|path| path.file_name());
    let names: Vec<_> = names.map(|name| name.to_string_lossy()).collect();
    let more = match paths.len() - names.len().min(paths.len()) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("{}{more}", names.join(", "))
}

/// So many files are named in a message.
const NAMED: usize = 5;
