//! Commands that work on many files: one part of them, the job over them, and continuing a run that was killed.

mod job;
mod journal;

pub use job::{Done, Failed, Job, NEXT, Taken};
pub use journal::{RunJournal, Unit, holds, open_journal};

use std::path::Path;

use serde::Serialize;

use super::{Failure, output};
use nearmiss_formats::Entry;
use nearmiss_study::evaluation::batch::Shard;
use nearmiss_workflow::journal::EarlierRun;

/// One part of the scenarios.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct ShardOption {
    /// Only this part of the scenarios, such as 2/8; the name decides the part.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
}

/// One part of the scenarios, and continuing.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct ManyFiles {
    #[command(flatten)]
    pub part: ShardOption,
    /// Continue in the folder of -o where a run with --resume was stopped or killed, or begin one: finished files are
    /// kept, those of changed scenarios are made again.
    #[arg(long, requires = "output")]
    pub resume: bool,
}

impl ShardOption {
    /// The scenarios of this part; an empty part is said.
    pub fn of(self, mut entries: Vec<Entry>) -> Vec<Entry> {
        let Some(shard) = self.shard else {
            return entries;
        };
        entries.retain(|entry| shard.has(&entry.name));
        if entries.is_empty() {
            output::say(&format!("nearmiss: part {shard} has no scenarios"));
        }
        entries
    }
}

impl ManyFiles {
    /// Opens the journal of finished files in the folder of -o, if --resume is given.
    ///
    /// # Errors
    /// The output is no folder, or its journal belongs to another run.
    pub fn journal(
        &self,
        command: &'static str,
        folder: Option<&Path>,
        settings: &impl Serialize,
    ) -> Result<RunJournal, Failure> {
        if !self.resume {
            return Ok(RunJournal::none());
        }
        let folder = folder.ok_or_else(|| Failure::input("--resume needs a folder: -o FOLDER"))?;
        let shard = self.part.shard;
        let journal = open_journal(folder, command, shard, settings, EarlierRun::Continue)?;
        Ok(RunJournal::new(journal, folder))
    }
}
