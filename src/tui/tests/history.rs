//! The history of runs, over a store in memory.

use crate::features::answers::LoadStored;
use crate::features::history::HistoryScreen;
use crate::features::history::request::{HistoryCommand, HistoryEvent, Judging, Truths, answer};
use crate::message::{Effect, Msg};
use crate::model::{Notice, ShownAnswer};
use crate::request::Request;
use crate::tests::bench::Bench;
use nearmiss_formats::EgoSelection;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::{CriticalObstacle, ParsedAnswer, Task, Verdict};
use nearmiss_store::{AnswerPiece, Claim, Consumed, Ending, NewRun, RunId, RunState, Store};

#[test]
fn words_and_filters_narrow_it_down_as_one_types() {
    let mut kept = three();
    assert_eq!(kept.rows(), [3, 2, 1]);
    assert_eq!(kept.bench.model.history.total, Some(3));
    kept.press("/");
    kept.type_text("brak");
    assert_eq!(kept.rows(), [3, 1]);
    kept.type_text(" verdict:dan");
    assert_eq!(kept.rows(), [1]);
    kept.type_text("x");
    let frame = kept.bench.frame(120, 30);
    assert!(
        frame.contains("available: dangerous, safe, none"),
        "{frame}"
    );
    assert_eq!(
        kept.rows(),
        [1],
        "a line that means nothing changes nothing"
    );
    kept.press("backspace enter");
    kept.press("esc /");
    kept.type_text("large");
    assert_eq!(kept.rows(), [3, 2], "a part of the model's name");
    kept.type_text(" lost");
    assert_eq!(kept.rows(), [2], "and a word of the scenario's");
    kept.press("enter esc");
    assert_eq!(kept.rows(), [3, 2, 1], "Esc clears the search first");
    kept.press("esc");
    assert!(kept.bench.model.screens.is_empty());
}

#[test]
fn a_hit_in_the_name_leaves_how_was_asked_in_sight() {
    let mut kept = three();
    let row = |kept: &Fixture| {
        let frame = kept.bench.frame(100, 30);
        let row = frame.lines().find(|line| line.contains('▸'));
        row.unwrap().to_string()
    };
    let before = row(&kept);
    assert!(before.contains("safety cart cp"), "{before}");
    kept.press("/");
    kept.type_text("lost");
    let found = row(&kept);
    assert!(
        found.contains("ZAM_Lost-1_1_T-1 ") && found.contains("safety cart cp"),
        "{found}"
    );
    assert!(!found.contains('['), "{found}");
}

#[test]
fn a_deletion_is_taken_back_and_the_one_before_it_too() {
    let mut kept = three();
    kept.press("d d");
    assert_eq!(kept.rows(), [1]);
    assert!(kept.deleted(RunId(3)) && kept.deleted(RunId(2)));
    kept.press("u");
    assert_eq!(kept.rows(), [2, 1]);
    kept.press("u");
    assert_eq!(kept.rows(), [3, 2, 1]);
    kept.press("u");
    assert!(!kept.deleted(RunId(3)) && !kept.deleted(RunId(2)));
    kept.press("g g p d");
    let top = RunId(kept.rows()[0]);
    assert!(kept.store.run(top).unwrap().unwrap().pinned && !kept.deleted(top));
    // Another process pinned the next one meanwhile: it comes back, with a message.
    kept.press("j");
    let next = kept.bench.model.history.current().unwrap();
    kept.store.pin(next, true).unwrap();
    kept.press("d");
    assert_eq!(kept.rows(), [3, 2, 1]);
    assert_eq!(kept.bench.model.toasts.last().unwrap().kind, Notice::Error);
    assert!(kept.bench.model.history.undo.is_empty());
}

#[test]
fn deleted_runs_are_listed_and_restored() {
    let mut kept = three();
    kept.press("d /");
    kept.type_text("deleted");
    kept.press("enter");
    assert_eq!(kept.rows(), [3]);
    kept.press("d");
    assert!(!kept.deleted(RunId(3)));
}

