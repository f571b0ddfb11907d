//! Unstored answers: kept in a file each, and imported once the store is writable again.

use std::io::Write;
use std::path::{Path, PathBuf};

use rusqlite::{OptionalExtension, Transaction, params};

use super::database::now_ms;
use super::{AnswerPiece, Ending, NewRun, Origin, Run, RunId, Store, StoreError, write};
use nearmiss_base::system;

/// How the names of the files begin and end.
const NAME: (&str, &str) = ("unstored-", ".jsonl");

/// More bytes than such a file has.
const MAX_BYTES: u64 = 64 << 20;

/// An answer that arrived and is not in the store.
#[derive(Debug)]
pub struct UnstoredAnswer {
    /// Why the store does not have it.
    pub why: StoreError,
    /// The file that it was written to; `None` if none could be written.
    pub file: Option<PathBuf>,
    /// Whether that file is taken in by itself when the store is opened again.
    pub beside: bool,
}

impl std::fmt::Display for UnstoredAnswer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the answer could not be stored: {}; ", self.why)?;
        match &self.file {
            Some(file) if self.beside => write!(
                f,
                "saved to {}; it is imported when the store is writable again",
                file.display()
            ),
            Some(file) => write!(
                f,
                "saved to {0}; run `nearmiss runs import {0}` when the store is writable again",
                file.display()
            ),
            None => f.write_str("it could not be saved to a file either; free disk space"),
        }
    }
}

impl Store {
    /// [`Store::conclude`]s a run of which some pieces may be stored already: these are its whole texts.
    ///
    /// # Errors
    /// SQLite refused; no data is written.
    pub fn conclude_whole(
        &self,
        run: RunId,
        reasoning: &str,
        answer: &str,
        ending: &Ending,
    ) -> Result<(), StoreError> {
        self.durably(|transaction| conclude_whole(transaction, run, reasoning, answer, ending))
    }

    /// Keeps an answer that the store cannot have, as a line that `nearmiss runs import` reads: beside the store, else in
    /// the folder for temporary files. With the rounds of its tool calls, JSON, if it has some.
    #[must_use]
    pub fn set_aside(
        &self,
        id: RunId,
        question: &NewRun,
        (reasoning, answer): (&str, &str),
        ending: &Ending,
        tool_rounds: Option<String>,
        why: StoreError,
    ) -> UnstoredAnswer {
        let now = now_ms();
        let verdict = ending.verdict.as_ref();
        let run = Run {
            id,
            created_ms: now,
            updated_ms: now,
            key: question.key(),
            origin: Origin::Asked,
            source: None,
            question: question.clone(),
            answer: answer.to_owned(),
            reasoning: reasoning.to_owned(),
            ending: ending.clone(),
            verdict_json: verdict.and_then(|said| serde_json::to_string(said).ok()),
            tool_rounds,
            most_usd: None,
            notes: String::new(),
            pinned: false,
            deleted_ms: None,
        };
        let line = nearmiss_record::json_line(&run.to_record(false)).unwrap_or_default();
        let name = format!("{}{id}-{now}{}", NAME.0, NAME.1);
        let written = |folder: &Path| save(&folder.join(&name), &line).ok();
        let beside = self.folder().as_deref().and_then(written);
        UnstoredAnswer {
            why,
            beside: beside.is_some(),
            file: beside.or_else(|| written(&std::env::temp_dir())),
        }
    }

    /// Takes in the answers that were set aside beside the store. What cannot be taken in stays where it is.
    pub(super) fn take_in(&self) {
        let Some(files) = self.folder().and_then(|f| std::fs::read_dir(f).ok()) else {
            return;
        };
        for file in files.flatten() {
            let os_name = file.file_name();
            let name = os_name.to_string_lossy();
            if !(name.starts_with(NAME.0) && name.ends_with(NAME.1)) {
                continue;
            }
            let path = file.path();
            let Ok(line) = system::read_text(&path, MAX_BYTES) else {
                continue;
            };
            let Ok(run) = Run::from_record(line.trim()) else {
                continue;
            };
            if self.restore(&run).is_ok() {
                // Taken in twice, it would be found to be there.
                let _ = std::fs::remove_file(path);
            }
        }
    }

    /// Ends the run that an answer belongs to, where it is still open here; else adds it.
    fn restore(&self, run: &Run) -> Result<(), StoreError> {
        let open = self.durably(|transaction| {
            let key = run.key.as_ref().map(super::Key::as_str);
            let sql = "SELECT 1 FROM runs WHERE id = ?1 AND key IS ?2 AND sample = ?3
                AND state IN ('running', 'interrupted')";
            let values = params![run.id.0, key, run.question.sample];
            let open = transaction.query_row(sql, values, |_| Ok(())).optional()?;
            if open.is_some() {
                conclude_whole(
                    transaction,
                    run.id,
                    &run.reasoning,
                    &run.answer,
                    &run.ending,
                )?;
            }
            Ok(open.is_some())
        })?;
        if !open {
            self.add(std::slice::from_ref(run))?;
        }
        Ok(())
    }

    /// The folder of the store's file; `None` for a store in memory.
    fn folder(&self) -> Option<PathBuf> {
        let connection = self.lock();
        let file = connection.path().filter(|path| !path.is_empty())?;
        Path::new(file).parent().map(Path::to_path_buf)
    }
}

fn conclude_whole(
    transaction: &Transaction<'_>,
    run: RunId,
    reasoning: &str,
    answer: &str,
    ending: &Ending,
) -> Result<(), StoreError> {
    transaction.execute("DELETE FROM pieces WHERE run = ?1", [run.0])?;
    let sql = "UPDATE runs SET answer = '', reasoning = '' WHERE id = ?1";
    transaction.execute(sql, [run.0])?;
    let pieces = [
        AnswerPiece::Reasoning(reasoning),
        AnswerPiece::Answer(answer),
    ];
    write::conclude(transaction, run, &pieces, ending)
}

/// Writes a file whole or not at all, for its owner alone.
fn save(path: &Path, line: &str) -> std::io::Result<PathBuf> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(line.as_bytes())?;
    file.as_file().sync_all()?;
    file.persist(path)?;
    Ok(path.to_path_buf())
}

#[cfg(test)]
#[path = "unstored_tests.rs"]
mod tests;
