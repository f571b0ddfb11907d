//! What happens if the program panics in spite of all: one sentence, a report of what it was doing, exit status 101.
//!
//! A mark is written before a draft is filled or a scenario is opened, and removed after. One that is left by a
//! program that is gone names what ended it: that is *held*, and not tried again until the user asks for it.

use std::backtrace::Backtrace;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::ThreadId;
use std::time::{SystemTime, UNIX_EPOCH};

use sha2::{Digest, Sha256};

/// Exit status after an internal error.
const STATUS: i32 = 101;

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
            let crashed = crashed();
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

/// Something risky that is attempted, under a name that stays the same at the next start.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Subject(String);

impl Subject {
    /// A scenario, by where it lies.
    #[must_use]
    pub fn scenario(place: &str) -> Self {
        Self(one_line(&format!("scenario {place}")))
    }

    /// A template with this text: another text is another subject.
    #[must_use]
    pub fn template(file: &str, text: &str) -> Self {
        use std::hash::{DefaultHasher, Hash, Hasher};
        let mut hasher = DefaultHasher::new();
        text.hash(&mut hasher);
        Self(one_line(&format!(
            "template {file} {:016x}",
            hasher.finish()
        )))
    }

    /// Its name, in one line.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.0
    }
}

fn one_line(text: &str) -> String {
    text.replace(['\n', '\r'], "\u{fffd}")
}

struct Task {
    thread: ThreadId,
    words: String,
    subject: Option<Subject>,
    /// Whether it went well so far: only a panic is still held against it.
    settled: bool,
}

#[derive(Default)]
struct State {
    next: u64,
    tasks: BTreeMap<u64, Task>,
    /// The file that was read last, by this thread and by any.
    files: BTreeMap<String, PathBuf>,
    last: Option<PathBuf>,
    marks: Option<ActivityLocks>,
}

static STATE: Mutex<Option<State>> = Mutex::new(None);

struct Locked(MutexGuard<'static, Option<State>>);

impl Locked {
    fn state(&mut self) -> &mut State {
        self.0.get_or_insert_default()
    }
}

fn lock() -> Locked {
    Locked(STATE.lock().unwrap_or_else(PoisonError::into_inner))
}

/// A guard that marks an activity as running until dropped.
#[derive(Debug)]
#[must_use = "it is over when this is dropped"]
pub struct ActivityGuard(u64);

impl Drop for ActivityGuard {
    fn drop(&mut self) {
        let mut locked = lock();
        let task = locked.state().tasks.remove(&self.0);
        if task.is_some_and(|task| task.subject.is_some() && !task.settled) {
            locked.state().mark();
        }
    }
}

impl ActivityGuard {
    /// It went well: when the program is killed from now on, this was not the cause.
    pub fn settle(&self) {
        let mut locked = lock();
        if let Some(task) = locked.state().tasks.get_mut(&self.0) {
            task.settled = true;
        }
        locked.state().mark();
    }
}

/// Says what is being done from now on, in words such as `planning`.
pub fn doing(words: impl Into<String>) -> ActivityGuard {
    lock().state().begin(words.into(), None)
}

/// Says what is being tried from now on, and marks it on the disk where marks are kept.
pub fn trying(words: impl Into<String>, subject: Subject) -> ActivityGuard {
    lock().state().begin(words.into(), Some(subject))
}

/// A file is being read: what fails later is about it.
pub fn reading(file: &Path) {
    let mut locked = lock();
    let state = locked.state();
    let thread = format!("{:?}", std::thread::current().id());
    state.last = Some(file.to_path_buf());
    if state.files.len() > MOST_THREADS {
        state.files.clear();
    }
    state.files.insert(thread, file.to_path_buf());
}

/// Of more threads the file is not remembered.
const MOST_THREADS: usize = 256;

impl State {
    fn begin(&mut self, words: String, subject: Option<Subject>) -> ActivityGuard {
        let id = self.next;
        self.next += 1;
        let marked = subject.is_some();
        self.tasks.insert(
            id,
            Task {
                thread: std::thread::current().id(),
                words,
                subject,
                settled: false,
            },
        );
        if marked {
            self.mark();
        }
        ActivityGuard(id)
    }

    /// Writes down what is being tried now.
    fn mark(&mut self) {
        let tried = self.tasks.values().filter(|task| !task.settled);
        let names = tried.filter_map(|task| task.subject.as_ref().map(Subject::name));
        let names: Vec<&str> = names.collect();
        if let Some(marks) = &mut self.marks {
            marks.write(&names);
        }
    }
}

/// Keeps marks in this folder from now on, and takes up those that programs left which are gone.
///
/// # Errors
/// The folder cannot be made or written in; marks are not kept then.
pub fn keep_marks(folder: &Path) -> std::io::Result<()> {
    let marks = ActivityLocks::open(folder)?;
    lock().state().marks = Some(marks);
    Ok(())
}

/// No mark is kept any longer: the program ends as it should.
pub fn close_marks() {
    lock().state().marks = None;
}

/// Whether this ended the program when it was tried last.
#[must_use]
pub fn is_held(subject: &Subject) -> bool {
    let mut locked = lock();
    let marks = locked.state().marks.as_ref();
    marks.is_some_and(|marks| marks.holds(subject.name()))
}

/// The user asks for it all the same, or it is no longer there.
pub fn release(subject: &Subject) {
    if let Some(marks) = &mut lock().state().marks {
        marks.release(subject.name());
    }
}

/// The activity and file of a thread that panicked.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct CrashedActivity {
    /// The tasks of this thread, the first the widest; of all threads if it has none.
    tasks: Vec<String>,
    /// The file that this thread read last, else the one that any read.
    file: Option<PathBuf>,
}

