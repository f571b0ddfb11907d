//! Migrations of the store's file: numbered SQL files, each applied once, in a transaction.

use rusqlite::{Connection, TransactionBehavior};

use super::StoreError;

/// What brings a file from one version to the next; the first one makes it.
const MIGRATIONS: [&str; 13] = [
    include_str!("migrations/1.sql"),
    include_str!("migrations/2.sql"),
    include_str!("migrations/3.sql"),
    include_str!("migrations/4.sql"),
    include_str!("migrations/5.sql"),
    include_str!("migrations/6.sql"),
    include_str!("migrations/7.sql"),
    include_str!("migrations/8.sql"),
    include_str!("migrations/9.sql"),
    include_str!("migrations/10.sql"),
    include_str!("migrations/11.sql"),
    include_str!("migrations/12.sql"),
    include_str!("migrations/13.sql"),
];

/// The version of a file that this program writes.
pub const VERSION: i64 = MIGRATIONS.len() as i64;

/// Brings the file to the newest version. Several programs may try at once; one does it, the others wait.
pub fn migrate(connection: &mut Connection) -> Result<(), StoreError> {
    if version(connection)? == VERSION {
        return Ok(());
    }
    let transaction = connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
    let found = version(&transaction)?;
    if found > VERSION {
        return Err(StoreError::Newer {
            found,
            known: VERSION,
        });
    }
    let done = usize::try_from(found).unwrap_or(0);
    for sql in &MIGRATIONS[done..] {
        transaction.execute_batch(sql)?;
    }
    transaction.pragma_update(None, "user_version", VERSION)?;
    transaction.commit()?;
    Ok(())
}

