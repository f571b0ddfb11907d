//! Made-up but plausible results of effects, for the random-input test: answers, ratings, batches, facts.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock};
use std::time::Duration;

use crate::features::answers::Ask;
use crate::features::batch::request::{
    AskBatch, BatchAnswer, BatchProgress, BatchUpdate, EstimateBatch, ItemChange,
};
use crate::features::experiment::request::{
    AskExperiment, ExperimentNews, ExperimentWritten, ListExperiments, ReadExperiment,
    WriteExperiment,
};
use crate::features::generation::request::{Generate, GenerationUpdate};
use crate::features::index::ReadIndex;
use crate::features::planner::request::{Plan, PlanUpdate};
use crate::loaded::{
    Facts, GenerationOutcome, GenerationProgress, GenerationStage, VariantRequest, Verdicts,
};
use crate::message::{Effect, Msg};
use crate::model::{Batch, CountedExperiment, Counts, ExperimentOutline, JobId, JobKind, Update};
use crate::request::Request;
use crate::tests::bench::{answer, generated_variant, no_verdict, planned};
use crate::tests::experiment_screen::{counted, outline};
use crate::tests::history::FIRST;
use crate::tests::random::world::{CLAIMS, HOSTILE};
use crate::tests::written::unwritten;
use nearmiss_ask::llm::Chunk;
use nearmiss_drive::generation::Progress;
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::corpus::{
    CorpusIndex, IndexedWindow, Manoeuvre, RoadType, SEVERITIES, WindowEgo,
};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{BatchId, Choice, ItemState, RatedAnswer, Rating, RunId};
use nearmiss_study::evaluation::batch::Estimate;
use nearmiss_study::evaluation::generating::Progress as TerminationSignal;
use nearmiss_study::evaluation::{Answer, Event};
use nearmiss_workflow::batch::DryRunLine;
use nearmiss_workflow::{ExperimentFile, FolderOfExperiments};

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
        template: None,
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

/// The replies to a job under this number.
fn replies<R: Request<Reply = (JobId, T)>, T>(id: JobId, updates: Vec<T>) -> Option<Vec<Msg>> {
    let updates = updates.into_iter();
    Some(
        updates
            .map(|update| Msg::reply::<R>((id, update)))
            .collect(),
    )
}

/// What a job tells, as far as it comes; `None` for other effects.
pub fn job(effect: &Effect, n: usize) -> Option<Vec<Msg>> {
    if let Some(Ask { id, model, .. }) = effect.request() {
        return replies::<Ask, _>(*id, question(model, n));
    }
    if let Some(plan) = effect.request::<Plan>() {
        return replies::<Plan, _>(plan.id, planning(plan, n));
    }
    if let Some(Generate { id, request }) = effect.request() {
        return replies::<Generate, _>(*id, generate((**request).clone(), n));
    }
    if let Some(EstimateBatch { id, batch }) = effect.request() {
        return replies::<EstimateBatch, _>(*id, vec![estimate(batch, n)]);
    }
    if let Some(AskBatch { id, batch }) = effect.request() {
        return replies::<AskBatch, _>(*id, ask(batch, n));
    }
    if let Some(ReadExperiment { id, .. }) = effect.request() {
        return replies::<ReadExperiment, _>(*id, read(n));
    }
    if let Some(AskExperiment { id, .. }) = effect.request() {
        return replies::<AskExperiment, _>(*id, ask_experiment(n));
    }
    if let Some(WriteExperiment { id, file, .. }) = effect.request() {
        return replies::<WriteExperiment, _>(*id, vec![write(file.clone(), n)]);
    }
    if let Some(ReadIndex { id, folder }) = effect.request() {
        let ended = match n % 3 {
            0 => Err(HOSTILE.into()),
            _ => Ok(Arc::new(index(folder.clone(), n))),
        };
        let all = vec![Update::Progress((n as u64, 100)), Update::Ended(ended)];
        return replies::<ReadIndex, _>(*id, all);
    }
    None
}

