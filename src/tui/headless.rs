//! The workbench without terminal and tasks, for benches: keys and chunks in, frames out.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use ratatui::Terminal;
use ratatui::backend::TestBackend;

use crate::features::answers::Ask;
use crate::features::history::request::Judging;
use crate::features::planner::request::Plan;
use crate::features::results::request::ResultsCommand;
use crate::features::scenarios::request::{Find, Found};
use crate::keymap::Key;
use crate::loaded::Opened;
use crate::message::{Effect, Msg};
use crate::model::{JobId, Model, Update};
use crate::pixels::Encoder;
use crate::theme::Theme;
use crate::update::{Open, compute_now, update};
use crate::{views, widgets};
use nearmiss_ask::llm::Chunk;
use nearmiss_ask::prompts::Library;
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_settings::Config;
use nearmiss_store::{Consumed, Store};
use nearmiss_study::evaluation::{Answer, Event, JudgeOutcome, MissingVerdict, default_planning};
use nearmiss_workflow::{OpenRequest, PlanRequest, StandIn};

/// A workbench and the screen it is drawn on.
pub struct Stage {
    model: Model,
    terminal: Terminal<TestBackend>,
    asked: Vec<JobId>,
    /// What is computed beside the loop, and has yet to be.
    waiting: Vec<Effect>,
}

impl Stage {
    /// A workbench of this size, in columns and rows, with an open scenario.
    ///
    /// # Errors
    /// The scenario cannot be read.
    pub fn open(entry: &Entry, size: (u16, u16)) -> Result<Self, String> {
        widgets::highlight::load();
        let library = Library::load(None);
        let (config, theme) = (Config::default(), Theme::load("dark", Path::new(""), true)?);
        let mut model = Model::new(Vec::new(), config, theme, library, Vec::new());
        model.size = size;
        let backend = TestBackend::new(size.0, size.1);
        let mut stage = Self {
            model,
            terminal: Terminal::new(backend).map_err(|e| e.to_string())?,
            asked: Vec::new(),
            waiting: Vec::new(),
        };
        // Drawn before, so that the map knows its size when it is pointed at the ego.
        stage.draw();
        let found = Found::All(Ok(vec![entry.clone()].into()));
        for effect in stage.send(Msg::reply::<Find>(found)) {
            if let Some(Open { id, entry, .. }) = effect.request() {
                let opened = Opened::read(entry, &EgoSelection::Beside, &stage.model.thresholds)?;
                stage.send(Msg::reply::<Open>((*id, Ok(Box::new(opened)))));
            }
        }
        Ok(stage)
    }

    fn send(&mut self, msg: Msg) -> Vec<Effect> {
        let effects = update(&mut self.model, msg);
        // Every frame is complete.
        compute_now(&mut self.model, effects)
    }

    /// These scenarios too are found, whether or not they can be read.
    pub fn list(&mut self, entries: Vec<Entry>) {
        self.send(Msg::reply::<Find>(Found::More(entries)));
    }

    /// How many scenarios the list shows.
    #[must_use]
    pub fn listed(&self) -> usize {
        self.model.list.lines.len()
    }

    /// Whether the open scenario has an ego, without which there is nothing to ask about.
    #[must_use]
    pub fn has_ego(&self) -> bool {
        self.model.scene().is_some()
    }

    /// Presses keys by their names, separated by spaces.
    ///
    /// # Panics
    /// The key does not exist.
    pub fn press(&mut self, keys: &str) {
        for name in keys.split_whitespace() {
            let key = Key::parse(name).unwrap_or_else(|| panic!("no key `{name}`"));
            for effect in self.send(Msg::Key(key)) {
                if let Some(Ask { id, .. }) = effect.request() {
                    self.asked.push(*id);
                }
            }
        }
    }

    /// Goes a time step on, and leaves what that asks to be computed for [`Stage::compute`]; says whether there was one.
    pub fn step(&mut self) -> bool {
        let before = self.model.clock.step();
        let effects = Key::parse("right").map(|key| update(&mut self.model, Msg::Key(key)));
        self.waiting.extend(effects.into_iter().flatten());
        self.model.clock.step() != before
    }

    /// Computes what waits for it.
    pub fn compute(&mut self) {
        let waiting = std::mem::take(&mut self.waiting);
        compute_now(&mut self.model, waiting);
    }

    /// Shows the map as an image from now on, as kitty does, in cells of so many pixels; compressed or not.
    pub fn show_pixels(&mut self, cell: (u16, u16), compressed: bool) {
        self.model.map.images.encoder = Some(Encoder::kitty(cell, compressed));
    }

    /// Asks a model, and gives the place of its answer. It says nothing by itself.
    pub fn ask(&mut self, model: &str) -> usize {
        self.model.model = model.into();
        self.press("r");
        self.asked.len() - 1
    }

    /// A piece of an answer arrives.
    pub fn arrive(&mut self, answer: usize, piece: &str) {
        let event = Event::Chunk(Chunk::Text(piece.into()));
        let update = Update::Progress(event);
        self.send(Msg::reply::<Ask>((self.asked[answer], update)));
    }

