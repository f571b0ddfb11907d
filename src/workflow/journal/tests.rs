//! Tests of journals: continuing, torn lines, changed files, other settings.
#![allow(clippy::unwrap_used)]

use std::io::Write;

use super::*;

fn job(shard: Option<&str>, settings: &str) -> JobIdentity {
    JobIdentity {
        command: "metrics",
        shard: shard.map(|s| s.parse().unwrap()),
        settings: RunSettings::new(&BTreeMap::from([("replan", settings)])).unwrap(),
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

#[test]
fn differences_are_named_and_what_is_not_given_makes_none() {
    let settings = |value: Value| RunSettings::new(&value).unwrap();
    let then = serde_json::json!({ "seed": 1, "wish": null, "search": { "rounds": 0.1 } });
    let now = serde_json::json!({ "seed": 2, "search": { "rounds": 0.1 }, "style": "limit" });
    let found = settings(then).differences(&settings(now));
    let words: Vec<String> = found.iter().map(ToString::to_string).collect();
    assert_eq!(words, ["seed 1, now 2", "style not given, now \"limit\""]);
}

/// A journal of the first layout, with these words for its settings.
fn first_layout(folder: &Path, named: &str) {
    std::fs::create_dir_all(folder.join(FOLDER)).unwrap();
    let header = format!(
        "{{\"command\":\"metrics\",\"shard\":null,\"settings\":\"a645\",\"version\":\"{VERSION}\"{named}}}\n"
    );
    let unit = "{\"unit\":\"one\",\"inputs\":[\"x\"],\"files\":{},\"notes\":7}\n";
    std::fs::write(folder.join(FOLDER).join("metrics.jsonl"), header + unit).unwrap();
}

#[test]
fn a_run_of_the_first_layout_is_continued_where_its_words_say_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let of = |settings| JobIdentity {
        command: "metrics",
        shard: None,
        settings: RunSettings::new(&settings).unwrap(),
    };
    let open = |settings| Journal::open(folder.path(), &of(settings), EarlierRun::Continue);
    let same = || serde_json::json!({ "timeout": 10.0, "planner": "nearmiss", "yes": true });
    first_layout(
        folder.path(),
        ",\"named\":{\"timeout\":\"10\",\"planner\":\"nearmiss\",\"yes\":\"true\"}",
    );
    assert!(open(same()).unwrap().finished("one").is_some());
    let other = open(serde_json::json!({ "timeout": 5.0, "planner": "nearmiss", "yes": true }));
    let words = other.unwrap_err().to_string();
    assert!(words.contains("(timeout 10.0, now 5.0)"), "{words}");
    first_layout(folder.path(), "");
    let words = open(same()).unwrap_err().to_string();
    assert!(
        words.contains("does not say with which settings"),
        "{words}"
    );
    let kept = std::fs::read_to_string(folder.path().join(FOLDER).join("metrics.jsonl")).unwrap();
    assert_eq!(kept.lines().count(), 2);
}
