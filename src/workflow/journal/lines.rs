//! Lines of journals: reading them, also where a program was killed while it wrote one, and adding one.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufRead, BufReader, Result, Write};
use std::path::Path;

use super::{FinishedUnit, Header, JobIdentity, JournalError};
use nearmiss_base::system;

type Contents = (Option<Header>, HashMap<String, FinishedUnit>);

/// Reads a journal. A last line without an end is cut off: its program was killed. Of a unit that was done again, the
/// last line counts.
pub fn read(file: &mut File, path: &Path) -> std::result::Result<Contents, JournalError> {
    let io = |source| JournalError::Io {
        path: path.to_path_buf(),
        source,
    };
    let mut reader = BufReader::new(&*file);
    let (mut header, mut finished) = (None, HashMap::new());
    let (mut whole, mut line, mut text) = (0_u64, 0, String::new());
    loop {
        text.clear();
        let length = reader.read_line(&mut text).map_err(io)?;
        if !text.ends_with('\n') {
            break;
        }
        whole += length as u64;
        line += 1;
        let wrong = |_| JournalError::NotAJournal {
            path: path.to_path_buf(),
            line,
        };
        if line == 1 {
            header = Some(serde_json::from_str(&text).map_err(wrong)?);
            continue;
        }
        let unit: FinishedUnit = serde_json::from_str(&text).map_err(wrong)?;
        finished.insert(unit.unit.clone(), unit);
    }
    file.set_len(whole).map_err(io)?;
    Ok((header, finished))
}

/// Adds a line, in one piece.
pub fn append(file: &mut File, line: &impl serde::Serialize) -> Result<()> {
    let mut text = serde_json::to_string(line)?;
    text.push('\n');
    file.write_all(text.as_bytes())
}

/// Refuses journals of the same command beside it that have other settings, or divide the scenarios otherwise.
pub fn check_others(
    folder: &Path,
    own: &Path,
    job: &JobIdentity,
) -> std::result::Result<(), JournalError> {
    let entries = std::fs::read_dir(folder).map_err(|source| JournalError::Io {
        path: folder.to_path_buf(),
        source,
    })?;
    let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let same = name
            .strip_prefix(job.command)
            .is_some_and(|rest| rest == ".jsonl" || rest.starts_with('-'));
        if path == own || !same {
            continue;
        }
        let mut first = String::new();
        let opened = system::open_file(&path);
        let read = opened.and_then(|file| BufReader::new(file).read_line(&mut first));
        read.map_err(|source| JournalError::Io {
            path: path.clone(),
            source,
        })?;
        // One that is just being begun has no whole line yet.
        let Ok(found) = serde_json::from_str::<Header>(&first) else {
            continue;
        };
        let own = job.shard.map(|shard| shard.to_string());
        if parts(found.shard.as_deref()) != parts(own.as_deref()) {
            return Err(JournalError::OtherDivision(path));
        }
        job.check(&path, &found)?;
    }
    Ok(())
}

/// The number of parts, as text.
fn parts(shard: Option<&str>) -> Option<&str> {
    shard
        .and_then(|shard| shard.split_once('/'))
        .map(|(_, of)| of)
}