#[test]
fn notes_are_written_and_found() {
    let mut kept = three();
    kept.press("n");
    kept.type_text("odd one");
    kept.press("enter /");
    kept.type_text("odd");
    assert_eq!(kept.rows(), [3]);
    assert!(kept.bench.frame(120, 40).contains("odd one"));
}

#[test]
fn a_reopened_answer_shows_its_window_and_the_obstacle_it_calls_critical() {
    let mut kept = Fixture::new();
    let worst = kept.bench.model.picked;
    let opened = kept.bench.model.opened.as_ref().unwrap();
    let ego = opened.scene.as_ref().unwrap().ego.id;
    let mut others = { opened.scenario.obstacles.iter() }.map(|o| o.id);
    kept.critical = others.find(|id| *id != ego && Some(*id) != worst);
    kept.task = Task::Collision;
    kept.add(FIRST, "lab/small", true, "it brakes");
    kept.press("ctrl-r");
    kept.press("enter");
    let model = &kept.bench.model;
    assert_eq!((model.task, model.clock.step()), (Task::Collision, 29));
    assert_eq!(model.shown_window(), Some((20, 29)));
    assert_ne!(model.window().map(|w| w.last()), Some(29));
    assert_eq!(model.picked, kept.critical);
}

#[test]
fn enter_opens_the_scenario_as_it_was_asked_about() {
    let mut kept = three();
    kept.bench.model.list.set_filter("merge".into());
    kept.press("j j enter");
    let model = &kept.bench.model;
    assert!(model.screens.is_empty() && model.reopening.is_none());
    assert_eq!(model.opened.as_ref().unwrap().name, FIRST);
    assert_eq!(
        (model.task, model.frame.name()),
        (Task::Safety, "cartesian")
    );
    assert_eq!(
        (model.techniques.to_string().as_str(), model.clock.step()),
        ("cp", 29)
    );
    let column = model.answers.column().unwrap();
    assert_eq!(
        (column.model.as_str(), column.steps),
        ("lab/small", Some((20, 29)))
    );
    assert!(column.truth.is_some());
    assert_eq!(
        model.list.current(),
        model.list.opened,
        "the filter that hid it is gone"
    );
    // The other earlier answers come beside it.
    let mut loads = kept.bench.effects.iter().rev();
    let of = loads
        .find_map(|effect| match effect.request() {
            Some(LoadStored(of)) => Some(of.clone()),
            _ => None,
        })
        .unwrap();
    let runs = kept
        .store
        .of_scenario(&of.scenario, &of.name, of.task, 9)
        .unwrap();
    let answers = runs
        .into_iter()
        .map(nearmiss_study::evaluation::Answer::from)
        .collect();
    kept.bench.send(Msg::reply::<LoadStored>((of, answers)));
    let model = &kept.bench.model;
    assert_eq!(model.answers.columns.len(), 2);
    assert!(matches!(model.answers.shown, ShownAnswer::Column(_)));
    assert_eq!(model.answers.column().unwrap().model, "lab/small");
}

#[test]
fn a_scenario_that_is_not_there_is_said_and_nothing_changes() {
    let mut kept = three();
    kept.press("j enter");
    assert!(kept.bench.model.screens.is_top::<HistoryScreen>());
    assert_eq!(kept.bench.model.screens.iter().count(), 1);
    let said = &kept.bench.model.toasts.last().unwrap().text;
    assert!(
        said.contains("ZAM_Lost-1_1_T-1 is not in the list"),
        "{said}"
    );
}

#[test]
fn the_details_hold_the_run_against_the_built_in_judge() {
    let mut kept = three();
    kept.bench.model.size = (200, 60);
    let frame = kept.bench.frame(200, 60);
    for words in [
        "built-in     = no",
        "2,000 in, 150 out",
        "0.0125 US dollars (tokens times listed prices)",
        "2.5 s, 300 ms to first token",
        "20 to 29",
        "── message: user ──",
        "there is room to brake",
        "Be brief.␛[31m",
    ] {
        assert!(frame.contains(words), "{words}: {frame}");
    }
    kept.press("j");
    assert!(kept.bench.frame(200, 60).contains("built-in     unknown"));
}

