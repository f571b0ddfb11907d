//! The main loop: drain all messages, draw once if something changed, sleep; at most 60 frames a second, keys excepted.

mod prepare;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use nearmiss_base::system;
use nearmiss_base::system::crash::{ActivityGuard, trying};
use nearmiss_base::system::processes::{self, JobSignal, Signals};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_settings::Folders;
use nearmiss_store::{Filter, Store};
use nearmiss_workflow::example_runs;
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

use crate::action::Action;
use crate::features::pictures::SavePicture;
use crate::features::tour::Tour;
use crate::message::{Effect, ExternalEdit, Msg};
use crate::model::Model;
use crate::reload::{self, Stamps};
use crate::run::prepare::prepare;
use crate::services::Services;
use crate::session::{self, SavedLocation};
use crate::terminal::{self, Events, Screen, give_back_on_panic};
use crate::update::{Open, perform, start, update};
use crate::{external_editor, screenshot, views, widgets};

/// Result of running the workbench.
pub type RunResult = Result<(), String>;

/// Runs the workbench on the scenarios at `paths`, or on the bundled ones, with this ego and the index in a folder; an
/// experiment file in place of paths is opened with its scenarios. A tour has example answers, and keeps nothing.
///
/// # Errors
/// A path is not there; the terminal cannot be taken, or went away.
pub fn run(
    paths: Vec<PathBuf>,
    ego: EgoSelection,
    index: Option<PathBuf>,
    tour: bool,
) -> RunResult {
    // Better said on the shell, where the mistake was made.
    for path in &paths {
        if let Some(file) = Entry::of_argument(path).file() {
            file.metadata()
                .map_err(|error| format!("{}: {}", file.display(), system::error_text(&error)))?;
        }
    }
    let (paths, experiment) = prepare::split_off(paths)?;
    // Before the first thread is started.
    processes::take_over().map_err(|e| the_terminal(&e))?;
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .map_err(|e| system::error_text(&e))?;
    let ended = runtime.block_on(workbench(paths, experiment, ego, index, tour));
    // Files that are still being read do not keep the program from ending.
    runtime.shutdown_background();
    ended
}

/// Whether this is a first start: no question was ever asked, and no session was left.
fn is_new(folders: &Folders, store: Option<&Store>) -> bool {
    let everything = Filter {
        deleted: true,
        ..Filter::default()
    };
    let empty = |filter: &Filter| {
        let listed = store.and_then(|store| store.list(filter, 1).ok());
        listed.is_some_and(|runs| runs.is_empty())
    };
    !session::file::any(&folders.sessions()) && empty(&Filter::default()) && empty(&everything)
}

fn the_terminal(error: &std::io::Error) -> String {
    format!("the terminal: {}", system::error_text(error))
}

