//! The loop: drain all messages, draw once if something changed, at most sixty times a second, else sleep.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

use super::message::{Effect, Msg};
use super::model::Model;
use super::tasks::{Remaining, Tasks, thresholds};
use super::terminal::{Events, Screen, give_back_on_panic};
use super::theme::{Depth, Theme};
use super::update::{start, update};
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
    let (mut model, models) = prepare(paths, &folders);
    let mut screen = Screen::take(model.mouse).map_err(|e| the_terminal(&e))?;
    model.size = screen.size().map_err(|e| the_terminal(&e))?;
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
fn prepare(paths: Vec<PathBuf>, folders: &Folders) -> (Model, (Registry, Environment)) {
    let mut complaints = Vec::new();
    let config = Config::read(&folders.config_file()).unwrap_or_else(|error| {
        complaints.push(error.to_string());
        Config::default()
    });
    let registry = Registry::new(&config.providers).unwrap_or_else(|error| {
        complaints.push(error.to_string());
        Registry::new(&toml::Table::new()).unwrap_or_default()
    });
    let name = config.theme.as_deref().unwrap_or("dark");
    let theme = Theme::load(name, &folders.themes()).unwrap_or_else(|error| {
        complaints.push(error);
        Theme::default_theme()
    });
    let env = |name: &str| std::env::var(name).ok();
    let theme = theme.at_depth(Depth::of_environment(env));
    let library = Library::load(Some(&folders.prompts()));
    for problem in &library.problems {
        complaints.push(problem.to_string());
    }
    let environment = Environment::with_files(&[Path::new("."), &folders.config]);
    complaints.extend(environment.problems.iter().cloned());
    let offers = registry.offers(&environment, jiff::Zoned::now().date());
    let mut model = Model::new(paths, config, theme, library, offers);
    match thresholds(&folders.thresholds()) {
        Ok(thresholds) => model.thresholds = Arc::new(thresholds),
        Err(error) => complaints.push(format!("{error}; the shipped thresholds are in use")),
    }
    for (file, draft) in drafts(&folders.drafts()) {
        model.prompt.take_up(file, draft);
    }
    for complaint in complaints {
        model.complain(complaint);
    }
    (model, (registry, environment))
}

/// What an earlier session left in the editor.
fn drafts(folder: &Path) -> Vec<(String, String)> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let read = |path: PathBuf| {
        let name = path
            .file_name()?
            .to_str()
            .filter(|n| n.ends_with(".md"))?
            .to_string();
        Some((name, std::fs::read_to_string(path).ok()?))
    };
    entries.filter_map(|e| read(e.path())).collect()
}

struct Loop {
    model: Model,
    screen: Screen,
    tasks: Tasks,
    receiver: UnboundedReceiver<Msg>,
}

impl Loop {
    async fn until_quit(&mut self) -> std::io::Result<()> {
        let mut events = Events::listen();
        let mut ending = Ending::listen()?;
        let mut passed = Instant::now();
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
                        events = Events::listen();
                        self.model.size = self.screen.size()?;
                        changed = true;
                    }
                    Step::On => {}
                }
            }
            if changed && drawn.elapsed() >= FRAME {
                self.screen.draw(|frame| views::draw(frame, &self.model))?;
                drawn = Instant::now();
                changed = false;
            }
        }
    }

    fn apply(&mut self, msg: Msg) -> std::io::Result<Step> {
        #[cfg(debug_assertions)]
        panic_if_asked(&msg);
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
                Some(Remaining::Quit) => return Ok(Step::Quit),
            }
        }
        Ok(step)
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