#[test]
fn what_others_write_appears_and_the_selection_stays() {
    let mut kept = three();
    kept.press("j");
    let selected = kept.bench.model.history.current();
    kept.add(FIRST, "lab/new", true, "x");
    kept.bench
        .send(Msg::reply::<HistoryCommand>(HistoryEvent::Changed));
    kept.settle();
    assert_eq!(kept.rows(), [4, 3, 2, 1]);
    assert_eq!(kept.bench.model.history.current(), selected);
    assert_eq!(kept.bench.model.history.total, Some(4));
}

#[test]
fn only_a_stretch_of_a_long_list_is_at_hand() {
    let mut kept = Fixture::new();
    for n in 0..1500 {
        kept.add("ZAM_Lost-1_1_T-1", &format!("lab/{n}"), n % 3 == 0, "x");
    }
    kept.press("ctrl-r");
    assert_eq!(kept.rows().len(), 100);
    kept.bench.frame(120, 40);
    for _ in 0..80 {
        kept.press("pagedown");
    }
    let rows = kept.rows();
    assert!(rows.len() <= 600 && rows.is_sorted_by(|a, b| a > b));
    assert_eq!(kept.bench.model.history.current(), Some(RunId(1)));
    kept.press("g g");
    assert_eq!(kept.bench.model.history.current(), Some(RunId(1500)));
    kept.press("shift-g");
    assert_eq!(kept.bench.model.history.current(), Some(RunId(1)));
    for _ in 0..80 {
        kept.press("pageup");
    }
    assert_eq!(kept.bench.model.history.current(), Some(RunId(1500)));
    assert!(kept.rows().is_sorted_by(|a, b| a > b));
}

#[test]
fn old_lists_are_dropped() {
    let mut kept = three();
    kept.bench.press("/");
    kept.bench.type_text("brak");
    let asks: Vec<_> = kept.bench.effects.drain(..).collect();
    let mut ids = asks.iter().filter_map(|effect| match effect.request() {
        Some(HistoryCommand::Page(id, _, edge, _)) => Some((*id, *edge)),
        _ => None,
    });
    let (id, edge) = ids.next().unwrap();
    assert!(ids.next().is_some(), "one for every letter");
    let news = HistoryEvent::Page(id, edge, Ok(nearmiss_store::Page::default()));
    kept.bench.send(Msg::reply::<HistoryCommand>(news));
    assert_eq!(kept.rows(), [3, 2, 1]);
}

#[test]
fn the_listed_runs_are_exported_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.jsonl");
    let mut kept = three();
    let hidden = "so \u{202e}far\u{200b}, \u{9b}31m so good";
    kept.add(FIRST, "lab/large", false, hidden);
    kept.press("/");
    kept.type_text("model:large");
    kept.press("enter e ctrl-u");
    kept.bench.send(Msg::Paste(path.display().to_string()));
    kept.press("enter");
    let written = std::fs::read_to_string(&path).unwrap();
    let runs: Vec<_> = written
        .lines()
        .map(|l| nearmiss_store::Run::from_record(l).unwrap())
        .collect();
    assert_eq!(runs.len(), 3);
    assert!(runs.iter().any(|run| run.answer == hidden), "it is whole");
    let obeyed =
        |c: char| c != '\n' && (c.is_control() || nearmiss_scene::description::disguises(c));
    assert!(!written.contains(obeyed), "and nothing in it is obeyed");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    assert!(
        kept.bench
            .model
            .toasts
            .last()
            .unwrap()
            .text
            .contains("3 runs written")
    );
    kept.press("e ctrl-u");
    kept.bench.send(Msg::Paste(path.display().to_string()));
    kept.press("enter");
    assert!(
        kept.bench
            .model
            .toasts
            .last()
            .unwrap()
            .text
            .contains("exists already")
    );
    assert_eq!(std::fs::read_to_string(&path).unwrap(), written);
}

