//! Tests of journals: continuing, torn lines, changed files, other settings.
#![allow(clippy::unwrap_used)]

use std::io::Write;

use super::*;

fn job(shard: Option<&str>, settings: &str) -> JobIdentity {
    JobIdentity {
        command: "metrics",
        shard: shard.map(|s| s.parse().unwrap()),
        settings: settings.into(),
        named: BTreeMap::from([("replan".to_string(), settings.to_string())]),
    }
}

fn open(folder: &Path, earlier: EarlierRun) -> Result<Journal, JournalError> {
    Journal::open(folder, &job(None, "a"), earlier)
}

#[test]
fn what_is_finished_is_known_unless_its_file_changed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let journal = open(at, EarlierRun::Refuse).unwrap();
    for name in ["one", "two", "three"] {
        std::fs::write(at.join(name), name).unwrap();
        let files = [PathBuf::from(name)];
        journal
            .add(name, vec!["x".into()], &files, 7.into())
            .unwrap();
    }
    assert!(matches!(
        open(at, EarlierRun::Continue),
        Err(JournalError::Busy(_))
    ));
    drop(journal);
    assert!(matches!(
        open(at, EarlierRun::Refuse),
        Err(JournalError::EarlierRun(_))
    ));
    std::fs::write(at.join("two"), "changed").unwrap();
    // Killed in the middle of a line.
    let path = at.join(FOLDER).join("metrics.jsonl");
    let mut file = File::options().append(true).open(&path).unwrap();
    file.write_all(b"{\"unit\":\"fo").unwrap();
    drop(file);
    let journal = open(at, EarlierRun::Continue).unwrap();
    let mut known: Vec<&str> = journal.units().map(|unit| &*unit.unit).collect();
    known.sort_unstable();
    assert_eq!(known, ["one", "three"]);
    assert_eq!(journal.finished("one").unwrap().notes, 7);
    journal.add("four", Vec::new(), &[], Value::Null).unwrap();
    drop(journal);
    let journal = open(at, EarlierRun::Continue).unwrap();
    assert!(journal.finished("four").is_some());
    drop(journal);
    let journal = open(at, EarlierRun::Replace).unwrap();
    assert_eq!(journal.units().count(), 0);
}

#[test]
fn other_settings_and_other_divisions_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let open = |job: JobIdentity| Journal::open(folder.path(), &job, EarlierRun::Continue);
    drop(open(job(Some("1/2"), "a")).unwrap());
    drop(open(job(Some("2/2"), "a")).unwrap());
    let error = |job| open(job).unwrap_err();
    assert!(matches!(
        error(job(Some("1/2"), "b")),
        JournalError::OtherSettings { .. }
    ));
    assert!(matches!(
        error(job(Some("1/3"), "a")),
        JournalError::OtherDivision(_)
    ));
    assert!(matches!(
        error(job(None, "a")),
        JournalError::OtherDivision(_)
    ));
}