fn version(connection: &Connection) -> Result<i64, StoreError> {
    Ok(connection.query_row("PRAGMA user_version", [], |row| row.get(0))?)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use crate::{Filter, RunId, RunState, Store};

    /// A store as version 1 wrote it.
    fn version_1(path: &std::path::Path) {
        let connection = rusqlite::Connection::open(path).unwrap();
        connection.execute_batch(super::MIGRATIONS[0]).unwrap();
        connection.pragma_update(None, "user_version", 1).unwrap();
        let insert = "INSERT INTO runs (created_ms, updated_ms, scenario, scenario_hash, ego, task, frame, techniques,
            window_first, window_last, model, endpoint, template, template_hash, messages, parameters, state, answer,
            finish, verdict, cost_usd) VALUES (?1, ?1, 'ZAM_A-1', 'h', '1', 'collision', 'ego', 'base', 3, 12,
            'lab/x/y', 'lab (http://a)', 't.md', 'th', '[]', '{}', ?2, ?3, ?4, ?5, ?6)";
        let verdict =
            r#"{"task":"collision","collision":true,"obstacles":[],"justification":"it brakes"}"#;
        let rows = [
            ("answered", "whole", "stop", Some(verdict), Some(0.5)),
            ("answered", "cut", "length", None, None),
            ("running", "", "", None, None),
        ];
        for (i, (state, answer, finish, verdict, cost)) in rows.into_iter().enumerate() {
            let values = rusqlite::params![1000 + i, state, answer, finish, verdict, cost];
            connection.execute(insert, values).unwrap();
        }
        let pieces = "INSERT INTO pieces (run, reasoning, text) VALUES (3, 1, 'hm '), (3, 0, 'so '), (3, 0, 'far')";
        connection.execute_batch(pieces).unwrap();
    }

    #[test]
    fn a_store_of_version_1_keeps_everything() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.sqlite");
        version_1(&path);
        let store = Store::open(&path).unwrap();
        let run = |id| store.run(RunId(id)).unwrap().unwrap();
        let whole = run(1);
        assert_eq!((whole.created_ms, whole.answer.as_str()), (1000, "whole"));
        assert_eq!(whole.question.window, Some((3, 12)));
        assert_eq!(
            (whole.question.provider.as_str(), whole.question.key()),
            ("lab", None)
        );
        assert!(
            whole
                .ending
                .verdict
                .is_some_and(|said| said.verdict().is_some_and(|v| v.dangerous))
        );
        assert_eq!(whole.ending.consumed.cost_usd, Some(0.5));
        assert_eq!(run(2).ending.state, RunState::Truncated);
        let killed = run(3);
        assert_eq!(killed.ending.state, RunState::Interrupted);
        assert_eq!(
            (killed.answer.as_str(), killed.reasoning.as_str()),
            ("so far", "hm ")
        );
        let words = Filter {
            words: Some("brakes".into()),
            ..Filter::default()
        };
        let found = store.list(&words, 10);
        assert_eq!(
            found.unwrap().len(),
            1,
            "old answers are found by their words"
        );
        drop(store);
        assert!(Store::open(&path).is_ok(), "and once is enough");
    }

    #[test]
    fn a_store_of_version_2_takes_ratings_and_keeps_its_runs() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.sqlite");
        version_1(&path);
        let connection = rusqlite::Connection::open(&path).unwrap();
        connection.execute_batch(super::MIGRATIONS[1]).unwrap();
        connection.pragma_update(None, "user_version", 2).unwrap();
        let missing = connection.prepare("SELECT * FROM ratings").is_err();
        assert!(missing, "version 2 has none");
        drop(connection);
        let store = Store::open(&path).unwrap();
        assert_eq!(store.run(RunId(1)).unwrap().unwrap().answer, "whole");
        assert_eq!(store.ratings().unwrap(), []);
        let rating = crate::ratings::tests::rating(Some(RunId(1)), None);
        store.rate(&rating).unwrap();
        drop(store);
        let mut again = Store::open(&path).unwrap().ratings().unwrap();
        // The template of a run comes from the run.
        assert!(again[0].answers[0].template.take().is_some());
        assert_eq!(again[0].answers, rating.answers);
    }

    #[test]
    fn a_store_of_version_3_takes_batches_and_keeps_its_runs() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.sqlite");
        version_1(&path);
        let connection = rusqlite::Connection::open(&path).unwrap();
        for sql in &super::MIGRATIONS[1..3] {
            connection.execute_batch(sql).unwrap();
        }
        connection.pragma_update(None, "user_version", 3).unwrap();
        let missing = connection.prepare("SELECT * FROM batches").is_err();
        assert!(missing, "version 3 has none");
        drop(connection);
        let store = Store::open(&path).unwrap();
        assert_eq!(store.run(RunId(1)).unwrap().unwrap().answer, "whole");
        assert_eq!(store.batches().unwrap(), []);
        let item = crate::items::tests::item("ZAM_A-1", 0);
        let batch = store.begin_batch("{}", None, &[item]).unwrap();
        drop(store);
        let again = Store::open(&path).unwrap();
        let items = again.items(batch).unwrap();
        assert_eq!(items.len(), 1);
        assert_eq!(items[0].asked.scenario, "ZAM_A-1");
    }

    #[test]
    fn a_store_of_version_5_keeps_its_batches_and_takes_changed_scenes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.sqlite");
        version_1(&path);
        let connection = rusqlite::Connection::open(&path).unwrap();
        for sql in &super::MIGRATIONS[1..5] {
            connection.execute_batch(sql).unwrap();
        }
        connection.pragma_update(None, "user_version", 5).unwrap();
        let old = "INSERT INTO batches (id, created_ms, updated_ms, spec) VALUES (3, 1, 1, '{}');
            INSERT INTO items (batch, place, path, scenario, task, model, sample, state)
            VALUES (3, 0, 'A', 'A', 'safety', 'lab/tiny', 0, 'waiting')";
        connection.execute_batch(old).unwrap();
        let missing = connection.prepare("SELECT lead FROM items").is_err();
        assert!(missing, "version 5 has none");
        drop(connection);
        let store = Store::open(&path).unwrap();
        let batch = crate::BatchId(3);
        let changed = crate::NewItem {
            lead: Some("0.5".into()),
            transform: Some("mirror".into()),
            ..crate::items::tests::item("A", 0)
        };
        let more = std::slice::from_ref(&changed);
        store.extend_batch(batch, "{}", more).unwrap();
        drop(store);
        let items = Store::open(&path).unwrap().items(batch).unwrap();
        assert_eq!(items.len(), 2);
        assert_eq!(
            (&items[0].asked.lead, &items[0].asked.transform),
            (&None, &None)
        );
        assert_eq!(items[1].asked, changed);
    }
    #[test]
    fn a_store_of_version_7_keeps_its_answers_and_takes_counts_of_claims() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.sqlite");
        version_1(&path);
        let connection = rusqlite::Connection::open(&path).unwrap();
        for sql in &super::MIGRATIONS[1..7] {
            connection.execute_batch(sql).unwrap();
        }
        connection.pragma_update(None, "user_version", 7).unwrap();
        drop(connection);
        let store = Store::open(&path).unwrap();
        let claims = |store: &Store| store.run(RunId(1)).unwrap().unwrap().ending.claims;
        assert_eq!(claims(&store).known(), None, "it was not checked");
        let counts = crate::ClaimCounts {
            claims_right: Some(3),
            claims_wrong: Some(1),
            claims_open: Some(0),
            claims_check: Some(1),
        };
        store.keep_claims(&[(RunId(1), counts)]).unwrap();
        drop(store);
        let store = Store::open(&path).unwrap();
        assert_eq!(claims(&store), counts);
        assert_eq!(store.run(RunId(1)).unwrap().unwrap().answer, "whole");
        let outcomes = store.outcomes(&Filter::default()).unwrap();
        assert_eq!(outcomes[0].claims.known(), Some([3, 1, 0]));
        // What it exports comes back the same.
        let run = store.run(RunId(1)).unwrap().unwrap();
        let line = crate::record_line(&run.to_record(false)).unwrap();
        let back = crate::Run::from_record(&line).unwrap();
        assert_eq!(back.ending.claims, counts);
    }

    #[test]
    fn a_store_of_version_8_keeps_its_batches_and_takes_axes_splits_and_looks() {
        use crate::{BatchId, NewItem, SplitPart};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.sqlite");
        version_1(&path);
        let connection = rusqlite::Connection::open(&path).unwrap();
        for sql in &super::MIGRATIONS[1..8] {
            connection.execute_batch(sql).unwrap();
        }
        connection.pragma_update(None, "user_version", 8).unwrap();
        let old = "INSERT INTO batches (id, created_ms, updated_ms, spec) VALUES (3, 1, 1, '{}');
            INSERT INTO items (batch, place, path, scenario, task, model, sample, state)
            VALUES (3, 0, 'A', 'A', 'safety', 'lab/tiny', 0, 'waiting')";
        connection.execute_batch(old).unwrap();
        drop(connection);
        let store = Store::open(&path).unwrap();
        let batch = BatchId(3);
        let more = NewItem {
            settings: Some("effort low".into()),
            split: Some(SplitPart::Test),
            ..crate::items::tests::item("A", 0)
        };
        store
            .extend_batch(batch, "{}", std::slice::from_ref(&more))
            .unwrap();
        let progress = store.split_progress(batch, SplitPart::Test).unwrap();
        store.record_look(batch, progress).unwrap();
        drop(store);
        let store = Store::open(&path).unwrap();
        let items = store.items(batch).unwrap();
        assert_eq!(
            (&items[0].asked.settings, items[0].asked.split),
            (&None, None)
        );
        assert_eq!(items[1].asked, more);
        assert_eq!(store.looks(batch).unwrap().len(), 1);
    }

    #[test]
    fn a_store_of_version_9_keeps_its_decisions_and_knows_those_of_recordings() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.sqlite");
        version_1(&path);
        let connection = rusqlite::Connection::open(&path).unwrap();
        for sql in &super::MIGRATIONS[1..9] {
            connection.execute_batch(sql).unwrap();
        }
        connection.pragma_update(None, "user_version", 9).unwrap();
        let decided = |connection: &rusqlite::Connection| {
            let mut rows = connection
                .prepare("SELECT is_dangerous FROM answers ORDER BY run")
                .unwrap();
            let found = rows.query_map([], |row| row.get(0)).unwrap();
            found.map(Result::unwrap).collect::<Vec<Option<i64>>>()
        };
        let before = decided(&connection);
        drop(connection);
        drop(Store::open(&path).unwrap());
        let connection = rusqlite::Connection::open(&path).unwrap();
        assert_eq!(decided(&connection), before);
        let set = "UPDATE runs SET verdict = ?1 WHERE id = (SELECT min(id) FROM runs)";
        for (verdict, wanted) in [
            (r#"{"task": "recording", "high_risk": true}"#, Some(1)),
            (r#"{"task": "recording", "high_risk": false}"#, Some(0)),
            (r#"{"task": "safety", "safety_critical": true}"#, Some(1)),
            (r#"{"task": "trajectory"}"#, None),
        ] {
            connection.execute(set, [verdict]).unwrap();
            assert_eq!(decided(&connection)[0], wanted, "{verdict}");
        }
    }

    #[test]
    fn a_store_of_version_10_keeps_its_runs_and_takes_rounds_of_tools() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.sqlite");
        version_1(&path);
        let connection = rusqlite::Connection::open(&path).unwrap();
        for sql in &super::MIGRATIONS[1..10] {
            connection.execute_batch(sql).unwrap();
        }
        connection.pragma_update(None, "user_version", 10).unwrap();
        drop(connection);
        let store = Store::open(&path).unwrap();
        let run = |id| store.run(RunId(id)).unwrap().unwrap();
        assert_eq!(
            (run(1).answer.as_str(), run(1).tool_rounds),
            ("whole", None)
        );
        let rounds = r#"[{"text":"","calls":[],"results":[]}]"#;
        store.keep_rounds(RunId(1), rounds).unwrap();
        assert_eq!(run(1).tool_rounds.as_deref(), Some(rounds));
        let record = crate::record_line(&run(1).to_record(false)).unwrap();
        assert!(record.contains("tool_rounds"), "{record}");
        let without = crate::record_line(&run(2).to_record(false)).unwrap();
        assert!(!without.contains("tool_rounds"));
    }

    #[test]
    fn a_store_of_version_11_keeps_its_runs_and_takes_images() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.sqlite");
        version_1(&path);
        let connection = rusqlite::Connection::open(&path).unwrap();
        for sql in &super::MIGRATIONS[1..11] {
            connection.execute_batch(sql).unwrap();
        }
        connection.pragma_update(None, "user_version", 11).unwrap();
        assert!(connection.prepare("SELECT * FROM images").is_err());
        drop(connection);
        let store = Store::open(&path).unwrap();
        assert_eq!(store.run(RunId(1)).unwrap().unwrap().answer, "whole");
        let image = crate::StoredImage {
            sha256: "aa".into(),
            media_type: "image/png".into(),
            width: 1,
            height: 1,
            bytes: vec![1, 2].into(),
        };
        store.keep_image(&image).unwrap();
        drop(store);
        let store = Store::open(&path).unwrap();
        assert_eq!(store.image("aa").unwrap(), Some(image));
    }
}