#[test]
fn what_cannot_be_read_is_said() {
    let mut kept = Fixture::new();
    kept.bench.press("ctrl-r");
    let page = kept
        .bench
        .effects
        .iter()
        .find_map(|effect| match effect.request() {
            Some(HistoryCommand::Page(id, _, edge, _)) => Some((*id, *edge)),
            _ => None,
        });
    let (id, edge) = page.unwrap();
    let news = HistoryEvent::Page(id, edge, Err("the file is no store".into()));
    kept.bench.send(Msg::reply::<HistoryCommand>(news));
    assert!(kept.bench.frame(80, 24).contains("the file is no store"));
}

/// Times stand as they are everywhere: the store's are put in place of now.
fn at_a_fixed_time(mut kept: Fixture) -> Fixture {
    let history = &mut kept.bench.model.history;
    for run in &mut history.rows {
        run.created_ms = 1_699_963_200_000 + run.run * 86_400_000;
    }
    if let Some(run) = &mut history.details {
        run.created_ms = 1_699_963_200_000;
    }
    kept.bench.model.toasts.clear();
    kept
}

fn no_time(frame: &str) -> String {
    // The clock of this place is not that of others.
    let hour = |word: &str| word.len() == 5 && word.as_bytes()[2] == b':';
    let words = frame.split(' ').map(|w| if hour(w) { "hh:mm" } else { w });
    words.collect::<Vec<_>>().join(" ")
}

#[test]
fn history_at_80_by_24() {
    let kept = at_a_fixed_time(three());
    insta::assert_snapshot!(no_time(&kept.bench.frame(80, 24)));
}

#[test]
fn history_at_200_by_60() {
    let kept = at_a_fixed_time(three());
    insta::assert_snapshot!(no_time(&kept.bench.frame(200, 60)));
}

#[test]
fn what_tells_runs_apart_is_whole_and_the_date_goes_first() {
    let mut kept = Fixture::new();
    let (name, model) = ("DEU_Aschaffenburg-26_12_T-1", "lab/gemini-1.5-pro");
    kept.add(name, model, true, "it is near");
    kept.press("ctrl-r");
    let row = |columns| {
        let frame = kept.bench.frame(columns, 24);
        let row = frame.lines().find(|line| line.contains('▸')).unwrap();
        row.to_string()
    };
    let narrow = row(80);
    for words in [name, " gemini-1.5-pro ", "safety cart cp"] {
        assert!(narrow.contains(words), "{words}: {narrow}");
    }
    assert!(row(60).contains(name), "{}", row(60));
    let wide = row(220);
    let places = [name, model, "safety cart", ":"].map(|words| wide.find(words));
    assert!(
        places.iter().all(Option::is_some) && places.is_sorted(),
        "{wide}"
    );
}

#[test]
fn it_fits_every_size_and_its_keys_are_in_the_footer() {
    let mut kept = three();
    let last = kept.bench.frame(120, 30);
    let last = last.lines().last().unwrap();
    for words in ["reopen", "search", "pin", "delete", "undo", "Esc close"] {
        assert!(last.contains(words), "{words}: {last}");
    }
    for keys in ["", "/", "esc", "n", "esc", "e", "esc", "tab"] {
        kept.press(keys);
        for columns in [80, 81, 109, 110, 160, 300] {
            for rows in [24, 25, 40, 90] {
                kept.bench.frame(columns, rows);
            }
        }
    }
}

/// A workbench whose history reads a store of its own.
pub struct Fixture {
    pub bench: Bench,
    pub store: Store,
    truths: Truths,
    /// Of the runs that are added: their task, and what they call critical.
    task: Task,
    critical: Option<i64>,
}

impl Fixture {
    pub fn new() -> Self {
        Self {
            bench: Bench::bundled(),
            store: Store::in_memory().unwrap(),
            truths: Truths::default(),
            task: Task::Safety,
            critical: None,
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
            task: self.task,
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
            task: self.task,
            dangerous,
            obstacles: Vec::new(),
            justification: words.into(),
            critical: self.critical.map(|id| vec![CriticalObstacle::new(id)]),
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
