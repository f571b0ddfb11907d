//! A panic ends with one sentence, a report without keys, and status 101.

use super::support::program::Home;

const KEY: &str = "sk-never-to-be-shown-7";

#[test]
fn a_panic_in_any_thread_leaves_a_report_and_one_sentence() {
    if !cfg!(debug_assertions) {
        return;
    }
    for place in ["main", "worker", "task"] {
        let home = Home::new();
        let mut command = home.command();
        command
            .args(["models", "--format=json"])
            .env("NEARMISS_TEST_PANIC", place)
            .env("OPENAI_API_KEY", KEY)
            .env("SECRET_OF_THE_HOUSE", "hunter2-hunter2");
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(101), "{place}");
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(said.lines().count(), 1, "{place}: {said}");
        assert!(said.contains("running `models`"), "{place}: {said}");
        let folder = home.data().join("crashes");
        let reports: Vec<_> = std::fs::read_dir(&folder).unwrap().flatten().collect();
        assert_eq!(reports.len(), 1, "{place}");
        let path = reports[0].path();
        assert!(
            said.contains(&path.display().to_string()),
            "{place}: {said}"
        );
        let report = std::fs::read_to_string(&path).unwrap();
        for words in [
            env!("CARGO_PKG_VERSION"),
            "models --format=json",
            "doing: running `models`",
            "a test asked for this panic, with [key]",
            "ending.rs",
        ] {
            assert!(report.contains(words), "{place}: {words}: {report}");
        }
        assert!(!report.contains("SECRET_OF_THE_HOUSE"), "no environment");
        assert!(home.files_with(KEY).is_empty() && !said.contains(KEY));
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = |path: &std::path::Path| path.metadata().unwrap().permissions().mode();
            assert_eq!(mode(&path) & 0o777, 0o600);
            assert_eq!(mode(&folder) & 0o777, 0o700);
        }
    }
}