async fn workbench(
    paths: Vec<PathBuf>,
    experiment: Option<PathBuf>,
    ego: EgoSelection,
    index: Option<PathBuf>,
    tour: bool,
) -> RunResult {
    give_back_on_panic();
    let mut folders = Folders::find()?;
    let made = tour.then(tempfile::tempdir).transpose();
    let for_tour = made.map_err(|error| system::error_text(&error))?;
    if let Some(folder) = &for_tour {
        folders = folders.with_data(folder.path());
    }
    folders.close();
    // Without marks a scenario that ends the program is opened again; everything else continues.
    let unmarked = system::crash::keep_marks(&folders.marks()).err();
    let stamps = Stamps::read(&folders);
    let (mut model, models, background) = prepare(paths, &ego, index, &folders);
    if let Some(error) = unmarked {
        let folder = folders.marks();
        model.complain(format!(
            "{}: {}",
            folder.display(),
            system::error_text(&error)
        ));
    }
    // A terminal that is closed at once ends the program in good order, too.
    let ending = Ending::listen().map_err(|e| the_terminal(&e))?;
    let first = Screen::take(model.mouse).and_then(|mut screen| {
        model.size = screen.size()?;
        model.camera.shape_cells(screen.cell_aspect());
        screen.draw(|frame| views::draw(frame, &model))?;
        Ok(screen)
    });
    let screen = match first {
        Err(error) if terminal::is_gone(&error) => return Ok(()),
        taken => taken.map_err(|e| the_terminal(&e))?,
    };
    std::thread::spawn(widgets::highlight::load);

    let store = match Store::open(&folders.store()) {
        Ok(store) => Some(Arc::new(store)),
        Err(error) => {
            model.complain(format!("runs are not kept: {error}"));
            None
        }
    };
    if tour {
        let added = store
            .as_ref()
            .map(|store| store.add(&example_runs(nearmiss_store::now_ms())));
        if let Some(Err(error)) = added {
            model.complain(format!("no example answers: {error}"));
        }
        model.tour = Some(Tour::default());
    }
    model.recall.hint = !tour && is_new(&folders, store.as_deref());
    let (sender, receiver) = unbounded_channel();
    tokio::spawn(reload::watch(folders.clone(), stamps, sender.clone()));
    let services = Services::new(
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
        services,
        receiver,
        stray: background.late,
        tried: LastOpened::default(),
    };
    let mut effects = start(&mut looping.model);
    if experiment.is_some() {
        looping.model.experiment.chosen = experiment;
        effects.extend(perform(&mut looping.model, Action::Experiment));
    }
    if looping.perform(effects).map_err(|e| the_terminal(&e))? {
        return Ok(());
    }
    let ended = looping.until_quit(ending).await;
    looping.services.finish().await;
    system::crash::close_marks();
    ended.map_err(|e| the_terminal(&e))
}

struct Loop {
    model: Model,
    screen: Screen,
    services: Services,
    receiver: UnboundedReceiver<Msg>,
    /// Whether the terminal may still answer what it was asked before the start.
    stray: bool,
    /// Marks the open scenario on disk.
    tried: LastOpened,
}

impl Loop {
    /// Runs until the user leaves, a signal ends the program, or the terminal is gone; that is no mistake.
    async fn until_quit(&mut self, ending: Ending) -> std::io::Result<()> {
        let Err(error) = self.turn(ending).await else {
            return Ok(());
        };
        // Finished work is saved all the same.
        for effect in update(&mut self.model, Msg::Terminate) {
            self.services.perform(effect);
        }
        if terminal::is_gone(&error) {
            Ok(())
        } else {
            Err(error)
        }
    }

