//! A workbench and its surroundings: effects wait, then finish with plausible results.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use proptest::prelude::*;
use proptest::sample::select;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::layout::Position;

use crate::features::answers::{LoadStored, Probe};
use crate::features::compare::rating::{Rate, ReadRatings};
use crate::features::experiment::request::ListExperiments;
use crate::features::history::request::{HistoryCommand, HistoryEvent};
use crate::features::pictures::SavePicture;
use crate::features::prompt::request::{ChangeTemplate, RereadTemplates, TemplateChange};
use crate::features::scenarios::request::{Find, Found, Rank, Survey};
use crate::features::source::ReadSource;
use crate::features::values::{MeasureAll, ReadThresholds};
use crate::keymap::{Code, Key, Keymap, Preset};
use crate::loaded::{Opened, Ranked, Source};
use crate::message::{Effect, Mouse, Msg, Reloaded};
use crate::model::PromptPane;
use crate::tests::bench::opened;
use crate::tests::history::{FIRST, Fixture};
use crate::tests::random::plausible::{self, cancelled, facts, job, rating, stored};
use crate::tests::random::{ESCAPES, Input};
use crate::theme::Theme;
use crate::update::{Open, update};
use crate::views;
use nearmiss_ask::llm::{Dialect, Discovered};
use nearmiss_ask::prompts::Library;
use nearmiss_formats::{EgoSelection, Entry, bundled};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::Keys;

/// What can be heard of at any time.
#[derive(Debug, Clone, Copy)]
pub enum News {
    Complaint,
    Changed,
    Discovered,
    Searched,
    Listed,
    Themes,
    Keymap(Preset),
    Config,
    Thresholds,
    Unreadable,
    Ratings,
    Reread,
    Terminate,
}

pub fn news() -> impl Strategy<Value = News> {
    use News::*;
    let presets = Preset::ALL.map(Keymap);
    let mut all = vec![
        Complaint, Changed, Discovered, Searched, Listed, Themes, Config, Thresholds, Unreadable,
        Ratings, Reread, Terminate,
    ];
    all.extend(presets);
    select(all)
}

pub const HOSTILE: &str = "\u{1b}]0;owned\u{7}\u{202e}猫\u{9b}31m";

pub const CLAIMS: &str = "### Obstacle 301\n\nObstacle 301 is at a distance of 999 m at step 20.\n\n\
    Obstacle 302 is behind the ego. Obstacle 99999 is not there.";

pub struct World {
    kept: Fixture,
    size: (u16, u16),
    /// What was asked for and is not done yet.
    waiting: VecDeque<Effect>,
    /// Counts what was done, so that results differ.
    done: usize,
    /// What to say of this world where something breaks in it.
    pub told: String,
    /// The last inputs.
    last: VecDeque<String>,
    taken: usize,
}

/// Tells how it came to a failure.
impl Drop for World {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let last: Vec<&str> = self.last.iter().map(String::as_str).collect();
            eprintln!(
                "{}: at {:?}, input {}, after\n{}",
                self.told,
                self.size,
                self.taken,
                last.join("\n")
            );
        }
    }
}

impl World {
    pub fn new(keys: Keys, preset: Preset, size: (u16, u16)) -> Self {
        let mut kept = Fixture::new();
        for (i, scenario) in [FIRST, "ZAM_Lost-1_1_T-1", "ZAM_Merge-1_1_T-1"]
            .into_iter()
            .cycle()
            .take(130)
            .enumerate()
        {
            kept.add(scenario, "lab/small", i % 2 == 0, CLAIMS);
        }
        let model = &mut kept.bench.model;
        model.prompt = PromptPane::new(keys);
        model.look.keymap = Keymap::from_preset(preset);
        model.look.themes = Theme::all(std::path::Path::new("/nonexistent"));
        model.size = size;
        model.refresh();
        let waiting = std::mem::take(&mut kept.bench.effects).into();
        let mut world = Self {
            kept,
            size,
            waiting,
            done: 0,
            told: String::new(),
            last: VecDeque::new(),
            taken: 0,
        };
        world.draw();
        world
    }

