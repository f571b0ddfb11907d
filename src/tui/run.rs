//! The loop: drain all messages, draw once if something changed, at most sixty times a second, else sleep.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

use super::background::{self, Background};
use super::keymap::{Keymap, Preset};
use super::message::{Effect, Msg, Outside};
use super::model::{Glyphs, Look, Model, Prices};
use super::outside;
use super::reload::{self, Stamps};
use super::tasks::{Remaining, Tasks, thresholds};
use super::terminal::{Events, Screen, give_back_on_panic};
use super::theme::{AUTO, Depth, Theme};
use super::update::{start, update};
use super::user_file::first;
use super::{screen, views, widgets};
use crate::config::{Config, Folders};
use crate::llm::{Environment, Registry};
use crate::prompts::Library;
use crate::scenario::{Entry, Place, WantedEgo, not_standard_input};
use crate::store::Store;
use crate::system;

/// Why the workbench ended.
pub type Ended = Result<(), String>;

/// Least time between two frames.
const FRAME: Duration = Duration::from_micros(16_667);

/// Runs the workbench on the scenarios at `paths`, or on the bundled ones, with this ego.
///
/// # Errors
/// A path is not there; the terminal cannot be taken, or went away.
pub fn run(paths: Vec<PathBuf>, ego: WantedEgo) -> Ended {
    // Better said on the shell, where the mistake was made.
    for path in &paths {
        not_standard_input(path).map_err(|error| error.to_string())?;
        if let Place::File(file) = Entry::of_argument(path).place {
            file.metadata()
                .map_err(|error| format!("{}: {}", file.display(), system::words(&error)))?;
        }
    }
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .map_err(|e| system::words(&e))?;
    let ended = runtime.block_on(workbench(paths, ego));
    // Files that are still being read do not keep the program from ending.
    runtime.shutdown_background();
    ended
}

fn the_terminal(error: &std::io::Error) -> String {
    format!("the terminal: {}", system::words(error))
}

async fn workbench(paths: Vec<PathBuf>, ego: WantedEgo) -> Ended {
    give_back_on_panic();
    let folders = Folders::find()?;
    let stamps = Stamps::of(&folders);
    let (mut model, models, background) = prepare(paths, &folders);
    let mut screen = Screen::take(model.mouse).map_err(|e| the_terminal(&e))?;
    model.size = screen.size().map_err(|e| the_terminal(&e))?;
    model.camera.shape_cells(screen.cell_aspect());
    screen
        .draw(|frame| views::draw(frame, &model))
        .map_err(|e| the_terminal(&e))?;
    std::thread::spawn(widgets::highlight::load);

    let store = match Store::open(&folders.store()) {
        Ok(store) => Some(Arc::new(store)),
        Err(error) => {
            model.complain(format!("runs are not kept: {error}"));
            None
        }
    };
    let (sender, receiver) = unbounded_channel();
    tokio::spawn(reload::watch(folders.clone(), stamps, sender.clone()));
    let tasks = Tasks::new(
        sender,
        folders,
        models,
        &model.config,
        model.thresholds.clone(),
        store,
        ego,
    );
    let mut looping = Loop {
        model,
        screen,
        tasks,
        receiver,
        stray: background.late,
    };
    let effects = start(&looping.model);
    if looping.perform(effects).map_err(|e| the_terminal(&e))? {
        return Ok(());
    }
    let ended = looping.until_quit().await;
    looping.tasks.finish().await;
    ended.map_err(|e| the_terminal(&e))
}

/// The model at the start; what is wrong with the user's files is said, and the defaults are used.
fn prepare(paths: Vec<PathBuf>, folders: &Folders) -> (Model, (Registry, Environment), Background) {
    let mut complaints = Vec::new();
    let config = Config::read(&folders.config_file()).unwrap_or_else(|error| {
        complaints.push(error.to_string());
        Config::default()
    });
    let env = |name: &str| std::env::var(name).ok();
    let chosen = config.theme.clone().unwrap_or_else(|| AUTO.into());
    // The terminal takes its time to answer; meanwhile the rest is read.
    let asked = (chosen == AUTO).then(|| std::thread::spawn(move || background::ask(env)));
    let registry = Registry::new(&config.providers).unwrap_or_else(|error| {
        complaints.push(error.to_string());
        Registry::new(&toml::Table::new()).unwrap_or_default()
    });
    let keymap = Keymap::load(&folders.keymap()).unwrap_or_else(|mistakes| {
        complaints.push(format!("{}; the default keys are in use", first(&mistakes)));
        Keymap::of(Preset::Default)
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
    let depth = Depth::of_environment(env);
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
    model.compare.person = model.config.person();
    // Nobody needs to foresee the orders that answers are shown in.
    model.compare.seed = jiff::Timestamp::now().as_nanosecond() as u64;
    match thresholds(&folders.thresholds()) {
        Ok(thresholds) => model.thresholds = Arc::new(thresholds),
        Err(error) => complaints.push(format!("{error}; the shipped thresholds are in use")),
    }
    model.prompt.prices = Prices::new(registry.clone(), jiff::Zoned::now().date());
    complaints.extend(take_up_drafts(&mut model, folders));
    for complaint in complaints {
        model.complain(complaint);
    }
    (model, (registry, environment), background)
}

/// Takes up what an earlier session left in the editor, and says so; gives back what cannot be read.
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
            "drafts that were not saved are in use again: {}; e goes on with them, reset-template discards them",
            files.join(", ")
        ));
    }
    complaints
}

/// What an earlier session left in the editor, by file; or why it cannot be read.
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

struct Loop {
    model: Model,
    screen: Screen,
    tasks: Tasks,
    receiver: UnboundedReceiver<Msg>,
    /// Whether the terminal may still answer what it was asked before the start.
    stray: bool,
}