/// What was being done: asked in a panic. Holds what was being tried, so that it is not tried by itself again.
#[must_use]
fn crashed() -> CrashedActivity {
    // A panic within this module must not wait for itself.
    let Ok(mut guard) = STATE.try_lock() else {
        return CrashedActivity::default();
    };
    let state = guard.get_or_insert_default();
    let here = std::thread::current().id();
    let own = state.tasks.values().any(|task| task.thread == here);
    let tasks = state.tasks.values().filter(|t| !own || t.thread == here);
    let words = tasks.map(|task| task.words.clone()).collect();
    let tried = |of: &dyn Fn(&Task) -> bool| -> Vec<String> {
        let tasks = state.tasks.values().filter(|task| of(task));
        let subjects = tasks.filter_map(|task| task.subject.as_ref());
        subjects.map(|subject| subject.name().to_string()).collect()
    };
    // The narrowest guess that there is: this thread's, else what is being tried, else what is open.
    let guesses = [
        tried(&|task| task.thread == here && !task.settled),
        tried(&|task| task.thread == here),
        tried(&|task| !task.settled),
        tried(&|_| true),
    ];
    let suspects = guesses.into_iter().find(|guess| !guess.is_empty());
    if let Some(mut marks) = state.marks.take() {
        for name in suspects.unwrap_or_default() {
            marks.hold(&name);
        }
    }
    let thread = format!("{here:?}");
    let file = state.files.get(&thread).or(state.last.as_ref()).cloned();
    CrashedActivity { tasks: words, file }
}

/// A lock file for this program while it runs, and one file for each held subject.
#[derive(Debug)]
struct ActivityLocks {
    folder: PathBuf,
    path: PathBuf,
    file: File,
    held: BTreeSet<String>,
}

const RUNNING: &str = "running-";

const HELD: &str = "held-";

/// Longer files are none of ours, bytes.
const MAX_BYTES: u64 = 1 << 20;

impl ActivityLocks {
    /// Opens the folder: what is marked by programs that are gone is held from now on.
    ///
    /// # Errors
    /// It cannot be made or written in.
    fn open(folder: &Path) -> io::Result<Self> {
        make_private(folder)?;
        let path = folder.join(format!("{RUNNING}{}", std::process::id()));
        // What a program of the same number left is taken up first.
        take_up(folder, &path);
        for entry in std::fs::read_dir(folder)?.flatten() {
            if has_name(&entry.path(), RUNNING) {
                take_up(folder, &entry.path());
            }
        }
        let file = OpenOptions::new()
            .create(true)
            .truncate(true)
            .write(true)
            .open(&path)?;
        // Where files cannot be locked, a program that is gone cannot be told from one that runs.
        file.try_lock().map_err(|error| match error {
            TryLockError::Error(error) => error,
            TryLockError::WouldBlock => std::io::ErrorKind::WouldBlock.into(),
        })?;
        let held = std::fs::read_dir(folder)?
            .flatten()
            .filter(|entry| has_name(&entry.path(), HELD))
            .filter_map(|entry| text(&mut File::open(entry.path()).ok()?))
            .map(|name| name.trim_end().to_string())
            .collect();
        Ok(Self {
            folder: folder.to_path_buf(),
            path,
            file,
            held,
        })
    }