    pub fn take(&mut self, input: &Input) {
        self.taken += 1;
        self.last.push_back(format!("{input:?}"));
        if self.last.len() > 25 {
            self.last.pop_front();
        }
        match input {
            Input::Keys(keys) => keys.iter().for_each(|key| self.send(Msg::Key(*key))),
            Input::Named(id) => {
                self.send(Msg::Key(Key::plain(Code::Char(':'))));
                for c in id.chars() {
                    self.send(Msg::Key(Key::plain(Code::Char(c))));
                }
                self.send(Msg::Key(Key::plain(Code::Enter)));
            }
            Input::Mouse(what, x, y) => self.send(Msg::Mouse(self.mouse(*what, *x, *y))),
            Input::Resize(columns, rows) => {
                self.size = (*columns, *rows);
                self.send(Msg::Resize(*columns, *rows));
                self.draw();
            }
            Input::Paste(text) => self.send(Msg::Paste(text.clone())),
            Input::Passed(ms) => self.send(Msg::Passed(Duration::from_millis(*ms))),
            Input::Done(count) => (0..*count).for_each(|_| self.do_next()),
            Input::News(news) => self.on_event(*news),
            Input::Drawn => self.draw(),
            Input::Out => self.out(),
        }
    }

    fn mouse(&self, what: u8, x: f64, y: f64) -> Mouse {
        // Within the screen, or where it was before it became smaller.
        let at = Position::new(
            (f64::from(self.size.0) * x) as u16,
            (f64::from(self.size.1) * y) as u16,
        );
        match what {
            0 => Mouse::Press(at),
            1 => Mouse::Drag(at),
            2 => Mouse::Release(at),
            3 => Mouse::WheelUp(at),
            _ => Mouse::WheelDown(at),
        }
    }

    fn send(&mut self, msg: Msg) {
        let effects = update(&mut self.kept.bench.model, msg);
        self.waiting.extend(effects);
        super::check(&self.kept.bench.model);
    }

    /// Presses Esc until nothing is open, a few times at most.
    pub fn out(&mut self) {
        for _ in 0..ESCAPES {
            if super::on_main_screen(&self.kept.bench.model) {
                return;
            }
            self.send(Msg::Key(Key::plain(Code::Esc)));
        }
        let model = &self.kept.bench.model;
        assert!(
            super::on_main_screen(model),
            "Esc does not lead out of {}",
            super::what_is_open(model)
        );
    }

    pub fn draw(&mut self) {
        self.send(Msg::Drawing);
        let (columns, rows) = self.size;
        let mut terminal = Terminal::new(TestBackend::new(columns, rows)).unwrap();
        let model = &self.kept.bench.model;
        let drawn = terminal.draw(|frame| views::draw(frame, model)).unwrap();
        let leaks = drawn.buffer.content().iter().find(|cell| {
            cell.symbol()
                .chars()
                .any(|c| c.is_control() || c == '\u{202e}')
        });
        assert!(leaks.is_none(), "{leaks:?} reaches the terminal");
    }

    fn on_event(&mut self, news: News) {
        let msg = match news {
            News::Complaint => Msg::Complaint(format!("the disk is full {HOSTILE}")),
            News::Changed => Msg::reply::<HistoryCommand>(HistoryEvent::Changed),
            News::Discovered => Msg::reply::<Probe>(vec![Discovered {
                id: format!("ollama/tiny{}", self.done % 3),
                dialect: Dialect::Ollama,
            }]),
            News::Searched => Msg::reply::<Find>(Found::Ended(Ok(Vec::new()))),
            News::Listed => {
                if self.kept.bench.model.list.rows.len() > 40 {
                    return;
                }
                Msg::reply::<Find>(Found::More(vec![
                    Entry::of_file(std::path::Path::new("missing/ZAM_Gone-1_1_T-1.xml")),
                    bundled().remove(1),
                ]))
            }
            News::Themes => Msg::Reloaded(Reloaded::Themes(Theme::all(std::path::Path::new(
                "/nonexistent",
            )))),
            News::Keymap(preset) => {
                Msg::Reloaded(Reloaded::Keymap(Ok(Keymap::from_preset(preset))))
            }
            News::Config => Msg::Reloaded(Reloaded::Config(match self.done % 2 {
                0 => Err(format!("config.toml:1: {HOSTILE}")),
                _ => Ok(Box::default()),
            })),
            News::Thresholds => {
                Msg::reply::<ReadThresholds>(Ok(Arc::new(Thresholds::shipped().clone())))
            }
            News::Unreadable => Msg::reply::<ReadRatings>(Err("the store is locked".into())),
            News::Ratings => Msg::reply::<ReadRatings>(Ok(vec![rating()])),
            News::Reread => Msg::reply::<RereadTemplates>(Library::load(None)),
            News::Terminate => Msg::Terminate,
        };
        self.send(msg);
    }

    /// Does the oldest thing that was asked for.
    fn do_next(&mut self) {
        let Some(effect) = self.waiting.pop_front() else {
            return;
        };
        self.done += 1;
        let n = self.done;
        for msg in self.results(effect, n) {
            self.send(msg);
        }
    }