impl Loop {
    async fn until_quit(&mut self) -> std::io::Result<()> {
        let mut events = Events::listen(self.stray);
        let mut ending = Ending::listen()?;
        let begun = Instant::now();
        let mut passed = begun;
        let mut drawn = Instant::now();
        let mut changed = true;
        loop {
            let wait = match (changed, self.model.moves()) {
                (true, _) => Some(FRAME.saturating_sub(drawn.elapsed())),
                (false, true) => Some(FRAME * 2),
                (false, false) => None,
            };
            let first = tokio::select! {
                event = events.next() => match event {
                    Some(event) => Some(event?),
                    None => return Ok(()),
                },
                msg = self.receiver.recv() => msg,
                () = ending.wait() => Some(Msg::Terminate),
                () = sleep(wait) => None,
            };
            let mut msgs: Vec<Msg> = first.into_iter().collect();
            while let Ok(msg) = self.receiver.try_recv() {
                msgs.push(msg);
            }
            let elapsed = passed.elapsed();
            self.model.uptime = begun.elapsed();
            passed = Instant::now();
            // What rested until now did not age.
            if self.model.moves() && elapsed < Duration::from_secs(1) {
                msgs.push(Msg::Passed(elapsed));
            }
            for msg in msgs {
                changed = true;
                let suspends = self.apply(msg)?;
                match suspends {
                    Step::Quit => return Ok(()),
                    Step::Suspend => {
                        // The event stream would read the shell's keys.
                        drop(events);
                        self.screen.suspend()?;
                        events = Events::listen(false);
                        self.model.size = self.screen.size()?;
                        changed = true;
                    }
                    Step::EditOutside(sent) => {
                        let result = match outside::command(|name| std::env::var(name).ok()) {
                            Ok(command) => {
                                drop(events);
                                let result = self.lend(&command, &sent)?;
                                events = Events::listen(false);
                                self.model.size = self.screen.size()?;
                                result
                            }
                            Err(why) => Err(why),
                        };
                        // What it asks for needs no terminal.
                        for effect in update(&mut self.model, Msg::EditedOutside(sent, result)) {
                            self.tasks.perform(effect);
                        }
                        changed = true;
                    }
                    Step::On => {}
                }
            }
            if changed && drawn.elapsed() >= FRAME {
                self.apply(Msg::Drawing)?;
                self.screen.draw(|frame| views::draw(frame, &self.model))?;
                drawn = Instant::now();
                changed = false;
            }
        }
    }

    fn apply(&mut self, msg: Msg) -> std::io::Result<Step> {
        #[cfg(debug_assertions)]
        panic_if_asked(&msg);
        if matches!(msg, Msg::Resize(..)) {
            // Another font has other cells.
            self.model.camera.shape_cells(self.screen.cell_aspect());
        }
        let effects = update(&mut self.model, msg);
        let mut step = Step::On;
        for effect in effects {
            match self.tasks.perform(effect) {
                None => {}
                Some(Remaining::Copy(text)) => self.screen.copy(&text)?,
                Some(Remaining::Picture(mut job)) => {
                    job.screen = screen::paint(&self.model).map(Some);
                    self.tasks.draw(job);
                }
                Some(Remaining::UseMouse(on)) => self.screen.use_mouse(on)?,
                Some(Remaining::Suspend) => step = Step::Suspend,
                Some(Remaining::EditOutside(outside)) => step = Step::EditOutside(outside),
                Some(Remaining::Quit) => return Ok(Step::Quit),
            }
        }
        Ok(step)
    }

    /// Lends the terminal to the user's editor.
    fn lend(
        &mut self,
        command: &[String],
        sent: &Outside,
    ) -> std::io::Result<Result<String, String>> {
        self.screen
            .lend(|| outside::edit(command, &sent.file, &sent.text))
    }

    /// Performs the effects of the start; says whether the program ends at once.
    fn perform(&mut self, effects: Vec<Effect>) -> std::io::Result<bool> {
        let mut quit = false;
        for effect in effects {
            quit |= matches!(self.tasks.perform(effect), Some(Remaining::Quit));
        }
        Ok(quit)
    }
}

enum Step {
    On,
    Suspend,
    EditOutside(Outside),
    Quit,
}

async fn sleep(wait: Option<Duration>) {
    match wait {
        Some(wait) => tokio::time::sleep(wait).await,
        None => std::future::pending().await,
    }
}

/// The signals that ask the program to end.
struct Ending {
    #[cfg(unix)]
    terminate: tokio::signal::unix::Signal,
    #[cfg(unix)]
    hang_up: tokio::signal::unix::Signal,
}

impl Ending {
    #[cfg(unix)]
    fn listen() -> std::io::Result<Self> {
        use tokio::signal::unix::{SignalKind, signal};
        Ok(Self {
            terminate: signal(SignalKind::terminate())?,
            hang_up: signal(SignalKind::hangup())?,
        })
    }

    #[cfg(unix)]
    async fn wait(&mut self) {
        tokio::select! {
            _ = self.terminate.recv() => {}
            _ = self.hang_up.recv() => {}
        }
    }

    #[cfg(not(unix))]
    fn listen() -> std::io::Result<Self> {
        Ok(Self {})
    }

    #[cfg(not(unix))]
    async fn wait(&mut self) {
        std::future::pending().await
    }
}

/// Lets a test see that a panic gives the terminal back.
#[cfg(debug_assertions)]
fn panic_if_asked(msg: &Msg) {
    use super::keymap::{Code, Key};
    let asked = matches!(msg, Msg::Key(key) if *key == Key::plain(Code::Function(12)));
    assert!(
        !(asked && std::env::var_os("NEARMISS_TEST_PANIC").is_some()),
        "a test asked for this panic"
    );
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