    async fn turn(&mut self, mut ending: Ending) -> std::io::Result<()> {
        let mut events = Events::listen(self.stray);
        let begun = Instant::now();
        let mut passed = begun;
        let mut pace = Pace::begin(begun);
        loop {
            let wait = pace.wait(Instant::now(), self.model.moves());
            let first = tokio::select! {
                event = events.next() => match event {
                    Some(event) => Some(event?),
                    None => return Err(std::io::ErrorKind::UnexpectedEof.into()),
                },
                msg = self.receiver.recv() => msg,
                heard = ending.wait() => match heard {
                    TerminationSignal::End | TerminationSignal::Interrupt => Some(Msg::Terminate),
                    TerminationSignal::Job(JobSignal::Stop) => Some(Msg::Stop),
                    // The shell has had the terminal, unless that was seen to.
                    TerminationSignal::Job(JobSignal::Continue) => {
                        if processes::was_continued() {
                            self.screen.take_again()?;
                            self.model.map.images.forget();
                            self.model.size = self.screen.size()?;
                            pace.change();
                        }
                        None
                    }
                },
                () = sleep(wait) => None,
            };
            let mut msgs: Vec<Msg> = first.into_iter().collect();
            while let Ok(msg) = self.receiver.try_recv() {
                msgs.push(msg);
            }
            let elapsed = passed.elapsed();
            self.model.uptime = begun.elapsed();
            passed = Instant::now();
            // Time at rest does not count.
            if self.model.moves() && elapsed < Duration::from_secs(1) {
                msgs.push(Msg::Passed(elapsed));
            }
            for msg in msgs {
                match msg {
                    Msg::Key(_) | Msg::Mouse(_) | Msg::Paste(_) => pace.hurry(),
                    _ => pace.change(),
                }
                let asked = !matches!(msg, Msg::Stop);
                match self.apply(msg)? {
                    Step::Quit => return Ok(()),
                    Step::Suspend => {
                        if asked {
                            processes::ask_to_stop();
                        }
                        // The event stream would read the shell's keys.
                        events.close().await;
                        self.screen.suspend()?;
                        self.model.map.images.forget();
                        events = Events::listen(false);
                        self.model.size = self.screen.size()?;
                        pace.change();
                    }
                    Step::EditOutside(sent) => {
                        let mut over = false;
                        let result = match external_editor::command(|name| std::env::var(name).ok())
                        {
                            Ok(command) => {
                                events.close().await;
                                let (result, ends) = self.lend(command, &sent, &mut ending).await?;
                                events = Events::listen(false);
                                // The Ctrl-C of the other program was not meant for this one.
                                ending.forget()?;
                                self.model.size = self.screen.size()?;
                                over = ends;
                                result
                            }
                            Err(why) => Err(why),
                        };
                        // These effects need no terminal.
                        for effect in update(&mut self.model, Msg::EditedOutside(sent, result)) {
                            self.services.perform(effect);
                        }
                        pace.change();
                        if over {
                            self.apply(Msg::Terminate)?;
                            return Ok(());
                        }
                    }
                    Step::On => {}
                }
            }
            if pace.is_due(Instant::now()) {
                self.apply(Msg::Drawing)?;
                self.screen.draw(|frame| views::draw(frame, &self.model))?;
                pace.drawn(Instant::now());
                if self.model.drawn.has_consequences() {
                    self.apply(Msg::Drawn)?;
                }
                self.tried.drawn(self.model.opening.is_some());
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
            self.tried.on_effect(&effect, &self.model.recall.here);
            match self.services.perform(effect) {
                None => {}
                Some(Effect::Copy(text)) => self.screen.copy(&text)?,
                Some(Effect::Picture(mut job)) => {
                    if job.needs_screen() {
                        job.screen = screenshot::paint(&self.model).map(Some);
                    }
                    self.services.perform(SavePicture(job).into());
                }
                Some(Effect::UseMouse(on)) => self.screen.use_mouse(on)?,
                Some(Effect::Suspend) => step = Step::Suspend,
                Some(Effect::EditOutside(outside)) => step = Step::EditOutside(outside),
                Some(Effect::Quit) => return Ok(Step::Quit),
                Some(Effect::Request(_) | Effect::Cancel(_) | Effect::Step(_)) => {}
            }
        }
        Ok(step)
    }

    /// Lends the terminal to the user's editor; says what came of it, and whether the program is to end now.
    async fn lend(
        &mut self,
        command: Vec<String>,
        sent: &ExternalEdit,
        signals: &mut Ending,
    ) -> std::io::Result<(Result<String, String>, bool)> {
        self.screen.lend();
        let ExternalEdit {
            file, text, place, ..
        } = sent.clone();
        let mut editing = tokio::task::spawn_blocking(move || match place {
            Some(path) => external_editor::edit_file(&command, &path),
            None => external_editor::edit(&command, &file, &text),
        });
        let mut ends = false;
        let edited = loop {
            tokio::select! {
                edited = &mut editing => break edited,
                heard = signals.wait() => match heard {
                    // The shell waits until both have stopped.
                    TerminationSignal::Job(JobSignal::Stop) => processes::stop()?,
                    TerminationSignal::Job(JobSignal::Continue) => {
                        let _ = processes::was_continued();
                    }
                    // The user's text is not discarded.
                    TerminationSignal::End => ends = true,
                    TerminationSignal::Interrupt => {}
                },
            }
        };
        self.screen.take_again()?;
        self.model.map.images.forget();
        let edited = edited.unwrap_or_else(|error| Err(format!("the editor: {error}")));
        Ok((edited, ends))
    }

    /// Performs the effects of the start; says whether the program ends at once.
    fn perform(&mut self, effects: Vec<Effect>) -> std::io::Result<bool> {
        let mut quit = false;
        for effect in effects {
            quit |= matches!(self.services.perform(effect), Some(Effect::Quit));
        }
        Ok(quit)
    }
}

enum Step {
    On,
    Suspend,
    EditOutside(ExternalEdit),
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

/// A program that is killed later than this after the first picture was not ended by the scenario.
const SETTLED: Duration = Duration::from_millis(800);

/// The scenario opened last.
#[derive(Debug, Default)]
struct LastOpened {
    open: Option<Arc<ActivityGuard>>,
    drawn: bool,
}

impl LastOpened {
    /// An effect is about to be performed: if it opens a scenario, that is tried from now on.
    pub fn on_effect(&mut self, effect: &Effect, here: &Path) {
        let Some(Open { entry, .. }) = effect.request() else {
            return;
        };
        // The one before is over first.
        self.open = None;
        let words = format!("opening or showing {}", entry.name);
        let subject = SavedLocation::from_entry(entry, here).subject();
        self.open = Some(Arc::new(trying(words, subject)));
        self.drawn = false;
    }

