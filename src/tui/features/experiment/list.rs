//! Chooser of experiment files: those opened before and those of the working folder, a typed path, and new ones.

use std::path::{MAIN_SEPARATOR, Path, PathBuf};

use ratatui::Frame;
use ratatui::layout::Rect;

use crate::action::Action;
use crate::features::experiment::request::ListExperiments;
use crate::features::{Screen, Step};
use crate::keymap::{Code, Key, edit_line, first_line};
use crate::message::Effect;
use crate::model::{Model, Picker, matching};
use crate::widgets::hints::{Hint, fixed};
use crate::widgets::{picker, window};
use nearmiss_scene::description::visible;

/// The chooser.
#[derive(Debug, Default)]
pub struct ExperimentsScreen {
    picker: Picker,
    /// Whether the name of a new file is typed.
    naming: bool,
    /// Whether it was opened for that alone.
    only_naming: bool,
    /// The folder that was asked for last.
    asked: Option<PathBuf>,
}

/// A line of the list.
#[derive(Debug, Clone, PartialEq)]
enum Row {
    /// A file to open, and what is known of it.
    File(PathBuf, String),
    /// A folder to look into.
    Folder(PathBuf),
    /// The typed path.
    Typed(PathBuf),
    /// A new file from the marked scenarios.
    New,
}

/// The name that a new file gets if none is typed.
const NEW_NAME: &str = "experiment.toml";

/// Opens the chooser.
pub fn open(model: &mut Model) -> Vec<Effect> {
    model.experiment.exists = None;
    let mut screen = ExperimentsScreen::default();
    let list = screen.list();
    model.screens.open(screen);
    list
}

/// Opens the line for the name of a new file.
pub fn open_new(model: &mut Model) -> Vec<Effect> {
    let list = open(model);
    let mut screen = ExperimentsScreen {
        asked: Some(PathBuf::new()),
        only_naming: true,
        ..ExperimentsScreen::default()
    };
    screen.name_new();
    model.screens.open(screen);
    list
}

impl Screen for ExperimentsScreen {
    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        let selected = self.rows(model).into_iter().nth(self.picker.selected);
        match key.code {
            Code::Esc => return Some(self.on_action(model, Action::Cancel)),
            Code::Enter if self.naming => return Some(self.write(model)),
            Code::Enter => return Some(self.choose(model, selected)),
            Code::Up => self.picker.selected = self.picker.selected.saturating_sub(1),
            Code::Down => self.picker.selected += 1,
            Code::Tab if !self.naming => self.complete(model, selected),
            _ if edit_line(&mut self.picker.text, key) => {
                self.picker.selected = 0;
                model.experiment.exists = None;
            }
            _ => {}
        }
        Some(Step::stay())
    }

    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        if action != Action::Cancel {
            return Step::Ignored;
        }
        if model.experiment.exists.take().is_some() {
            return Step::stay();
        }
        if self.naming && !self.only_naming {
            self.naming = false;
            self.picker = Picker::default();
            return Step::stay();
        }
        Step::close()
    }

    fn paste(&mut self, model: &mut Model, text: &str) -> Vec<Effect> {
        self.picker.text.push_str(&first_line(text));
        self.picker.selected = 0;
        model.experiment.exists = None;
        Vec::new()
    }

    fn follow(&mut self, model: &mut Model) -> Vec<Effect> {
        let last = self.rows(model).len().saturating_sub(1);
        self.picker.selected = self.picker.selected.min(last);
        if self.naming { Vec::new() } else { self.list() }
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let title = if self.naming {
            "new experiment: name of the file"
        } else {
            "experiments"
        };
        let inner = window::window(frame, screen, model, title, (100, 22));
        let here = &model.recall.here;
        let rows: Vec<(String, String)> = if self.naming {
            Vec::new()
        } else {
            let rows = self.rows(model).into_iter();
            rows.map(|row| row_texts(&row, here, model)).collect()
        };
        if self.naming {
            let typed = picker::typed(model, &self.picker, 0, usize::from(inner.width));
            frame.render_widget(typed, inner);
        } else {
            picker::draw(frame, inner, model, &self.picker, &rows);
        }
        if let Some(hint) = self.hint(model) {
            picker::hint(frame, inner, model, &visible(&hint));
        }
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        match (self.naming, &model.experiment.exists) {
            (true, Some(_)) => fixed(&[("Enter", "replace"), ("Esc", "keep it")]),
            (true, None) => fixed(&[("type", "a file name"), ("Enter", "write"), ("Esc", "back")]),
            (false, _) => fixed(&[
                ("type", "a name or path"),
                ("↑↓", "select"),
                ("Tab", "complete"),
                ("Enter", "open"),
                ("Esc", "close"),
            ]),
        }
    }
}

impl ExperimentsScreen {
    /// Asks for the name of a new file.
    fn name_new(&mut self) {
        self.naming = true;
        self.picker = Picker {
            text: NEW_NAME.into(),
            selected: 0,
        };
    }

    /// The folder of the typed path; empty for the working folder.
    fn folder(&self) -> PathBuf {
        let typed = &self.picker.text;
        match typed.rfind(MAIN_SEPARATOR) {
            Some(end) => PathBuf::from(&typed[..=end]),
            None => PathBuf::new(),
        }
    }

    /// Asks for what is in the folder of the typed path, if that is another one than before.
    fn list(&mut self) -> Vec<Effect> {
        let folder = self.folder();
        if self.asked.as_ref() == Some(&folder) {
            return Vec::new();
        }
        self.asked = Some(folder.clone());
        vec![ListExperiments(folder).into()]
    }

