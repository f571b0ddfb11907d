//! A workbench whose history reads a store in memory with three runs.

use super::bench::Bench;
use crate::features::history::request::{HistoryCommand, Judging, Truths, answer};
use crate::message::{Effect, Msg};
use crate::request::Request;
use nearmiss_formats::EgoSelection;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::{ParsedAnswer, Task, Verdict};
use nearmiss_store::{AnswerPiece, Claim, Consumed, Ending, NewRun, RunId, RunState, Store};

/// A workbench whose history reads a store of its own.
pub struct Fixture {
    pub bench: Bench,
    pub store: Store,
    truths: Truths,
}

impl Fixture {
    pub fn new() -> Self {
        Self {
            bench: Bench::bundled(),
            store: Store::in_memory().unwrap(),
            truths: Truths::default(),
        }
    }

    /// A run on a scenario, answered by this model with yes or no.
    pub fn add(&mut self, scenario: &str, model: &str, dangerous: bool, words: &str) -> RunId {
        let opened = self.bench.model.opened.as_ref().unwrap();
        let ours = opened.name == scenario;
        let run = NewRun {
            sample: 0,
            batch: None,
            scenario: scenario.into(),
            scenario_hash: Some(if ours { opened.scenario.hash.to_string() } else { format!("not the hash of {scenario}") }),
            ego: if ours { opened.scene.as_ref().unwrap().ego.to_string() } else { "1".into() },
            task: Task::Safety,
            frame: "cartesian".into(),
            techniques: "cp".into(),
            window: Some((20, 29)),
            model: model.into(),
            provider: "lab".into(),
            dialect: Some("openai_chat".into()),
            endpoint: "lab (http://127.0.0.1/v1)".into(),
            address: Some("http://127.0.0.1/v1".into()),
            template: "safety-cartesian.md".into(),
            template_version: Some("1".into()),
            template_hash: "0".repeat(64),
            messages: r#"[{"role":"system","content":"Be brief.\u001b[31m"},{"role":"user","content":"Is it?"}]"#.into(),
            parameters: "{}".into(),
            answer_schema: None,
            images: Vec::new(),
        };
        let Claim::Granted(id) = self.store.claim(&run, true).unwrap() else {
            panic!("fresh questions are granted");
        };
        self.store
            .append(
                id,
                &[AnswerPiece::Reasoning("hm"), AnswerPiece::Answer(words)],
            )
            .unwrap();
        let verdict = Verdict {
            task: Task::Safety,
            dangerous,
            obstacles: Vec::new(),
            justification: words.into(),
            critical: None,
            probability: None,
            token_probability: None,
            unknown: Vec::new(),
        };
        let ending = Ending {
            verdict: Some(ParsedAnswer::Verdict(verdict)),
            consumed: Consumed {
                input_tokens: Some(2000),
                output_tokens: Some(150),
                cost_usd: Some(0.0125),
                first_chunk_ms: Some(300),
                duration_ms: Some(2500),
                ..Consumed::default()
            },
            price_source: Some("tokens times listed prices".into()),
            ..Ending::bare(RunState::Answered)
        };
        self.store.finish(id, &ending).unwrap();
        id
    }

    /// Answers what the history asked for, until nothing is left.
    pub fn settle(&mut self) {
        let judging = Judging {
            ego: EgoSelection::Beside,
            thresholds: std::sync::Arc::new(Thresholds::shipped().clone()),
        };
        loop {
            let effects = std::mem::take(&mut self.bench.effects);
            let (asks, others) = requests(effects);
            self.bench.effects = others;
            if asks.is_empty() {
                return;
            }
            for ask in asks {
                for news in answer(&self.store, &judging, &mut self.truths, ask) {
                    self.bench.send(Msg::reply::<HistoryCommand>(news));
                }
            }
        }
    }

    pub fn press(&mut self, keys: &str) {
        self.bench.press(keys);
        self.settle();
    }

    pub fn type_text(&mut self, text: &str) {
        self.bench.type_text(text);
        self.settle();
    }

    /// Numbers of the runs at hand.
    pub fn rows(&self) -> Vec<i64> {
        let rows = &self.bench.model.history.rows;
        rows.iter().map(|run| run.run).collect()
    }

    pub fn deleted(&self, id: RunId) -> bool {
        self.store.run(id).unwrap().unwrap().deleted_ms.is_some()
    }
}

/// The requests of one type among effects, and the others.
pub fn requests<R: Request>(effects: Vec<Effect>) -> (Vec<R>, Vec<Effect>) {
    let mut others = Vec::new();
    let mut requests = Vec::new();
    for effect in effects {
        match effect.into_request() {
            Ok(request) => requests.push(request),
            Err(other) => others.push(other),
        }
    }
    (requests, others)
}

pub const FIRST: &str = "ZAM_HardBraking-1_1_T-1";

pub fn three() -> Fixture {
    let mut kept = Fixture::new();
    kept.add(FIRST, "lab/small", true, "the lead car brakes hard");
    kept.add("ZAM_Lost-1_1_T-1", "lab/large", false, "nothing is near");
    kept.add(FIRST, "lab/large", false, "there is room to brake");
    kept.press("ctrl-r");
    kept
}