    /// Writes down what is being tried; without room on the disk there is no mark.
    fn write(&mut self, names: &[&str]) {
        let mut lines = names.join("\n");
        lines.push('\n');
        let _ = self
            .file
            .rewind()
            .and_then(|()| self.file.set_len(0))
            .and_then(|()| self.file.write_all(lines.as_bytes()));
    }

    /// Whether this ended a program.
    #[must_use]
    fn holds(&self, name: &str) -> bool {
        self.held.contains(name)
    }

    /// Holds this from now on.
    fn hold(&mut self, name: &str) {
        hold(&self.folder, name);
        self.held.insert(name.to_string());
    }

    /// Holds it no longer.
    fn release(&mut self, name: &str) {
        if self.held.remove(name) {
            // One that cannot be removed is held again at the next start.
            let _ = std::fs::remove_file(held_file(&self.folder, name));
        }
    }
}

impl Drop for ActivityLocks {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Makes a folder that only its owner can look into.
fn make_private(folder: &Path) -> io::Result<()> {
    let mut builder = std::fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
}

fn has_name(path: &Path, begin: &str) -> bool {
    let name = path.file_name().and_then(|name| name.to_str());
    name.is_some_and(|name| name.starts_with(begin))
}

fn held_file(folder: &Path, name: &str) -> PathBuf {
    let digest = Sha256::digest(name.as_bytes());
    let digits: String = digest.iter().take(8).map(|b| format!("{b:02x}")).collect();
    folder.join(format!("{HELD}{digits}"))
}

fn hold(folder: &Path, name: &str) {
    // Nothing can be done where nothing can be written.
    let _ = std::fs::write(held_file(folder, name), format!("{name}\n"));
}

fn text(file: &mut File) -> Option<String> {
    let mut text = String::new();
    file.take(MAX_BYTES).read_to_string(&mut text).ok()?;
    Some(text)
}

/// Holds what a program was trying, if that program is gone: it has let go of its file.
fn take_up(folder: &Path, path: &Path) {
    let Ok(mut file) = OpenOptions::new().read(true).write(true).open(path) else {
        return;
    };
    if file.try_lock().is_err() {
        return;
    }
    let names = text(&mut file).unwrap_or_default();
    for name in names.lines().filter(|name| !name.is_empty()) {
        hold(folder, name);
    }
    let _ = std::fs::remove_file(path);
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

    #[test]
    fn what_a_program_that_is_gone_was_trying_is_held_until_released() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("marks");
        std::fs::create_dir(&place).unwrap();
        std::fs::write(place.join("running-1"), "scenario a\ntemplate b 1\n").unwrap();
        let mut marks = ActivityLocks::open(&place).unwrap();
        assert!(marks.holds("scenario a") && marks.holds("template b 1"));
        assert!(!place.join("running-1").exists());
        marks.release("scenario a");
        drop(marks);
        let marks = ActivityLocks::open(&place).unwrap();
        assert!(!marks.holds("scenario a") && marks.holds("template b 1"));
    }

    #[test]
    fn what_a_program_that_runs_is_trying_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let other = folder.path().join("running-1");
        let mut file = File::create(&other).unwrap();
        file.lock().unwrap();
        file.write_all(b"scenario a\n").unwrap();
        let mut marks = ActivityLocks::open(folder.path()).unwrap();
        assert!(!marks.holds("scenario a") && other.exists());
        marks.write(&["scenario b"]);
        let own = folder
            .path()
            .join(format!("running-{}", std::process::id()));
        assert_eq!(std::fs::read_to_string(&own).unwrap(), "scenario b\n");
        drop(marks);
        assert!(!own.exists());
        drop(file);
        assert!(
            ActivityLocks::open(folder.path())
                .unwrap()
                .holds("scenario a")
        );
    }
}
