//! Start-up: loads the user's files and reports their errors.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::super::background::{self, Background};
use super::super::keymap::{Keymap, Preset};
use super::super::model::{Glyphs, Look, Model, Prices};
use super::super::session::SavedLocation;
use super::super::session::{self, restore};
use super::super::tasks::thresholds;
use super::super::theme::{AUTO, ColorDepth, Theme};
use super::super::user_file::first;
use crate::evaluation::default_planning;
use crate::formats::EgoSelection;
use crate::llm::{Environment, Registry};
use crate::prompts::Library;
use crate::settings::{Config, Folders};
use crate::system;

/// The model at the start; errors in the user's files are reported, and defaults are used.
pub fn prepare(
    paths: Vec<PathBuf>,
    ego: &EgoSelection,
    folders: &Folders,
) -> (Model, (Registry, Environment), Background) {
    let mut complaints = Vec::new();
    let config = Config::read(&folders.config_file()).unwrap_or_else(|error| {
        complaints.push(error.to_string());
        Config::default()
    });
    let env = |name: &str| std::env::var(name).ok();
    let chosen = config.theme.clone().unwrap_or_else(|| AUTO.into());
    // The terminal takes its time to answer; meanwhile the rest is read.
    let asked = (chosen == AUTO).then(|| std::thread::spawn(move || background::ask(env)));
    let registry = Registry::lenient(&config.providers, &folders.config_file());
    complaints.extend(registry.broken().map(|(_, why)| why.to_string()));
    let keymap = Keymap::load(&folders.keymap()).unwrap_or_else(|mistakes| {
        complaints.push(format!("{}; the default keys are in use", first(&mistakes)));
        Keymap::from_preset(Preset::Default)
    });
    let library = Library::load(Some(&folders.prompts()));
    for problem in &library.problems {
        complaints.push(problem.to_string());
    }
    let environment = Environment::with_files(&[Path::new("."), &folders.config]);
    complaints.extend(environment.problems.iter().cloned());
    let offers = registry.offers(&environment, jiff::Zoned::now().date());
    let asked = asked.and_then(|asking| asking.join().ok());
    let background = asked.unwrap_or_else(|| background::of_environment(env));
    let theme = Theme::load(&chosen, &folders.themes(), background.dark).unwrap_or_else(|error| {
        complaints.push(format!("{error}; the default colours are in use"));
        Theme::default_for(background.dark)
    });
    let depth = ColorDepth::of_environment(env);
    let glyphs_here = Glyphs::of_environment(env);
    let look = Look {
        keymap,
        chosen,
        themes: Theme::all(&folders.themes()),
        depth,
        dark: background.dark,
        glyphs: Glyphs::of_config(config.glyphs.as_deref(), glyphs_here),
        glyphs_here,
        ..Look::default()
    };
    let mut model = Model::new(paths, config, theme.at_depth(depth), library, offers);
    model.look = look;
    for note in model.look.keymap.notes.clone() {
        model.tell(note);
    }
    model.compare.person = model.config.person();
    model.driver.forecast = model.config.planning(default_planning()).forecast;
    // The seed need not be secret: no one has to predict the order of answers.
    model.compare.seed = jiff::Timestamp::now().as_nanosecond() as u64;
    match thresholds(&folders.thresholds()) {
        Ok(thresholds) => model.thresholds = Arc::new(thresholds),
        Err(error) => complaints.push(format!("{error}; the shipped thresholds are in use")),
    }
    model.prompt.prices = Prices::new(registry.clone(), jiff::Zoned::now().date());
    complaints.extend(take_up_drafts(&mut model, folders));
    take_up_session(&mut model, ego, folders);
    for complaint in complaints {
        model.complain(complaint);
    }
    (model, (registry, environment), background)
}

/// Takes up the last session of the same paths, unless the configuration says that sessions are not kept.
fn take_up_session(model: &mut Model, ego: &EgoSelection, folders: &Folders) {
    model.recall.here = std::env::current_dir().unwrap_or_default();
    model.recall.on = model.config.session;
    if !model.recall.on {
        return;
    }
    model.recall.paths = SavedLocation::of_arguments(&model.paths, &model.recall.here);
    match session::file::read(&folders.sessions(), &model.recall.paths) {
        Ok(Some(found)) => restore::restore(model, found, *ego != EgoSelection::Beside),
        Ok(None) => {}
        Err(error) => model.tell(format!("{error}; a new session begins")),
    }
}

/// Restores drafts that an earlier session left in the editor and reports it; returns errors of unreadable ones.
fn take_up_drafts(model: &mut Model, folders: &Folders) -> Vec<String> {
    let mut files = Vec::new();
    let mut complaints = Vec::new();
    for (file, draft) in drafts(&folders.drafts()) {
        let draft = match draft {
            Ok(text) => text,
            Err(error) => {
                complaints.push(format!("{error}; this draft is not taken up"));
                continue;
            }
        };
        let same = model
            .library
            .source(&file)
            .is_some_and(|(text, _)| text.trim_end() == draft.trim_end());
        if !same {
            files.push(file.clone());
            model.prompt.take_up(file, draft);
        }
    }
    if !files.is_empty() {
        files.sort();
        model.tell(format!(
            "drafts that were not saved are in use again: {}; e continues editing, reset-template discards them",
            files.join(", ")
        ));
    }
    complaints
}

/// Drafts that an earlier session left in the editor, by file; or why they cannot be read.
fn drafts(folder: &Path) -> Vec<(String, Result<String, String>)> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let read = |path: PathBuf| {
        let name = path
            .file_name()?
            .to_str()
            .filter(|n| n.ends_with(".md"))?
            .to_string();
        let text = system::read_text(&path, system::LARGEST_TEXT);
        let text = text.map_err(|e| format!("{}: {}", path.display(), system::words(&e)));
        Some((name, text))
    };
    entries.filter_map(|e| read(e.path())).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_draft_that_cannot_be_read_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("a.md"), "as it was").unwrap();
        std::fs::create_dir(path("b.md")).unwrap();
        std::fs::write(path("c.md"), vec![b'a'; 1 + (1 << 20)]).unwrap();
        std::fs::write(path("d.txt"), "something else").unwrap();
        let mut found = drafts(folder.path());
        found.sort();
        assert_eq!(found[0], ("a.md".to_string(), Ok("as it was".to_string())));
        let error = |i: usize| found[i].1.clone().unwrap_err();
        assert!(
            error(1).contains("b.md") && error(1).contains("folder"),
            "{found:?}"
        );
        assert!(error(2).contains("larger than 1 MiB"));
        assert_eq!(found.len(), 3);
    }
}