    /// An answer has ended, and this was all of it.
    pub fn end(&mut self, answer: usize, text: &str) {
        let column = self.model.column_mut(self.asked[answer]);
        let (model, how, window, times) = column.map_or_else(Default::default, |c| {
            (c.model.clone(), c.how.clone(), c.steps, c.times)
        });
        let whole = Answer {
            run: None,
            model,
            past: None,
            window,
            times,
            how,
            model_returned: None,
            judged: JudgeOutcome::Missing(MissingVerdict::NotInAnswer("no verdict in it".into())),
            text: text.into(),
            reasoning: String::new(),
            tool_rounds: Vec::new(),
            consumed: Consumed::default(),
            price_source: None,
            finish: Some("stop".into()),
        };
        let update = Update::Ended(Ok(Box::new(whole)));
        self.send(Msg::reply::<Ask>((self.asked[answer], update)));
    }

    /// How many claims of the shown answer were held against the geometry.
    #[must_use]
    pub fn claims(&self) -> usize {
        let document = self.model.document(self.model.answers.shown);
        document.map_or(0, |d| self.model.claims.get(d.key).len())
    }

    /// Runs the planner to the end of the open scenario, and shows the drive.
    ///
    /// # Errors
    /// The scenario has no planning problem, or the planner cannot begin.
    pub fn drive(&mut self) -> Result<(), String> {
        let keys = ["space", "e", "p"].map(Key::parse).into_iter().flatten();
        let asks: Vec<Effect> = keys.flat_map(|key| self.send(Msg::Key(key))).collect();
        let mut plans = asks.iter().filter_map(Effect::request::<Plan>);
        let plan = plans.next_back().ok_or("there is nothing to plan")?;
        let request = PlanRequest {
            open: OpenRequest {
                entry: &plan.entry,
                ego: &EgoSelection::Beside,
                transform: plan.change,
                strict: false,
                stand_in: StandIn::None,
            },
            problem: None,
            settings: &default_planning(),
        };
        let (thresholds, cancel) = (&self.model.thresholds, Cancel::default());
        let opened = Opened::planned(&request, thresholds, &cancel, &mut |_, _| {})?
            .ok_or("planning was stopped")?;
        let update = Update::Ended(Ok(Box::new(opened)));
        self.send(Msg::reply::<Plan>((plan.id, update)));
        Ok(())
    }

    /// Shows the planner's layer of the map, or not.
    pub fn show_planner(&mut self, on: bool) {
        self.model.map.layers.planner = on;
    }

    /// How many paths into the future the map shows.
    #[must_use]
    pub fn paths(&self) -> usize {
        self.model.map.foresight.futures.len()
    }

    /// Opens the screen of results over this store, and draws a frame for everything that is heard of it.
    ///
    /// # Panics
    /// The screen is open already.
    pub fn read_results(&mut self, store: &Store) {
        let judging = Judging {
            ego: EgoSelection::Beside,
            thresholds: self.model.thresholds.clone(),
        };
        let keys = ["space", "o", "r"].map(Key::parse).into_iter().flatten();
        let asks: Vec<Effect> = keys.flat_map(|key| self.send(Msg::Key(key))).collect();
        let ask = asks
            .into_iter()
            .find_map(|effect| effect.into_request::<ResultsCommand>().ok())
            .unwrap_or_else(|| panic!("the screen of results is open already"));
        let going = AtomicBool::new(false);
        let (sender, receiver) = std::sync::mpsc::channel();
        std::thread::scope(|scope| {
            scope.spawn(move || {
                super::features::results::request::answer(
                    store,
                    &judging,
                    ask,
                    &going,
                    &mut |news| {
                        // The receiver stays until the sender is gone.
                        let _ = sender.send(news);
                    },
                );
            });
            for news in receiver {
                self.send(Msg::reply::<ResultsCommand>(news));
                self.draw();
            }
        });
    }

    /// The rows of the screen of results, as they would be exported.
    #[must_use]
    pub fn results(&self) -> Vec<nearmiss_study::evaluation::ResultsRow> {
        let rows = self.model.results.rows.iter();
        rows.map(|row| row.row("")).collect()
    }

    /// Draws a frame as the loop does.
    ///
    /// # Panics
    /// Never: the screen is in memory.
    pub fn draw(&mut self) {
        let _ = update(&mut self.model, Msg::Drawing);
        let model = &self.model;
        let drawn = self.terminal.draw(|frame| views::draw(frame, model));
        assert!(drawn.is_ok(), "the screen is in memory");
        if self.model.drawn.has_consequences() {
            self.send(Msg::Drawn);
        }
    }

    /// Draws a frame with nothing on it: what a screen of this size costs in any case.
    ///
    /// # Panics
    /// Never: the screen is in memory.
    pub fn draw_nothing(&mut self) {
        let drawn = self.terminal.draw(|_| {});
        assert!(drawn.is_ok(), "the screen is in memory");
    }

    /// The screen's contents, row by row.
    #[must_use]
    pub fn screen(&self) -> String {
        let buffer = self.terminal.backend().buffer();
        let rows = buffer
            .content()
            .chunks(usize::from(buffer.area.width).max(1));
        rows.map(|row| {
            row.iter()
                .map(ratatui::buffer::Cell::symbol)
                .collect::<String>()
                + "\n"
        })
        .collect()
    }
}