/// An index of windows of a scenario with a hostile name.
fn index(folder: PathBuf, n: usize) -> CorpusIndex {
    let window = |place: usize| IndexedWindow {
        ego: WindowEgo::Obstacle(place as i64),
        obstacle: i64::MAX,
        kind: "car",
        steps: (i64::MIN, i64::MAX),
        manoeuvre: Manoeuvre::ALL[place % Manoeuvre::ALL.len()],
        road: RoadType::ALL[(place + n) % RoadType::ALL.len()],
        severity: (place % SEVERITIES) as u8,
        worst_step: i64::MAX,
        values: Vec::new(),
    };
    let windows = (0..n % 200).map(|place| (HOSTILE, "00", window(place), place % 2 == 0));
    CorpusIndex::of_windows(folder, &windows.collect::<Vec<_>>())
}

/// What a job tells that was cancelled.
pub fn cancelled(id: JobId, kind: Option<JobKind>) -> Vec<Msg> {
    match kind {
        Some(JobKind::Batch) => vec![Msg::reply::<AskBatch>((id, Update::Ended(Ok(()))))],
        Some(JobKind::Generate) => vec![Msg::reply::<Generate>((id, Update::Cancelled))],
        _ => Vec::new(),
    }
}

/// What comes of a question: pieces, and mostly the end.
fn question(model: &str, n: usize) -> Vec<Update<Event, Box<Answer>>> {
    let whole = match n % 4 {
        0 => Err(format!("the store is full {HOSTILE}")),
        1 => Ok(Box::new(no_verdict(model, HOSTILE))),
        _ => Ok(Box::new(stored(n))),
    };
    let pieces = [
        Event::Kept(RunId(1000 + n as i64)),
        Event::Chunk(Chunk::Note(format!("seed is not sent {HOSTILE}"))),
        Event::Chunk(Chunk::Started {
            model: Some(format!("other {HOSTILE}")),
        }),
        Event::Chunk(Chunk::Reasoning(format!("thinking {HOSTILE}"))),
        Event::Chunk(Chunk::Retrying {
            attempt: 2,
            wait: Duration::from_secs(2),
            why: HOSTILE.into(),
        }),
        Event::Chunk(Chunk::Text(CLAIMS.into())),
    ]
    .into_iter()
    .take(1 + n % 7)
    .map(Update::Progress);
    // Some never end.
    let ended = (!n.is_multiple_of(5)).then_some(Update::Ended(whole));
    pieces.chain(ended).collect()
}

fn estimate(batch: &Batch, n: usize) -> Update<Counts, Counts> {
    Update::Progress(Counts {
        looked: batch.entries.len().saturating_sub(n % 4 / 3),
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
    })
}

fn ask(batch: &Batch, n: usize) -> Vec<BatchUpdate> {
    let answered = |place: usize| match place % 4 {
        0 => Err(format!("the server is gone {HOSTILE}")),
        _ => Ok(BatchAnswer {
            about: None,
            answer: Box::new(stored(place)),
            truth: Some(true),
        }),
    };
    let count = batch.entries.len();
    let mut progress = vec![BatchProgress::Named(format!("b{n}"), count)];
    progress.extend((0..count).map(|place| BatchProgress::Answered(answered(place))));
    let progress = progress.into_iter().map(Update::Progress);
    let ended = (!n.is_multiple_of(3)).then_some(Update::Ended(Ok(())));
    progress.chain(ended).collect()
}

/// The planner drives to the end, fails, or is never heard of again.
fn planning(plan: &Plan, n: usize) -> Vec<PlanUpdate> {
    let ended = match n % 4 {
        0 => Err(format!("no way leads there {HOSTILE}")),
        // Changed scenes contain no drive here.
        _ if plan.change.is_some() => return Vec::new(),
        _ => planned(&plan.entry, plan.forecast),
    };
    let updates = [
        Update::Progress((1, 100)),
        Update::Ended(ended.map(Box::new)),
    ]
    .into_iter()
    .take(1 + usize::from(!n.is_multiple_of(5)));
    updates.collect()
}

