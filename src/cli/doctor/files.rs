//! Checks the user's files: folders, configuration, keys, thresholds, prompts, themes and tags.

use std::path::{Path, PathBuf};

use super::Finding;
use crate::Workbench;
use crate::open::user_thresholds;
use nearmiss_ask::prompts::Library;
use nearmiss_base::system::others_may;
use nearmiss_settings::{Config, Folders, Tags};

/// The configuration, or the defaults, and what is to be said of it.
pub fn config(folders: &Folders) -> (Config, Vec<Finding>) {
    let path = folders.config_file();
    let shown = path.display();
    let (config, mistakes) = super::usable(Config::read(&path));
    let todo = "commands stop and the workbench uses the defaults until this is fixed";
    let each = mistakes.into_iter();
    let mut said: Vec<Finding> = each
        .map(|mistake| Finding::problem("config", mistake, todo))
        .collect();
    if said.is_empty() {
        let words = if path.exists() {
            format!("{shown} is valid; `nearmiss config print` shows the values in force")
        } else {
            format!("defaults (no {shown})")
        };
        said.push(Finding::ok("config", words));
    }
    (config, said)
}

/// Files that decide what is run and what it costs, and that other users can change or read: each with what to do.
pub fn open_to_others(folders: &Folders) -> Vec<(String, String)> {
    let config = folders.config_file();
    let mut found = Vec::new();
    if others_may(&config).write {
        let folder = folders.config.display();
        found.push((
            format!(
                "{}: other users can change it, and commands in it (`key_command`) are run",
                config.display()
            ),
            format!("close it with `chmod go-w {folder} {}`", config.display()),
        ));
    }
    for file in [PathBuf::from(".env"), folders.config.join(".env")] {
        if others_may(&file).read {
            let shown = file.display();
            found.push((
                format!("{shown}: other users can read the keys in it"),
                format!("close it with `chmod 600 {shown}`"),
            ));
        }
    }
    found
}

pub fn look(folders: &Folders, config: &Config, workbench: &Workbench) -> Vec<Finding> {
    let mut found = vec![
        folder("configuration", &folders.config, "NEARMISS_CONFIG"),
        folder("data", &folders.data, "NEARMISS_DATA"),
    ];
    let open = open_to_others(folders).into_iter();
    found.extend(open.map(|(what, todo)| Finding::warning("folders", what, todo)));
    found.extend(keys(folders, workbench));
    found.push(match user_thresholds(folders) {
        Err(failure) => Finding::problem(
            "thresholds",
            failure.message,
            "fix it or move the file away",
        ),
        Ok(_) => own_or_shipped(
            "thresholds",
            &folders.thresholds(),
            "the shipped thresholds",
        ),
    });
    found.extend(prompts(folders));
    found.extend(themes(folders, config, workbench));
    if let Err(error) = Tags::read(&folders.tags()) {
        found.push(Finding::problem(
            "tags",
            error,
            "fix it or move the file away",
        ));
    }
    found
}

fn own_or_shipped(area: &'static str, path: &Path, shipped: &str) -> Finding {
    if path.exists() {
        Finding::ok(area, format!("{} is valid", path.display()))
    } else {
        Finding::ok(area, format!("{shipped} (no {})", path.display()))
    }
}

/// Whether something can be written into a folder, or it can be made.
fn folder(what: &str, path: &Path, variable: &str) -> Finding {
    const AREA: &str = "folders";
    let shown = path.display();
    let set = std::env::var_os(variable).is_some_and(|value| !value.is_empty());
    let from = if set { variable } else { "the usual place" };
    let there = path.ancestors().find(|folder| folder.exists());
    let Some(there) = there.filter(|there| !there.as_os_str().is_empty()) else {
        let there = Path::new(".");
        return written(what, there, &format!("{shown} ({from})"), variable);
    };
    let words = if there == path {
        format!("{shown} ({from})")
    } else {
        format!("{shown} ({from}): created on first use")
    };
    if !there.is_dir() {
        let file = there.display();
        return Finding::problem(
            AREA,
            format!("{what}: {shown} cannot be a folder, {file} is a file"),
            format!("set {variable} to a folder"),
        );
    }
    written(what, there, &words, variable)
}

fn written(what: &str, there: &Path, words: &str, variable: &str) -> Finding {
    match tempfile::tempfile_in(there) {
        Ok(_) => Finding::ok("folders", format!("{what}: {words}")),
        Err(error) => Finding::problem(
            "folders",
            format!(
                "{what}: {words}: not writable: {}",
                nearmiss_base::system::error_text(&error)
            ),
            format!("make it writable, or set {variable} to another folder"),
        ),
    }
}

fn keys(folders: &Folders, workbench: &Workbench) -> Vec<Finding> {
    let path = folders.keymap();
    match (workbench.keys)(&path, None, false) {
        Ok(_) => vec![own_or_shipped("keys", &path, "the default keys")],
        Err(mistakes) => {
            let todo = "the default keys are in use until this is fixed";
            let each = mistakes.into_iter();
            each.map(|mistake| Finding::problem("keys", mistake, todo))
                .collect()
        }
    }
}

fn prompts(folders: &Folders) -> Vec<Finding> {
    let library = Library::load(Some(&folders.prompts()));
    if library.problems.is_empty() {
        let words = "all templates are valid; `nearmiss prompt list` lists them";
        return vec![Finding::ok("prompts", words)];
    }
    let problems = library.problems.iter();
    let todo = "fix it or move the file away; `nearmiss prompt list` lists what is in use";
    problems
        .map(|problem| Finding::problem("prompts", problem.to_string(), todo))
        .collect()
}

fn themes(folders: &Folders, config: &Config, workbench: &Workbench) -> Vec<Finding> {
    let chosen = config.theme.as_deref().unwrap_or("auto");
    let mistakes = (workbench.theme_mistakes)(chosen, &folders.themes());
    if mistakes.is_empty() {
        return vec![Finding::ok("themes", format!("`{chosen}` is valid"))];
    }
    let todo = "fix it or choose another theme; `nearmiss config themes` lists them";
    let each = mistakes.into_iter();
    each.map(|mistake| Finding::problem("themes", mistake, todo))
        .collect()
}
