//! Plausible results of effects: answers, ratings, batches, facts.

use std::collections::HashMap;
use std::sync::{Mutex, OnceLock};

use super::super::bench::answer;
use super::super::driven::planned;
use super::super::generated::generated;
use super::super::kept::FIRST;
use super::super::written::unwritten;
use super::world::{CLAIMS, HOSTILE};
use crate::evaluation::Answer;
use crate::evaluation::batch::Estimate;
use crate::evaluation::generating::Progress as Heard;
use crate::formats::{EgoSelection, Entry};
use crate::generation::Progress;
use crate::metrics::Thresholds;
use crate::store::{Choice, RatedAnswer, Rating, RunId};
use crate::tui::loaded::{Facts, Generated, VariantRequest, Verdicts, Working};
use crate::tui::message::Msg;
use crate::tui::message::making::{MakeAsk, MakeNews};
use crate::tui::message::planning::{PlanAsk, PlanNews};
use crate::tui::message::runs::{BatchAsk, BatchNews, Counts, Ended};
use crate::verdict::Task;

/// The answer of a number.
pub fn stored(n: usize) -> Answer {
    let model = ["lab/small", "lab/large", "lab/\u{1b}[31mred"][n % 3];
    Answer {
        run: Some(RunId(n as i64)),
        how: ["ego · base", "ego · cp+cot+icl", "cartesian · cp"][n / 3 % 3].into(),
        text: [CLAIMS, HOSTILE, "so be it"][n % 3].into(),
        reasoning: CLAIMS.repeat(n % 9),
        ..answer(model, n.is_multiple_of(2), 301)
    }
}

pub fn rating() -> Rating {
    let rated = |model: &str, wrong| RatedAnswer {
        run: None,
        model: model.into(),
        prompt: "ego · base".into(),
        wrong,
        reason: wrong.then(|| HOSTILE.into()),
    };
    Rating {
        id: 1,
        created_ms: 0,
        person: HOSTILE.into(),
        scenario: FIRST.into(),
        task: Task::Collision,
        blind: true,
        seed: 1,
        choice: Choice::Best(0),
        notes: HOSTILE.into(),
        answers: vec![rated("lab/small", false), rated(HOSTILE, true)],
    }
}

pub fn batch(ask: BatchAsk, n: usize) -> Vec<Msg> {
    let batch = |news| Msg::Batch(news);
    match ask {
        BatchAsk::Count(id, asked) => vec![batch(BatchNews::Counted(
            id,
            Counts {
                looked: asked.entries.len().saturating_sub(n % 4 / 3),
                unlabelled: n % 2,
                estimate: Estimate {
                    requests: n as u64 % 9,
                    stored: n as u64 % 2,
                    unaskable: 1,
                    why: vec![(HOSTILE.into(), 1)],
                    usd: 0.1,
                    unbounded: n as u64 % 9,
                    million: 2.0,
                    ..Estimate::default()
                },
                refused: n.is_multiple_of(5).then(|| HOSTILE.into()),
                at_once: 4,
                ..Counts::default()
            },
        ))],
        BatchAsk::Begin(id, asked) => {
            let mut msgs = vec![batch(BatchNews::Named(
                id,
                format!("b{n}"),
                asked.entries.len(),
            ))];
            for place in 0..asked.entries.len() {
                msgs.push(batch(BatchNews::Ended(
                    id,
                    match place % 4 {
                        0 => Err(format!("the server is gone {HOSTILE}")),
                        _ => Ok(Ended {
                            about: None,
                            answer: Box::new(stored(place)),
                            truth: Some(true),
                        }),
                    },
                )));
            }
            if !n.is_multiple_of(3) {
                msgs.push(batch(BatchNews::Over(id)));
            }
            msgs
        }
        BatchAsk::Stop(id) => vec![batch(BatchNews::Over(id))],
        BatchAsk::StopCounting => Vec::new(),
    }
}

/// The planner drives to the end, fails, or is never heard of again.
pub fn plan(ask: PlanAsk, n: usize) -> Vec<Msg> {
    let PlanAsk::Begin(id, entry, change, forecast) = ask else {
        return Vec::new();
    };
    let ended = match n % 4 {
        0 => Err(format!("no way leads there {HOSTILE}")),
        // Changed scenes contain no drive here.
        _ if change.is_some() => return Vec::new(),
        _ => planned(&entry, forecast),
    };
    let news = [
        PlanNews::Planned(id, 1, 100),
        PlanNews::Ended(id, ended.map(Box::new)),
    ];
    news.into_iter()
        .take(1 + usize::from(!n.is_multiple_of(5)))
        .map(Msg::Plan)
        .collect()
}

pub fn make(ask: MakeAsk, n: usize) -> Vec<Msg> {
    let (id, wish) = match ask {
        MakeAsk::Begin(id, wish) => (id, wish),
        MakeAsk::Stop(id) => return vec![Msg::Make(MakeNews::Stopped(id))],
        MakeAsk::Save(..) => return Vec::new(),
    };
    let progress = Progress {
        tried: n,
        ..Progress::default()
    };
    let ended = match n % 4 {
        0 => Err(format!("nothing can be tried {HOSTILE}")),
        1 | 2 if wish.writer.is_some() => Ok(unwritten(HOSTILE)),
        // Only of one scenario, unchanged: a search takes long.
        1 if wish.entry.name.contains("RightTurn") && wish.change.is_none() => {
            let wish = VariantRequest {
                only: None,
                seed: 1,
                ..*wish
            };
            generated(&wish)
        }
        _ => Ok(Generated::Nothing(HOSTILE.into())),
    };
    let news = [
        MakeNews::Working(id, Working::Driving(1, n)),
        MakeNews::Working(id, Working::Searching(progress, 600)),
        MakeNews::Heard(id, Heard::Choosing),
        MakeNews::Ended(id, ended),
    ];
    news.into_iter().take(1 + n % 4).map(Msg::Make).collect()
}

pub fn facts(entry: &Entry) -> Result<Facts, String> {
    static READ: OnceLock<Mutex<HashMap<String, Result<Facts, String>>>> = OnceLock::new();
    let mut read = READ
        .get_or_init(Mutex::default)
        .lock()
        .unwrap_or_else(|e| e.into_inner());
    let fresh = || {
        Facts::read(
            entry,
            &EgoSelection::Beside,
            Thresholds::shipped(),
            &Verdicts::default(),
        )
    };
    read.entry(entry.name.clone()).or_insert_with(fresh).clone()
}