fn generate(request: VariantRequest, n: usize) -> Vec<GenerationUpdate> {
    let progress = Progress {
        tried: n,
        ..Progress::default()
    };
    let ended = match n % 4 {
        0 => Err(format!("nothing can be tried {HOSTILE}")),
        1 | 2 if request.writer.is_some() => Ok(unwritten(HOSTILE)),
        // Only of one scenario, unchanged: a search takes long.
        1 if request.entry.name.contains("RightTurn") && request.change.is_none() => {
            generated_variant(&VariantRequest {
                style: Default::default(),
                only: None,
                wish: None,
                attackers: 1,
                seed: 1,
                ..request
            })
        }
        _ => Ok(GenerationOutcome::Nothing(HOSTILE.into())),
    };
    let updates = [
        Update::Progress(GenerationProgress::Working(GenerationStage::Driving(1, n))),
        Update::Progress(GenerationProgress::Working(GenerationStage::Searching(
            progress, 600,
        ))),
        Update::Progress(GenerationProgress::Model(TerminationSignal::Choosing {
            vote: 0,
            of: 3,
        })),
        Update::Ended(ended),
    ]
    .into_iter()
    .take(1 + n % 4);
    updates.collect()
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

/// What reading a file tells.
pub fn read(n: usize) -> Vec<Update<ExperimentNews, Box<CountedExperiment>>> {
    let outline = ExperimentOutline {
        title: Some(HOSTILE.into()),
        facts: vec![("select", HOSTILE.into())],
        is_split: n.is_multiple_of(2),
        ..outline()
    };
    let text = format!("title = \"{HOSTILE}\"\n").repeat(n % 50);
    let read = Box::new((text, (!n.is_multiple_of(5)).then_some(outline)));
    let ended = match n % 5 {
        0 => Err(format!("e.toml:3: {HOSTILE}\ne.toml:4: {HOSTILE}")),
        _ => Ok(Box::new(CountedExperiment {
            refused: match n % 4 {
                0 => vec![("lab/small".into(), HOSTILE.into())],
                _ => Vec::new(),
            },
            lines: vec![DryRunLine::Reason(HOSTILE.into())],
            requests: n as u64 % 3,
            doubts: vec![HOSTILE.into(); n % 3],
            ..counted((n % 2 == 1).then_some(BatchId(1)))
        })),
    };
    let news = [
        Update::Progress(ExperimentNews::Read(read)),
        Update::Progress(ExperimentNews::Working(HOSTILE.into())),
    ];
    // Some never end.
    let ended = (!n.is_multiple_of(7)).then_some(Update::Ended(ended));
    news.into_iter().chain(ended).collect()
}

/// What asking one tells.
pub fn ask_experiment(n: usize) -> Vec<BatchUpdate> {
    let mut way = counted(None).progress.configurations[n % 2]
        .configuration
        .clone();
    if n.is_multiple_of(3) {
        way.model = HOSTILE.into();
    }
    let change = ItemChange {
        way,
        before: ItemState::Waiting,
        now: [ItemState::Answered, ItemState::Failed, ItemState::Truncated][n % 3],
    };
    let news = [
        BatchProgress::Named("b1".into(), 21),
        BatchProgress::Changed(Box::new(change)),
        BatchProgress::Answered(Err(HOSTILE.into())),
    ];
    let ended = (n.is_multiple_of(2)).then_some(Update::Ended(Ok(())));
    let news = news.into_iter().map(Update::Progress);
    news.chain(ended).collect()
}

/// What writing one tells.
pub fn write(file: PathBuf, n: usize) -> Update<(), ExperimentWritten> {
    Update::Ended(match n % 3 {
        0 => Err(HOSTILE.into()),
        1 => Ok(ExperimentWritten::Exists(file)),
        _ => Ok(ExperimentWritten::Written(file)),
    })
}

/// What is in a folder.
pub fn listed(folder: PathBuf, n: usize) -> Msg {
    let listed = FolderOfExperiments {
        files: vec![ExperimentFile {
            path: folder.join(format!("{HOSTILE}.toml")),
            title: Some(HOSTILE.into()),
        }],
        folders: vec![folder.join("more")],
    };
    let read = match n % 4 {
        0 => Err(HOSTILE.into()),
        _ => Ok(listed),
    };
    Msg::reply::<ListExperiments>((folder, read))
}