    /// A frame was drawn: the scenario is in it unless it is still being opened.
    pub fn drawn(&mut self, opening: bool) {
        if opening || self.drawn {
            return;
        }
        self.drawn = true;
        if let Some(open) = self.open.clone() {
            tokio::spawn(async move {
                tokio::time::sleep(SETTLED).await;
                open.settle();
            });
        }
    }
}

/// Least time between two frames.
const FRAME: Duration = Duration::from_micros(16_667);

/// Least time between a frame and the one that shows what a key did: who presses it waits for it.
const PROMPT: Duration = Duration::from_millis(8);

/// Paces the frames of the loop. The caller supplies the time.
#[derive(Debug)]
struct Pace {
    drawn: Instant,
    changed: bool,
    hurries: bool,
}

impl Pace {
    /// A frame was drawn just now, and there is news already.
    pub fn begin(now: Instant) -> Self {
        Self {
            drawn: now,
            changed: true,
            hurries: false,
        }
    }

    /// Something changed that the next frame shows.
    pub fn change(&mut self) {
        self.changed = true;
    }

    /// User input has arrived: its effect should show without delay.
    pub fn hurry(&mut self) {
        self.changed = true;
        self.hurries = true;
    }

    fn apart(&self) -> Duration {
        if self.hurries { PROMPT } else { FRAME }
    }

    /// How long the loop sleeps if nothing arrives; for ever where nothing changed and nothing `moves` by itself.
    pub fn wait(&self, now: Instant, moves: bool) -> Option<Duration> {
        match (self.changed, moves) {
            (true, _) => Some(
                self.apart()
                    .saturating_sub(now.saturating_duration_since(self.drawn)),
            ),
            (false, true) => Some(FRAME * 2),
            (false, false) => None,
        }
    }

    /// Whether a frame has to be drawn now.
    pub fn is_due(&self, now: Instant) -> bool {
        self.changed && now.saturating_duration_since(self.drawn) >= self.apart()
    }

