//! A workbench whose effects run at once, unless they need a network.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use nearmiss_ask::prompts::Library;
use nearmiss_drive::generation::Effort;
use nearmiss_drive::planner::{self, Cancel, Forecast, RuleMode, Sampling};
use nearmiss_drive::simulation::{Settings, TrafficMode};
use nearmiss_formats::{EgoSelection, Entry, EntryLocation, bundled};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::{ObstacleRisk, ParseQuality, Parsed, Task, Verdict};
use nearmiss_settings::Config;
use nearmiss_store::Consumed;
use nearmiss_study::evaluation::claims::TimeOrigin;
use nearmiss_study::evaluation::{Answer, Event, JudgeOutcome, MissingVerdict};
use nearmiss_workflow::{AttackSource, OpenRequest, PlanRequest, StandIn};
use ratatui::Terminal;
use ratatui::backend::TestBackend;

use crate::features::answers::Ask;
use crate::features::generation::request::Generate;
use crate::features::scenarios::request::{Find, Found};
use crate::features::source::ReadSource;
use crate::keymap::Key;
use crate::loaded::{
    GenerationInputs, GenerationOutcome, GenerationProgress, GenerationStage, Opened, Source,
    VariantRequest,
};
use crate::message::{Effect, Msg};
use crate::model::{JobId, Model, Update};
use crate::theme::Theme;
use crate::update::{Open, update};
use crate::views;

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

/// A piece of an answer.
pub fn piece(id: JobId, event: Event) -> Msg {
    Msg::reply::<Ask>((id, Update::Progress(event)))
}

/// A whole answer.
pub fn answered(id: JobId, result: Result<Box<Answer>, String>) -> Msg {
    Msg::reply::<Ask>((id, Update::Ended(result)))
}

/// How far the generation of a variant is.
pub fn generating(id: JobId, at: GenerationStage) -> Msg {
    let progress = Update::Progress(GenerationProgress::Working(at));
    Msg::reply::<Generate>((id, progress))
}

/// What came of the generation of a variant.
pub fn generated(id: JobId, result: Result<GenerationOutcome, String>) -> Msg {
    Msg::reply::<Generate>((id, Update::Ended(result)))
}

/// Few samples over a short horizon: a test waits for it.
pub fn coarse(forecast: Forecast) -> Settings {
    let usual = planner::Settings::default();
    Settings {
        planner: planner::Settings {
            horizon: 3.0,
            sampling: Sampling {
                durations: 2,
                speeds: 4,
                offsets: 5,
                changes: 1,
                refinements: 0,
                ..usual.sampling
            },
            // With so few samples a rule may leave no way to drive.
            rules: RuleMode::Off,
            ..usual
        },
        forecast,
        replan: 1,
        without: None,
        traffic: TrafficMode::Recorded,
        policy: None,
    }
}

/// Its ego as it lies beside it.
pub fn request<'a>(entry: &'a Entry, settings: &'a Settings) -> PlanRequest<'a> {
    PlanRequest {
        open: OpenRequest {
            entry,
            ego: &EgoSelection::Beside,
            transform: None,
            strict: false,
            stand_in: StandIn::None,
        },
        problem: None,
        settings,
    }
}

/// A bundled scenario with its ego planned, each driven once for all tests; planning takes 12 ms in all of them.
pub fn planned(entry: &Entry, forecast: Forecast) -> Result<Opened, String> {
    type Driven = HashMap<(String, &'static str), Result<Opened, String>>;
    static DRIVEN: Mutex<Option<Driven>> = Mutex::new(None);
    let mut driven = DRIVEN.lock().unwrap_or_else(PoisonError::into_inner);
    let drive = || {
        let settings = coarse(forecast);
        let thresholds = Thresholds::shipped();
        let request = request(entry, &settings);
        let mut opened = Opened::planned(&request, thresholds, &Cancel::default(), &mut |_, _| {})?
            .expect("it was not stopped");
        let planned = opened.planned.as_mut().unwrap();
        let planned = Arc::get_mut(planned).unwrap();
        for cycle in &mut planned.cycles {
            cycle.took = Duration::from_millis(12);
        }
        Ok(opened)
    };
    let key = (entry.name.clone(), forecast.name());
    let driven = driven.get_or_insert_default();
    driven.entry(key).or_insert_with(drive).clone()
}

/// Few motions: a test waits for it.
pub const SHORT: Effort = Effort {
    candidates: 90,
    rounds: 3,
    drives: 3,
    attackers: 3,
    together: 1,
    delay: 0.5,
    seed: 1,
};

/// A short search.
pub fn with(settings: &Settings) -> GenerationInputs<'_> {
    GenerationInputs {
        settings,
        planner: None,
        source: AttackSource::Search(&SHORT),
    }
}

/// Planning took 12 ms in all cycles.
pub fn in_12_ms(made: &mut GenerationOutcome) {
    if let GenerationOutcome::Found { original, variant } = made {
        for opened in [original, variant] {
            let planned = opened.planned.as_mut().unwrap();
            for cycle in &mut Arc::get_mut(planned).unwrap().cycles {
                cycle.took = Duration::from_millis(12);
            }
        }
    }
}

/// What is made of a bundled scenario, each searched for once for all tests; planning takes 12 ms in all of them.
pub fn generated_variant(wish: &VariantRequest) -> Result<GenerationOutcome, String> {
    type VariantCache =
        HashMap<(String, Option<i64>, u64, usize), Result<GenerationOutcome, String>>;
    static MADE: Mutex<Option<VariantCache>> = Mutex::new(None);
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    let make = || {
        // A folder in which nothing lies decides the name.
        let wish = VariantRequest {
            style: Default::default(),
            folder: Some("/nonexistent".into()),
            ..wish.clone()
        };
        let (settings, thresholds) = (coarse(wish.forecast), Thresholds::shipped());
        let (how, cancel) = (with(&settings), Cancel::default());
        let ego = EgoSelection::Beside;
        let mut made = Opened::generated(&wish, &ego, thresholds, &how, &cancel, &mut |_| {})?
            .expect("it was not stopped");
        in_12_ms(&mut made);
        Ok(made)
    };
    let key = (
        wish.entry.name.clone(),
        wish.only,
        wish.seed,
        wish.attackers,
    );
    made.get_or_insert_default()
        .entry(key)
        .or_insert_with(make)
        .clone()
}
