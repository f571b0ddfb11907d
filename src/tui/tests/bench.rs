//! A workbench whose effects run at once, unless they need a network.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use ratatui::Terminal;
use ratatui::backend::TestBackend;

use crate::features::answers::Ask;
use crate::features::scenarios::request::{Find, Found};
use crate::features::source::ReadSource;
use crate::keymap::Key;
use crate::loaded::{Opened, Source};
use crate::message::{Effect, Msg};
use crate::model::JobId;
use crate::model::Model;
use crate::theme::Theme;
use crate::update::Open;
use crate::update::update;
use crate::views;
use nearmiss_ask::prompts::Library;
use nearmiss_formats::{EgoSelection, Entry, EntryLocation, bundled};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::{ObstacleRisk, ParseQuality, Parsed, Task, Verdict};
use nearmiss_settings::Config;
use nearmiss_store::Consumed;
use nearmiss_study::evaluation::claims::TimeOrigin;
use nearmiss_study::evaluation::{Answer, JudgeOutcome, MissingVerdict};

pub struct Bench {
    pub model: Model,
    /// The ego of a scenario where no obstacle is taken in its place.
    pub ego: EgoSelection,
    /// What was asked for and not done.
    pub effects: Vec<Effect>,
}

impl Bench {
    /// The bundled scenarios, with the first one open.
    pub fn bundled() -> Self {
        let mut bench = Self::empty();
        bench.send(Msg::reply::<Find>(Found::All(Ok(bundled().into()))));
        bench
    }

    pub fn empty() -> Self {
        let library = Library::load(None);
        let offers = vec![nearmiss_ask::llm::ModelOffer {
            id: "lab/small".into(),
            key: None,
            warning: None,
        }];
        Self {
            model: Model::new(
                Vec::new(),
                Config::default(),
                Theme::default_theme(),
                library,
                offers,
            ),
            ego: EgoSelection::Beside,
            effects: Vec::new(),
        }
    }

    /// Sends a message; scenarios that it asks for are opened at once.
    pub fn send(&mut self, msg: Msg) {
        for effect in update(&mut self.model, msg) {
            match self.reply(effect) {
                Ok(reply) => self.send(reply),
                Err(effect) => self.effects.push(effect),
            }
        }
        // As before every frame.
        self.model.list.settle();
    }

    /// What comes of an effect that needs neither store nor network.
    fn reply(&self, effect: Effect) -> Result<Msg, Effect> {
        if let Some(open) = effect.request::<Open>() {
            let ego = open.obstacle.map(EgoSelection::Obstacle);
            let ego = ego.unwrap_or_else(|| self.ego.clone());
            let thresholds = &self.model.thresholds;
            let opened = match open.change {
                Some(_) => Opened::changed(&open.entry, &ego, thresholds, open.change),
                None => opened(&open.entry, &ego, thresholds),
            };
            return Ok(Msg::reply::<Open>((open.id, opened.map(Box::new))));
        }
        if let Some(ReadSource(place, entry)) = effect.request() {
            let source = Source::read(entry).map(Box::new);
            return Ok(Msg::reply::<ReadSource>((*place, source)));
        }
        effect.at_once()
    }

    /// Presses keys by their names, separated by spaces.
    pub fn press(&mut self, keys: &str) {
        for name in keys.split(' ').filter(|n| !n.is_empty()) {
            self.send(Msg::Key(
                Key::parse(name).unwrap_or_else(|| panic!("no key `{name}`")),
            ));
        }
    }

    /// Does something by its name in the palette.
    pub fn perform(&mut self, id: &str) {
        self.press(":");
        self.type_text(id);
        self.press("enter");
    }

    /// Types a text, character by character.
    pub fn type_text(&mut self, text: &str) {
        for c in text.chars() {
            let name = if c == ' ' {
                "space".to_string()
            } else {
                c.to_string()
            };
            self.press(&name);
        }
    }

    /// The id of the last question asked, and its model.
    pub fn asked(&self) -> (JobId, String) {
        let mut asks = self.effects.iter().filter_map(|e| match e.request() {
            Some(Ask { id, model, .. }) => Some((*id, model.clone())),
            _ => None,
        });
        asks.next_back().expect("something was asked")
    }

    /// The screen as text.
    pub fn frame(&self, columns: u16, rows: u16) -> String {
        let mut terminal = Terminal::new(TestBackend::new(columns, rows)).unwrap();
        terminal
            .draw(|frame| views::draw(frame, &self.model))
            .unwrap();
        let buffer = terminal.backend().buffer();
        let line = |y| {
            let cells = (0..columns).map(|x| buffer[(x, y)].symbol());
            cells.collect::<String>().trim_end().to_string()
        };
        (0..rows).map(line).collect::<Vec<_>>().join("\n")
    }
}

/// A scenario as it is opened; bundled ones under the shipped thresholds are read once for all tests.
pub fn opened(
    entry: &Entry,
    ego: &EgoSelection,
    thresholds: &Thresholds,
) -> Result<Opened, String> {
    type Read = HashMap<(EntryLocation, Option<i64>), Result<Opened, String>>;
    static READ: Mutex<Option<Read>> = Mutex::new(None);
    let taken = match ego {
        EgoSelection::Beside => None,
        EgoSelection::Obstacle(id) => Some(*id),
        _ => return Opened::read(entry, ego, thresholds),
    };
    if !matches!(entry.place, EntryLocation::Bundled(_)) || !thresholds.changes().is_empty() {
        return Opened::read(entry, ego, thresholds);
    }
    let key = (entry.place.clone(), taken);
    let read = || READ.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(opened) = read().get_or_insert_default().get(&key) {
        return opened.clone();
    }
    let opened = Opened::read(entry, ego, thresholds);
    read().get_or_insert_default().insert(key, opened.clone());
    opened
}

/// An answer of `model` that says `dangerous` and names an obstacle.
pub fn answer(model: &str, dangerous: bool, obstacle: i64) -> Answer {
    let verdict = Verdict {
        task: Task::Collision,
        dangerous,
        obstacles: vec![ObstacleRisk {
            id: obstacle,
            risk_score: if dangerous { 0 } else { 3 },
            reason: "r".into(),
            written_score: None,
        }],
        justification: format!("{model} says so"),
        critical: None,
        probability: None,
        token_probability: None,
        unknown: Vec::new(),
    };
    Answer {
        run: None,
        model: model.into(),
        past: None,
        window: Some((51, 60)),
        times: TimeOrigin::Recording,
        how: "ego · base".into(),
        model_returned: None,
        judged: JudgeOutcome::Verdict(Parsed {
            verdict,
            how: ParseQuality::Strict,
        }),
        text: "the answer".into(),
        reasoning: "the reasoning".into(),
        tool_rounds: Vec::new(),
        consumed: Consumed {
            input_tokens: Some(2000),
            output_tokens: Some(100),
            duration_ms: Some(6100),
            ..Consumed::default()
        },
        price_source: None,
        finish: Some("stop".into()),
    }
}

/// An answer without a verdict.
pub fn no_verdict(model: &str, text: &str) -> Answer {
    Answer {
        judged: JudgeOutcome::Missing(MissingVerdict::NotInAnswer(
            "no JSON object in the answer".into(),
        )),
        text: text.into(),
        ..answer(model, false, 1)
    }
}
