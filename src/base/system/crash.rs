//! What happens if the program panics in spite of all: one sentence, a report, exit status 101.

use std::backtrace::Backtrace;
use std::cell::Cell;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use super::activity::{self, CrashedActivity, make_private};

/// Exit status after an internal error.
pub const STATUS: i32 = 101;

/// Reports that are kept: the newest.
const MOST_REPORTS: usize = 20;

/// Takes secrets out of a text.
pub type Redact = fn(&str) -> String;

thread_local! {
    /// Whether a panic of this thread is an error of what it reads.
    static CONTAINED: Cell<bool> = const { Cell::new(false) };
}

/// What `read` gives; nothing if it panics, which is neither reported nor the end of the program.
///
/// For crates that read files of others and assert that these are sound. Nothing that `read` changes may be used after
/// that.
pub fn contained<T>(read: impl FnOnce() -> T) -> Option<T> {
    let before = CONTAINED.replace(true);
    let found = std::panic::catch_unwind(std::panic::AssertUnwindSafe(read));
    CONTAINED.set(before);
    found.ok()
}

/// Whether a panic of this thread is contained: hooks let it pass.
#[must_use]
pub fn is_contained() -> bool {
    CONTAINED.get()
}

/// Makes every panic, in whichever thread, write a report into `folder`, say so in one sentence, and end the program.
///
/// `folder` may be missing; the report is then said to be unwritten. `redact` takes out secrets.
pub fn report_panics(folder: Option<PathBuf>, redact: Redact) {
    static BEGUN: AtomicBool = AtomicBool::new(false);
    let main = std::thread::current().id();
    let command: Vec<String> = std::env::args_os()
        .map(|argument| redact(&argument.to_string_lossy()))
        .collect();
    std::panic::set_hook(Box::new(move |info| {
        if is_contained() {
            return;
        }
        // Of several panics at once the first is the cause; a panic in here must not come back.
        if !BEGUN.swap(true, Ordering::SeqCst) {
            let crashed = activity::crashed();
            let report = report(&info.to_string(), &command, &crashed);
            let written = folder
                .as_deref()
                .ok_or_else(|| "no folder for it".to_string())
                .and_then(|folder| {
                    write(folder, &redact(&report)).map_err(|error| super::error_text(&error))
                });
            let sentence = redact(&sentence(&crashed, &command, written.as_deref()));
            // Standard error may be closed.
            let _ = writeln!(std::io::stderr().lock(), "{sentence}");
        }
        // The main thread unwinds, so that temporary files go, and ends with the same status.
        if std::thread::current().id() != main {
            super::end_process_groups();
            std::process::exit(STATUS);
        }
    }));
}

/// The crash message: activity, file and place of the report.
fn sentence(
    crashed: &CrashedActivity,
    command: &[String],
    written: Result<&Path, &String>,
) -> String {
    let fallback = || {
        command
            .get(1)
            .map_or("starting", String::as_str)
            .to_string()
    };
    let doing = crashed.tasks.last().cloned().unwrap_or_else(fallback);
    let file = crashed
        .file
        .as_deref()
        .map(|file| format!(" ({})", file.display()));
    let report = match written {
        Ok(path) => format!("the report is in {}", path.display()),
        Err(why) => format!("no report could be written ({why})"),
    };
    let all = format!(
        "nearmiss: internal error while {doing}{}; {report}",
        file.unwrap_or_default()
    );
    all.chars()
        .map(|c| if c.is_control() { '\u{fffd}' } else { c })
        .collect()
}

fn report(panic: &str, command: &[String], crashed: &CrashedActivity) -> String {
    let mut text = String::new();
    let version = env!("CARGO_PKG_VERSION");
    let thread = std::thread::current();
    let name = thread.name().unwrap_or("without a name");
    let file = crashed
        .file
        .as_deref()
        .map_or_else(|| "none".to_string(), |file| file.display().to_string());
    // Writing to text does not fail.
    let _ = writeln!(text, "nearmiss {version}");
    let _ = writeln!(
        text,
        "system: {} {}",
        std::env::consts::OS,
        std::env::consts::ARCH
    );
    let _ = writeln!(text, "command: {}", command.join(" "));
    let _ = writeln!(text, "doing: {}", crashed.tasks.join(" > "));
    let _ = writeln!(text, "file read last: {file}");
    let _ = writeln!(text, "thread: {name}");
    let _ = writeln!(text, "\n{panic}\n");
    let _ = writeln!(text, "{}", Backtrace::force_capture());
    text
}

/// Writes a report that only its owner can read.
fn write(folder: &Path, report: &str) -> std::io::Result<PathBuf> {
    make_private(folder)?;
    forget_oldest(folder);
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    let seconds = since.unwrap_or_default().as_secs();
    let path = folder.join(format!("crash-{seconds}-{}.txt", std::process::id()));
    let mut options = std::fs::OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(&path)?.write_all(report.as_bytes())?;
    Ok(path)
}

fn forget_oldest(folder: &Path) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let ours = |path: &PathBuf| {
        let name = path
            .file_name()
            .map(|name| name.to_string_lossy().into_owned());
        name.is_some_and(|name| name.starts_with("crash-") && name.ends_with(".txt"))
    };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(ours).collect();
    // Their names begin with the time.
    paths.sort();
    let more = (paths.len() + 1).saturating_sub(MOST_REPORTS);
    for path in paths.into_iter().take(more) {
        let _ = std::fs::remove_file(path);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn crashed() -> CrashedActivity {
        CrashedActivity {
            tasks: vec!["running `plan`".into(), "planning".into()],
            file: Some("a\u{1b}[2J.xml".into()),
        }
    }

    #[test]
    fn a_contained_panic_is_no_crash() {
        assert_eq!(contained(is_contained), Some(true));
        let fails = || -> i32 { panic!("the file is damaged") };
        assert_eq!(contained(fails), None);
        assert!(!is_contained());
    }

    #[test]
    fn the_sentence_says_what_where_and_where_the_report_is() {
        let command = ["nearmiss".to_string(), "plan".to_string()];
        let said = sentence(&crashed(), &command, Ok(Path::new("/r/crash-1.txt")));
        for word in ["planning", "[2J.xml", "/r/crash-1.txt"] {
            assert!(said.contains(word), "{said}");
        }
        assert_eq!(said.lines().count(), 1);
        assert!(!said.contains('\u{1b}'));
        let why = "read-only".to_string();
        let said = sentence(&CrashedActivity::default(), &command, Err(&why));
        assert!(
            said.contains("plan") && said.contains("read-only"),
            "{said}"
        );
    }

    #[test]
    fn only_the_newest_reports_are_kept_and_only_for_their_owner() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("crashes");
        std::fs::create_dir(&place).unwrap();
        std::fs::write(place.join("mine.txt"), "").unwrap();
        for i in 0..MOST_REPORTS + 5 {
            std::fs::write(place.join(format!("crash-{:010}-1.txt", i)), "").unwrap();
        }
        let path = write(&place, "a report").unwrap();
        let count = std::fs::read_dir(&place).unwrap().count();
        assert_eq!(count, MOST_REPORTS + 1);
        assert!(place.join("mine.txt").exists());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "a report");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = path.metadata().unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o600);
        }
    }
}
