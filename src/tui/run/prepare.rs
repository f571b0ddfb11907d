//! Start-up: loads the user's files, finds the experiment of the command line, and reports errors.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::action::Action;
use crate::background::{self, Background};
use crate::keymap::{Keymap, Preset, first_mistake};
use crate::model::{DisplaySettings, Glyphs, MapChoice, Model, Prices};
use crate::pixels::{self, Encoder};
use crate::session::{self, SavedLocation, file, restore};
use crate::terminal;
use crate::theme::{AUTO, ColorDepth, Theme};
use nearmiss_ask::llm::{Environment, Registry};
use nearmiss_ask::prompts::Library;
use nearmiss_base::system::shown_path;
use nearmiss_formats::EgoSelection;
use nearmiss_render::cells::Blocks;
use nearmiss_settings::{Config, Folders, TextFile, ThemeFile};
use nearmiss_workflow::{experiment_among, read_experiment};

/// The model at the start; errors in the user's files are reported, and defaults are used.
pub fn prepare(
    paths: Vec<PathBuf>,
    ego: &EgoSelection,
    index: Option<PathBuf>,
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
    let asks = ThemeFile::pairs().any(|pair| pair == chosen);
    let asked = asks.then(|| std::thread::spawn(move || background::ask(terminal::answers, env)));
    let registry = Registry::lenient(&config.provider, &folders.config_file());
    complaints.extend(registry.broken().map(|(_, why)| why.to_string()));
    let keymap = Keymap::load(&folders.keymap()).unwrap_or_else(|mistakes| {
        complaints.push(format!(
            "{}; the default keys are in use",
            first_mistake(&mistakes)
        ));
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
    let mut background = asked.unwrap_or_else(|| background::of_environment(env));
    let map = MapChoice::of_config(config.map.as_deref());
    let encoder = if pixels::is_worth_asking(map, env) {
        Encoder::ask(terminal::answers, background::ANSWER_TIMEOUT, env)
    } else {
        None
    };
    // An answer may still come.
    background.late |= encoder.is_none() && pixels::is_worth_asking(map, env);
    let theme = Theme::load(&chosen, &folders.themes(), background.dark).unwrap_or_else(|error| {
        complaints.push(format!("{error}; the default colours are in use"));
        Theme::default_for(background.dark)
    });
    let depth = ColorDepth::of_environment(env);
    let glyphs_here = Glyphs::of_environment(env);
    let mut look = DisplaySettings {
        keymap,
        chosen,
        config_file: shown_path(&folders.config_file()),
        themes: Theme::all(&folders.themes()),
        depth,
        dark: background.dark,
        glyphs: Glyphs::of_config(config.glyphs.as_deref(), glyphs_here),
        glyphs_here,
        blocks_here: Blocks::of_environment(env),
        in_tmux: env("TMUX").is_some(),
        ..DisplaySettings::default()
    };
    look.configure_map(&config);
    let mut model = Model::new(paths, config, theme.at_depth(depth), library, offers);
    model.look = look;
    if map == MapChoice::Pixels && encoder.is_none() {
        complaints.push("the terminal shows no images; the map is drawn in cells".into());
    }
    model.map.images.encoder = encoder;
    for note in model.look.keymap.notes.clone() {
        model.tell(note);
    }
    model.compare.person = model.config.person();
    model.driver.forecast = model.config.planning().prediction;
    let planners = model.config.external_planners().into_iter();
    model.driver.planners = planners.map(|(name, _)| name).collect();
    // The seed need not be secret: no one has to predict the order of answers.
    model.compare.seed = jiff::Timestamp::now().as_nanosecond() as u64;
    match nearmiss_settings::read_thresholds(&folders.thresholds()) {
        Ok(thresholds) => model.thresholds = Arc::new(thresholds),
        Err(error) => complaints.push(format!("{error}; the shipped thresholds are in use")),
    }
    let today = jiff::Zoned::now().date();
    model.prompt.prices = Prices::new(registry.clone(), registry.free(&environment), today);
    complaints.extend(take_up_drafts(&mut model, folders));
    take_up_session(&mut model, ego, folders);
    if let Some(folder) = index {
        // The session may come back in another folder.
        model.index.folder = Some(std::path::absolute(&folder).unwrap_or(folder));
    }
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
    let seconds = file::second_drafts(&folders.drafts());
    let told = |path: PathBuf| format!("a second draft, not in use: {}", shown_path(&path));
    let mut complaints: Vec<String> = seconds.into_iter().map(told).collect();
    for (file, draft) in file::read_drafts(&folders.drafts()) {
        let draft = match draft {
            Ok(text) => text,
            Err(error) => {
                complaints.push(format!("{error}; draft skipped"));
                continue;
            }
        };
        let same = model
            .library
            .source(&file)
            .is_some_and(|(text, _)| text.trim_end() == draft.trim_end());
        model.prompt.found.insert(file.clone(), draft.clone());
        if !same {
            files.push(file.clone());
            model.prompt.take_up(file, draft);
        }
    }
    if !files.is_empty() {
        files.sort();
        let [edit, discard] =
            [Action::Edit, Action::DiscardDraft].map(|action| model.look.key(action));
        model.tell(format!(
            "unsaved drafts restored: {}; {edit} edits them, {discard} discards them",
            files.join(", ")
        ));
    }
    complaints
}

/// The scenarios that the workbench lists, and the experiment that it opens if one is named in their place: then those
/// that it asks about, or the bundled ones where the file cannot be used, which its screen says.
///
/// # Errors
/// An experiment file is named beside other paths.
pub fn split_off(paths: Vec<PathBuf>) -> Result<(Vec<PathBuf>, Option<PathBuf>), String> {
    let Some(file) = experiment_among(&paths)?.map(Path::to_path_buf) else {
        return Ok((paths, None));
    };
    let text = TextFile::read(&file).map(|file| file.text);
    let experiment = text.and_then(|text| read_experiment(&text, &file, &Library::load(None)));
    let listed = experiment.map_or_else(|_| Vec::new(), |experiment| experiment.scenarios);
    Ok((listed, Some(file)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn an_experiment_lists_its_scenarios_and_stands_alone() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("e.toml");
        let text = "scenarios = [\"ZAM_CutIn-1_1_T-1\", \"more\"]\nmodels = [\"lab/a\"]\n";
        std::fs::write(&file, text).unwrap();
        let listed = vec![
            PathBuf::from("ZAM_CutIn-1_1_T-1"),
            folder.path().join("more"),
        ];
        let split = |paths: &[&Path]| split_off(paths.iter().map(|p| p.to_path_buf()).collect());
        assert_eq!(split(&[&file]), Ok((listed, Some(file.clone()))));
        let scenario = Path::new("a.xml");
        assert_eq!(split(&[scenario]), Ok((vec![scenario.into()], None)));
        let error = split(&[scenario, &file]).unwrap_err();
        assert!(
            error.contains("e.toml") && error.contains("alone"),
            "{error}"
        );
        std::fs::write(&file, "scenarios = 3").unwrap();
        assert_eq!(split(&[&file]), Ok((Vec::new(), Some(file.clone()))));
    }
}
