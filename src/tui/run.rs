//! The loop: drain all messages, draw once if something changed, at most sixty times a second but for keys, else sleep.

mod ending;
mod pace;
mod prepare;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

use self::ending::Ending;
use self::pace::Pace;
use self::prepare::prepare;
use super::message::{Effect, Msg, Outside};
use super::model::Model;
use super::outside;
use super::reload::{self, Stamps};
use super::tasks::{Remaining, Tasks, session};
use super::terminal::{Events, Screen, give_back_on_panic};
use super::update::{start, update};
use super::{screen, views, widgets};
use crate::config::Folders;
use crate::scenario::{Entry, Place, WantedEgo, not_standard_input};
use crate::store::{Filter, Store};
use crate::system;

/// Why the workbench ended.
pub type Ended = Result<(), String>;

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

/// Whether somebody is here for the first time: nothing was ever asked, and nothing was left.
fn is_new(folders: &Folders, store: Option<&Store>) -> bool {
    let everything = Filter {
        deleted: true,
        ..Filter::default()
    };
    let empty = |filter: &Filter| {
        let listed = store.and_then(|store| store.list(filter, 1).ok());
        listed.is_some_and(|runs| runs.is_empty())
    };
    !session::any(&folders.sessions()) && empty(&Filter::default()) && empty(&everything)
}

fn the_terminal(error: &std::io::Error) -> String {
    format!("the terminal: {}", system::words(error))
}

async fn workbench(paths: Vec<PathBuf>, ego: WantedEgo) -> Ended {
    give_back_on_panic();
    let folders = Folders::find()?;
    let stamps = Stamps::of(&folders);
    let (mut model, models, background) = prepare(paths, &ego, &folders);
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
    model.recall.hint = is_new(&folders, store.as_deref());
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
        let mut pace = Pace::begin(begun);
        loop {
            let wait = pace.wait(Instant::now(), self.model.moves());
            let first = tokio::select! {
                event = events.next() => match event {
                    Some(event) => Some(event?),
                    None => return Ok(()),
                },
                msg = self.receiver.recv() => msg,
                signal = ending.wait() => Some(signal),
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
                match msg {
                    Msg::Key(_) | Msg::Mouse(_) | Msg::Paste(_) => pace.hurry(),
                    _ => pace.change(),
                }
                let suspends = self.apply(msg)?;
                match suspends {
                    Step::Quit => return Ok(()),
                    Step::Suspend => {
                        // The event stream would read the shell's keys.
                        events.close();
                        self.screen.suspend()?;
                        events = Events::listen(false);
                        self.model.size = self.screen.size()?;
                        pace.change();
                    }
                    Step::EditOutside(sent) => {
                        let result = match outside::command(|name| std::env::var(name).ok()) {
                            Ok(command) => {
                                events.close();
                                let result = self.lend(&command, &sent)?;
                                events = Events::listen(false);
                                // The Ctrl-C of the other program was not meant for this one.
                                ending = Ending::listen()?;
                                self.model.size = self.screen.size()?;
                                result
                            }
                            Err(why) => Err(why),
                        };
                        // What it asks for needs no terminal.
                        for effect in update(&mut self.model, Msg::EditedOutside(sent, result)) {
                            self.tasks.perform(effect);
                        }
                        pace.change();
                    }
                    Step::On => {}
                }
            }
            if pace.is_due(Instant::now()) {
                self.apply(Msg::Drawing)?;
                self.screen.draw(|frame| views::draw(frame, &self.model))?;
                pace.drawn(Instant::now());
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
