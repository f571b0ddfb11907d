//! Files that belong to floating car data: named in the options that SUMO writes at its beginning, or beside it.

use std::path::{Path, PathBuf};

/// Files of a folder that are looked at.
const MOST: usize = 1000;

/// The values of an option in the comment, as paths from the folder of the file.
fn named(file: &Path, comment: &str, option: &str) -> Vec<PathBuf> {
    let begin = format!("<{option} value=\"");
    let value = comment
        .split(&begin)
        .nth(1)
        .and_then(|rest| rest.split('"').next());
    let folder = file.parent().unwrap_or_else(|| Path::new(""));
    let names = value.unwrap_or_default().split(',').map(str::trim);
    let paths = names.filter(|name| !name.is_empty()).flat_map(|name| {
        // As it was named, and beside the file, where files may have been moved together.
        let plain = Path::new(name).file_name().map(|name| folder.join(name));
        [Some(folder.join(name)), plain]
    });
    let mut found: Vec<PathBuf> = paths.flatten().filter(|path| path.is_file()).collect();
    found.dedup();
    found
}

/// Files beside one whose names end so, by name.
fn beside(file: &Path, end: &str) -> Vec<PathBuf> {
    let folder = file.parent().filter(|f| !f.as_os_str().is_empty());
    let folder = folder.unwrap_or_else(|| Path::new("."));
    let all = folder.read_dir().into_iter().flatten().flatten().take(MOST);
    let paths = all.map(|entry| entry.path());
    let mut found: Vec<PathBuf> = paths
        .filter(|path| path.to_string_lossy().ends_with(end))
        .collect();
    found.sort();
    found
}

/// The net: the one that SUMO was started with, or the only one beside the file, or that of its name.
pub fn net(file: &Path, comment: &str) -> Option<PathBuf> {
    if let Some(named) = named(file, comment, "net-file").into_iter().next() {
        return Some(named);
    }
    let nets = beside(file, ".net.xml");
    if let [only] = &nets[..] {
        return Some(only.clone());
    }
    let name = file.file_name()?.to_string_lossy().into_owned();
    let stem = name.split('.').next()?.to_string();
    nets.into_iter().find(|net| {
        let name = net.file_name().map(|n| n.to_string_lossy().into_owned());
        name.is_some_and(|name| name == format!("{stem}.net.xml"))
    })
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