    fn rows(&self, model: &Model) -> Vec<Row> {
        let typed = self.picker.text.trim();
        let here = &model.recall.here;
        let mut rows: Vec<Row> = if typed.contains(MAIN_SEPARATOR) {
            self.below(model)
        } else {
            let offers = model.experiment.offers(here);
            let texts = offers.iter().map(|(path, about)| {
                let path = path.strip_prefix(here).unwrap_or(path);
                format!("{} {about}", path.display())
            });
            let found = matching(typed, texts);
            let file = |place: usize| Row::File(offers[place].0.clone(), offers[place].1.clone());
            found.into_iter().map(file).collect()
        };
        let path = here.join(typed);
        let is_listed = rows
            .iter()
            .any(|row| matches!(row, Row::File(p, _) if *p == path));
        if typed.ends_with(".toml") && !is_listed {
            rows.push(Row::Typed(path));
        }
        if typed.is_empty() || "new from the marked scenarios".contains(typed) {
            rows.push(Row::New);
        }
        rows
    }

    /// Files and folders whose paths begin as is typed.
    fn below(&self, model: &Model) -> Vec<Row> {
        let Some((folder, Ok(listed))) = &model.experiment.folder else {
            return Vec::new();
        };
        if *folder != self.folder() {
            return Vec::new();
        }
        let begin = self.picker.text[folder.as_os_str().len()..].to_lowercase();
        let begins = |path: &Path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.to_lowercase().starts_with(&begin)
        };
        let here = &model.recall.here;
        let files = listed
            .files
            .iter()
            .filter(|file| begins(&file.path))
            .map(|file| {
                let title = file.title.clone().unwrap_or_default();
                Row::File(here.join(&file.path), title)
            });
        let folders = listed.folders.iter().filter(|path| begins(path));
        files
            .chain(folders.map(|path| Row::Folder(path.clone())))
            .collect()
    }

    /// Completes the typed path to the selected one.
    fn complete(&mut self, model: &Model, selected: Option<Row>) {
        let here = &model.recall.here;
        let path = match selected {
            Some(Row::File(path, _) | Row::Typed(path)) => {
                let below = path.strip_prefix(here).unwrap_or(&path);
                below.display().to_string()
            }
            Some(Row::Folder(path)) => format!("{}{MAIN_SEPARATOR}", path.display()),
            Some(Row::New) | None => return,
        };
        self.picker.text = path;
        self.picker.selected = 0;
    }

    fn choose(&mut self, model: &mut Model, selected: Option<Row>) -> Step {
        match selected {
            Some(Row::File(path, _) | Row::Typed(path)) => {
                model.experiment.chosen = Some(path);
                Step::CloseAndPerform(Action::Experiment)
            }
            Some(row @ Row::Folder(_)) => {
                self.complete(model, Some(row));
                Step::stay()
            }
            Some(Row::New) => {
                self.name_new();
                Step::stay()
            }
            None => Step::stay(),
        }
    }

    /// Writes the new file; one that is there already is replaced by the second press.
    fn write(&mut self, model: &mut Model) -> Step {
        let typed = self.picker.text.trim();
        if typed.is_empty() {
            model.say("type the name of the file");
            return Step::stay();
        }
        let mut path = model.recall.here.join(typed);
        if path.extension().is_none_or(|end| end != "toml") {
            let mut name = path.into_os_string();
            name.push(".toml");
            path = PathBuf::from(name);
        }
        model.experiment.chosen = Some(path);
        Step::Perform(Action::NewExperiment)
    }

    fn hint(&self, model: &Model) -> Option<String> {
        if let Some(file) = &model.experiment.exists {
            return Some(format!(
                "{} is there already: Enter again replaces it, Esc keeps it",
                nearmiss_base::system::shown_path(file)
            ));
        }
        if self.naming {
            let working = model.experiment.writing.map(|_| "writing…".to_string());
            return working.or_else(|| Some(asks(model)));
        }
        match &model.experiment.folder {
            Some((_, Err(error))) => Some(error.clone()),
            _ => None,
        }
    }
}

/// What a new experiment would ask, in words.
fn asks(model: &Model) -> String {
    let (count, which) = match model.marks.count(&model.list) {
        0 => (model.list.visible.len(), "listed"),
        marked => (marked, "marked"),
    };
    format!(
        "asks {} about the {count} {which} scenarios: {} · {} · {}; edit the file for more",
        model.model,
        model.task.name(),
        model.frame.name(),
        model.decided().techniques
    )
}

/// A row in words, with what stands at its right.
fn row_texts(row: &Row, here: &Path, model: &Model) -> (String, String) {
    let short = |path: &Path| {
        let below = path.strip_prefix(here).unwrap_or(path);
        visible(&below.display().to_string()).into_owned()
    };
    match row {
        Row::File(path, about) => (
            short(path),
            visible(about.trim_end_matches(" · ")).into_owned(),
        ),
        Row::Folder(path) => (format!("{}{MAIN_SEPARATOR}", short(path)), "folder".into()),
        Row::Typed(path) => (format!("open {}", short(path)), "typed".into()),
        Row::New => {
            let marked = model.marks.count(&model.list);
            let right = match marked {
                0 => format!("none marked: all {} listed", model.list.visible.len()),
                marked => format!("{marked} marked"),
            };
            ("new from the marked scenarios…".into(), right)
        }
    }
}