    /// A frame was drawn, and this was the time afterwards.
    pub fn drawn(&mut self, now: Instant) {
        self.drawn = now;
        self.changed = false;
        self.hurries = false;
    }
}

/// A signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TerminationSignal {
    /// The program is to end, or the terminal is gone.
    End,
    /// Ctrl-C or Ctrl-\ from elsewhere: they are keys here, and mean another program while that has the terminal.
    Interrupt,
    /// A shell's signal.
    Job(JobSignal),
}

#[cfg(unix)]
type Ends = [(tokio::signal::unix::Signal, TerminationSignal); 4];

#[cfg(unix)]
fn ends() -> std::io::Result<Ends> {
    use tokio::signal::unix::{SignalKind, signal};
    Ok([
        (signal(SignalKind::terminate())?, TerminationSignal::End),
        (signal(SignalKind::hangup())?, TerminationSignal::End),
        (
            signal(SignalKind::interrupt())?,
            TerminationSignal::Interrupt,
        ),
        (signal(SignalKind::quit())?, TerminationSignal::Interrupt),
    ])
}

/// Listens to the signals that ask the program to end or to stop for a while.
struct Ending {
    job: Signals,
    #[cfg(unix)]
    signals: Ends,
}

impl Ending {
    /// Begins to listen; an end that was asked for before is not heard.
    ///
    /// # Errors
    /// The system refuses, or job control was not taken over.
    pub fn listen() -> std::io::Result<Self> {
        Ok(Self {
            job: Signals::listen()?,
            #[cfg(unix)]
            signals: ends()?,
        })
    }

    /// Forgets what asked the program to end until now.
    ///
    /// # Errors
    /// The system refuses.
    pub fn forget(&mut self) -> std::io::Result<()> {
        #[cfg(unix)]
        {
            self.signals = ends()?;
        }
        Ok(())
    }

    /// Waits for the next one.
    pub async fn wait(&mut self) -> TerminationSignal {
        #[cfg(unix)]
        {
            let signals = &mut self.signals;
            let ended = std::future::poll_fn(|context| {
                let mut signals = signals.iter_mut();
                let heard = signals.find_map(|(signal, heard)| {
                    signal.poll_recv(context).is_ready().then_some(*heard)
                });
                heard.map_or(std::task::Poll::Pending, std::task::Poll::Ready)
            });
            tokio::select! {
                biased;
                heard = ended => heard,
                job = self.job.wait() => TerminationSignal::Job(job),
            }
        }
        #[cfg(not(unix))]
        TerminationSignal::Job(self.job.wait().await)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_burst_of_chunks_costs_a_frame_in_sixteen_milliseconds() {
        let begun = Instant::now();
        let mut pace = Pace::begin(begun);
        let mut frames = Vec::new();
        // Ten thousand within a second, then silence.
        let mut now = begun;
        for _ in 0..10_000 {
            now += Duration::from_micros(100);
            pace.change();
            if pace.is_due(now) {
                frames.push(now);
                pace.drawn(now);
            }
        }
        assert!((50..=62).contains(&frames.len()), "{}", frames.len());
        let apart = frames.windows(2).map(|pair| pair[1] - pair[0]).min();
        assert!(apart.is_some_and(|apart| apart >= FRAME));
        // The last chunks are drawn too, and then nothing more.
        let rest = pace.wait(now, false).unwrap_or_default();
        assert!(rest <= FRAME);
        assert!(pace.is_due(now + rest));
        pace.drawn(now + rest);
        assert_eq!(pace.wait(now + rest, false), None);
        assert!(!pace.is_due(now + Duration::from_secs(60)));
    }

    #[test]
    fn a_key_does_not_wait_for_the_frame_of_the_chunks() {
        let begun = Instant::now();
        let mut pace = Pace::begin(begun);
        let soon = begun + PROMPT;
        assert!(!pace.is_due(soon), "chunks wait");
        pace.hurry();
        assert!(pace.is_due(soon), "keys do not");
        assert_eq!(pace.wait(begun, false), Some(PROMPT));
        // And they do not make it draw without end.
        pace.drawn(soon);
        pace.hurry();
        assert!(!pace.is_due(soon + PROMPT / 2));
        pace.drawn(soon + PROMPT);
        assert_eq!(pace.wait(soon + PROMPT, false), None);
    }
}
