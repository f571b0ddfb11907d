//! Made-up but plausible results of experiments, for the random-input test.

use std::path::PathBuf;

use super::super::experiment_screen::{counted, outline};
use super::world::HOSTILE;
use crate::message::experiment::{
    CountedExperiment, ExperimentNews, ExperimentOutline, ExperimentWritten, ItemChange,
};
use crate::message::{BatchProgress, JobEvent, Msg, Update};
use nearmiss_store::{BatchId, ItemState};
use nearmiss_workflow::batch::DryRunLine;
use nearmiss_workflow::{ExperimentFile, FolderOfExperiments};

/// What reading a file tells.
pub fn read(n: usize) -> Vec<JobEvent> {
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
    news.into_iter()
        .chain(ended)
        .map(JobEvent::Experiment)
        .collect()
}

/// What asking one tells.
pub fn ask(n: usize) -> Vec<JobEvent> {
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
    news.chain(ended).map(JobEvent::Batch).collect()
}

/// What writing one tells.
pub fn write(file: PathBuf, n: usize) -> JobEvent {
    JobEvent::ExperimentWritten(Update::Ended(match n % 3 {
        0 => Err(HOSTILE.into()),
        1 => Ok(ExperimentWritten::Exists(file)),
        _ => Ok(ExperimentWritten::Written(file)),
    }))
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
    Msg::ExperimentFiles(folder, read)
}