    fn results(&mut self, effect: Effect, n: usize) -> Vec<Msg> {
        if let Some(replies) = self.replies(&effect, n).or_else(|| job(&effect, n)) {
            return replies;
        }
        let effect = match effect.into_request() {
            Ok(ask) => return self.history(ask),
            Err(effect) => effect,
        };
        match effect {
            Effect::Cancel(id) => {
                let mut jobs = self.kept.bench.model.jobs.all.iter();
                let kind = jobs.find(|job| job.id == id).map(|job| job.kind);
                cancelled(id, kind)
            }
            Effect::EditOutside(sent) => vec![Msg::EditedOutside(
                sent.clone(),
                match n % 2 {
                    0 => Ok(format!("{} {HOSTILE}", sent.text)),
                    _ => Err("the editor ended with status 3".into()),
                },
            )],
            Effect::Picture(_) => vec![Msg::reply::<SavePicture>(Ok("picture.svg".into()))],
            effect => effect.at_once().into_iter().collect(),
        }
    }

    /// What the history hears of the store.
    fn history(&mut self, ask: HistoryCommand) -> Vec<Msg> {
        if matches!(ask, HistoryCommand::Export(..)) {
            let exported = HistoryEvent::Exported(Ok("3 runs written".into()));
            return vec![Msg::reply::<HistoryCommand>(exported)];
        }
        self.kept.bench.effects.push(ask.into());
        self.kept.settle();
        let effects = std::mem::take(&mut self.kept.bench.effects);
        self.waiting.extend(effects);
        Vec::new()
    }

    /// What comes of a request of the list, of answers and of templates; `None` for others.
    fn replies(&self, effect: &Effect, n: usize) -> Option<Vec<Msg>> {
        let thresholds = Thresholds::shipped();
        if let Some(open) = effect.request::<Open>() {
            let ego = open.obstacle;
            let ego = ego.map_or(EgoSelection::Beside, EgoSelection::Obstacle);
            let opened = match open.change {
                Some(_) => Opened::changed(&open.entry, &ego, thresholds, open.change),
                None => opened(&open.entry, &ego, thresholds),
            };
            let opened = opened.map(Box::new);
            return Some(vec![Msg::reply::<Open>((open.id, opened))]);
        }
        if effect.request::<MeasureAll>().is_some() && !n.is_multiple_of(3) {
            return Some(Vec::new());
        }
        if let Some(ReadSource(place, entry)) = effect.request() {
            let source = Source::read(entry).map(Box::new);
            return Some(vec![Msg::reply::<ReadSource>((*place, source))]);
        }
        if let Some(Survey::All(entries) | Survey::More(entries)) = effect.request() {
            let entries = entries.iter().take(6);
            let facts = entries.map(|(place, entry)| (*place, facts(entry)));
            return Some(facts.map(Msg::reply::<Survey>).collect());
        }
        if let Some(Rank::All(measure, entries)) = effect.request() {
            let ranked = |place: usize| Ranked {
                value: (!place.is_multiple_of(3)).then_some(place as f64 * 0.7),
                stand_in: None,
            };
            let places = entries.iter().map(|(place, _)| *place);
            let values = places.map(|place| (*measure, place, ranked(place)));
            return Some(values.map(Msg::reply::<Rank>).collect());
        }
        if let Some(LoadStored(of)) = effect.request() {
            let answers = (0..n % 5).map(stored).collect();
            return Some(vec![Msg::reply::<LoadStored>((of.clone(), answers))]);
        }
        if let Some(ReadThresholds) = effect.request() {
            let why = format!("thresholds.toml: {HOSTILE}");
            return Some(vec![Msg::reply::<ReadThresholds>(Err(why))]);
        }
        if let Some(ReadRatings) = effect.request() {
            return Some(vec![Msg::reply::<ReadRatings>(Ok(vec![rating()]))]);
        }
        if let Some(Rate { round, .. }) = effect.request() {
            let kept = match n % 3 {
                0 => Err("the store is locked".into()),
                _ => Ok(7),
            };
            return Some(vec![Msg::reply::<Rate>((*round, kept))]);
        }
        if let Some(ChangeTemplate(file, change)) = effect.request()
            && !matches!(change, TemplateChange::Use)
        {
            let saved = Ok((Library::load(None), "saved".into()));
            return Some(vec![Msg::reply::<ChangeTemplate>((file.clone(), saved))]);
        }
        if let Some(ListExperiments(folder)) = effect.request() {
            return Some(vec![plausible::listed(folder.clone(), n)]);
        }
        if let Some(RereadTemplates) = effect.request() {
            return Some(vec![Msg::reply::<RereadTemplates>(Library::load(None))]);
        }
        None
    }
}
