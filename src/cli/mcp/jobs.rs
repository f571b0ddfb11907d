//! Jobs: commands of this program in processes of their own, with progress, cancelled by ending them, within a budget.

use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use nearmiss_base::system::ProcessGroup;
use rmcp::model::{CallToolResult, ContentBlock, ProgressNotificationParam, ProgressToken};
use rmcp::service::{Peer, RequestContext, RoleServer};
use serde_json::Value;
use tokio::runtime::Handle;

use super::TAKEN_BACK;
use super::catalogue::{Gives, Job, JobOption, JobValue, is_moment};
use super::places::Places;

/// How often a job is looked at.
const POLL: Duration = Duration::from_millis(50);

/// How long a command that is asked to end may take for that.
const GRACE: Duration = Duration::from_secs(3);

/// Longest time that a job may take.
const LONGEST_TIME: Duration = Duration::from_secs(3600);

/// Longest result that is given, bytes.
const LONGEST_OUTPUT: u64 = 8 << 20;

/// What arguments are on the command line.
///
/// # Errors
/// In words: one is unknown, missing, or not of its kind.
pub fn command_line(options: &[JobOption], given: &Value) -> Result<Vec<String>, String> {
    let missing = |option: &&JobOption| option.required && given[option.name].is_null();
    if let Some(missing) = options.iter().find(missing) {
        return Err(format!(
            "argument `{}` is missing: {}",
            missing.name, missing.about
        ));
    }
    let mut words = Vec::new();
    for (name, value) in given.as_object().into_iter().flatten() {
        let Some(known) = options.iter().find(|known| known.name == name) else {
            let name: String = name.chars().take(64).collect();
            let all = options.iter().map(|known| known.name);
            return Err(nearmiss_base::system::unknown("argument", &name, all));
        };
        // Some models write null for what they leave out.
        if !value.is_null() {
            let word = word(known, value)?;
            words.extend((!known.option.is_empty()).then(|| format!("{}={word}", known.option)));
        }
    }
    let moment = |option: &&JobOption| matches!(option.value, JobValue::Moment);
    let moment = options.iter().find(moment);
    words.extend(
        { moment.filter(|at| given[at.name].is_null()) }.map(|at| format!("{}=worst", at.option)),
    );
    Ok(words)
}

/// A value as a word of the command line.
fn word(option: &JobOption, value: &Value) -> Result<String, String> {
    let (word, expected) = match (option.value, value) {
        (JobValue::Text, Value::String(text)) => (Some(text.clone()), String::new()),
        (JobValue::Text, _) => (None, "text".into()),
        (JobValue::Moment, value) => {
            let text = value
                .as_str()
                .map(str::to_string)
                .or_else(|| value.as_i64().map(|step| step.to_string()));
            let expected = "a time step (32), seconds (\"3.2s\"), or worst";
            (text.filter(|text| is_moment(text)), expected.into())
        }
        (JobValue::Word(words), value) => {
            let given = value.as_str().filter(|given| words.contains(given));
            (given.map(str::to_string), words.join(" or "))
        }
        (JobValue::Whole(least, most), value) => {
            let whole = value
                .as_i64()
                .map(i128::from)
                .or_else(|| value.as_u64().map(i128::from));
            let holds = |n: &i128| {
                least.is_none_or(|least| *n >= least.into())
                    && most.is_none_or(|most| *n <= most.into())
            };
            let range = match (least, most) {
                (Some(least), Some(most)) => format!("a whole number from {least} to {most}"),
                (Some(least), None) => format!("a whole number, {least} or more"),
                (None, Some(most)) => format!("a whole number, at most {most}"),
                (None, None) => "a whole number".into(),
            };
            (whole.filter(holds).map(|n| n.to_string()), range)
        }
        (JobValue::Number, Value::Number(n)) => (Some(n.to_string()), String::new()),
        (JobValue::Number, _) => (None, "a number".into()),
    };
    word.ok_or_else(|| {
        let got: String = value.to_string().chars().take(80).collect();
        format!("argument `{}` is {got}; expected {expected}", option.name)
    })
}

/// An error of a command in the words of its arguments: clients have no options.
pub fn with_argument_names(options: &[JobOption], why: &str) -> String {
    // What clap adds leads to a text that clients do not see.
    let why = why.replace("For more information, try '--help'.", "");
    let options = options.iter().filter(|option| !option.option.is_empty());
    let told = options.fold(why, |why, option| {
        why.replace(option.option, &format!("`{}`", option.name))
    });
    told.trim_end().to_string()
}

/// Runs a job with words of the command line, and gives its output.
///
/// # Errors
/// In words: it failed, took too long, or was taken back.
pub fn run(job: &Job, words: &[String], progress: &Progress) -> Result<Vec<u8>, String> {
    let io = |why: std::io::Error| why.to_string();
    let folder = tempfile::tempdir().map_err(io)?;
    let picture = (job.gives == Gives::Picture).then(|| folder.path().join("figure.png"));
    let output = match (&picture, job.gives) {
        (Some(path), _) => Some(format!("--output={}", path.display())),
        (None, Gives::Json) => Some("--format=json".to_string()),
        (None, _) => None,
    };
    let mut command = Command::new(std::env::current_exe().map_err(io)?);
    // A group of its own: Ctrl-C reaches it once, from here, so that it may finish.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command
        .args(job.command.split(' '))
        .args(words.iter().chain(&output))
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = command.spawn().map_err(io)?;
    let group = ProcessGroup::led_by(child.id());
    let out = read_aside(child.stdout.take());
    let err = read_aside(child.stderr.take());
    let begun = Instant::now();
    let status = loop {
        if progress.is_cancelled() {
            end(&mut child);
            return Err(TAKEN_BACK.into());
        }
        if let Some(status) = child.try_wait().map_err(io)? {
            break status;
        }
        std::thread::sleep(POLL);
        if begun.elapsed() > LONGEST_TIME {
            end(&mut child);
            let most = LONGEST_TIME.as_secs() / 60;
            return Err(format!("it took longer than {most} minutes"));
        }
        let seconds = begun.elapsed().as_secs();
        let (name, _) = job.command.split_once(' ').unwrap_or((job.command, ""));
        let words = format!("{name} runs for {seconds} s");
        progress.tell(usize::try_from(seconds).unwrap_or(usize::MAX), None, &words);
    };
    drop(group);
    let [out, err] = [out, err].map(|reader| {
        let read = reader.and_then(|reader| reader.join().ok());
        read.unwrap_or_default()
    });
    // Status 1 is a finding: the output says it.
    let given = match (status.code(), picture) {
        (Some(0), Some(path)) => std::fs::read(path).map_err(io)?,
        (Some(0 | 1), None) if !out.trim_ascii().is_empty() => out,
        _ => {
            let words = String::from_utf8_lossy(&err);
            return Err(match words.trim() {
                "" => "it ended without a result".into(),
                words => words.to_string(),
            });
        }
    };
    if given.len() as u64 > LONGEST_OUTPUT {
        Err(format!("the result has more than {LONGEST_OUTPUT} bytes"))
    } else {
        Ok(given)
    }
}

/// Ends a command: asks it to end, so that it keeps what it has paid for, and ends it after [`GRACE`].
fn end(child: &mut Child) {
    #[cfg(unix)]
    if let Some(process) = i32::try_from(child.id())
        .ok()
        .and_then(rustix::process::Pid::from_raw)
    {
        let _ = rustix::process::kill_process(process, rustix::process::Signal::TERM);
        let until = Instant::now() + GRACE;
        while Instant::now() < until && matches!(child.try_wait(), Ok(None)) {
            std::thread::sleep(POLL);
        }
    }
    let _ = child.kill();
    let _ = child.wait();
}

fn read_aside(pipe: Option<impl Read + Send + 'static>) -> Option<JoinHandle<Vec<u8>>> {
    let pipe = pipe?;
    Some(std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let mut pipe = pipe.take(LONGEST_OUTPUT + 1);
        let _ = pipe.read_to_end(&mut bytes);
        // What is too long is refused above; it is still read, so that the command can end.
        let _ = std::io::copy(&mut pipe.into_inner(), &mut std::io::sink());
        bytes
    }))
}

/// The result of a job as the protocol has it.
pub fn result(job: &Job, given: &[u8], places: &Places) -> CallToolResult {
    if job.gives == Gives::Picture {
        let picture = ContentBlock::image(BASE64_STANDARD.encode(given), "image/png");
        return CallToolResult::success(vec![picture]);
    }
    let text = places.told(&String::from_utf8_lossy(given));
    let line = text.lines().next().unwrap_or_default();
    let document = serde_json::from_str(line).ok().filter(Value::is_object);
    let mut result = CallToolResult::success(vec![ContentBlock::text(text)]);
    result.structured_content = document;
    result
}

/// How often progress is told.
const PROGRESS_INTERVAL: Duration = Duration::from_secs(1);

/// The progress of a request.
#[derive(Debug)]
pub struct Progress {
    /// Becomes true when the request is taken back.
    pub cancel: Arc<AtomicBool>,
    client: Peer<RoleServer>,
    /// What the client knows it by, if it wants to know.
    token: Option<ProgressToken>,
    told: Mutex<Instant>,
    runtime: Handle,
}

impl Progress {
    /// That of a request, in a task of the server.
    pub fn new(request: &RequestContext<RoleServer>) -> Self {
        Self {
            cancel: Arc::default(),
            client: request.peer.clone(),
            token: request.meta.get_progress_token(),
            told: Mutex::new(Instant::now()),
            runtime: Handle::current(),
        }
    }

    /// Whether the request was taken back.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::SeqCst)
    }

    /// Tells the progress in words, once in [`PROGRESS_INTERVAL`], to clients that want to know.
    pub fn tell(&self, done: usize, total: Option<usize>, words: &str) {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(token) = self
            .token
            .as_ref()
            .filter(|_| told.elapsed() >= PROGRESS_INTERVAL)
        else {
            return;
        };
        *told = Instant::now();
        let mut progress =
            ProgressNotificationParam::new(token.clone(), done as f64).with_message(words);
        progress.total = total.map(|total| total as f64);
        let client = self.client.clone();
        // A client that has gone is not told.
        self.runtime
            .spawn(async move { client.notify_progress(progress).await });
    }
}

/// The option and argument that limit the cost of one answer.
pub const BUDGET: &str = "budget";

/// Money that is left for a session, US dollars.
#[derive(Debug)]
pub struct SpendingLimit(Mutex<f64>);

impl SpendingLimit {
    /// One with so many US dollars.
    pub fn new(usd: f64) -> Self {
        Self(Mutex::new(usd))
    }

    /// Takes out what an answer may cost, US dollars: what its arguments say, or all that is left.
    ///
    /// # Errors
    /// In words: nothing is left, or less than the arguments ask for.
    pub fn reserve(&self, arguments: &Value) -> Result<f64, String> {
        let mut left = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let asked = arguments[BUDGET].as_f64().unwrap_or(*left);
        if asked < 0.0 {
            return Err(format!(
                "argument `{BUDGET}` is {asked}; it must not be negative"
            ));
        }
        if *left <= 0.0 || asked > *left {
            return Err(format!(
                "the session has {:.4} USD left of its --budget, and this answer may cost {asked:.4}",
                left.max(0.0)
            ));
        }
        *left -= asked;
        Ok(asked)
    }

    /// Puts back what an answer did not cost; nothing where the cost is not known.
    pub fn settle(&self, reserved: f64, given: &[u8]) {
        let line = given
            .split(|byte| *byte == b'\n')
            .next()
            .unwrap_or_default();
        let document: Value = serde_json::from_slice(line).unwrap_or_default();
        if let Some(cost) = document["cost_usd"].as_f64() {
            self.put_back((reserved - cost).max(0.0));
        }
    }

    /// Puts back what nothing was paid of.
    pub fn put_back(&self, usd: f64) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) += usd;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use serde_json::json;

    use super::*;

    /// A shell that has begun to wait, with what it does when it is asked to end.
    fn waiting(folder: &std::path::Path, when_asked: &str) -> Child {
        let script = format!("trap '{when_asked}' TERM; touch begun; while :; do sleep 0.05; done");
        let child = Command::new("sh")
            .args(["-c", &script])
            .current_dir(folder)
            .spawn()
            .unwrap();
        while !folder.join("begun").exists() {
            std::thread::sleep(POLL);
        }
        child
    }

    #[test]
    fn commands_may_finish_before_they_are_killed() {
        let folder = tempfile::tempdir().unwrap();
        let mut child = waiting(folder.path(), "touch kept; exit 0");
        end(&mut child);
        assert!(folder.path().join("kept").exists());
    }

    #[test]
    fn commands_that_do_not_finish_are_killed() {
        let folder = tempfile::tempdir().unwrap();
        let mut child = waiting(folder.path(), "");
        let begun = Instant::now();
        end(&mut child);
        assert!(begun.elapsed() >= GRACE);
        assert!(child.try_wait().unwrap().is_some());
    }

    #[test]
    fn a_session_spends_no_more_than_it_has() {
        let purse = SpendingLimit::new(1.0);
        let taken = |asked: Value| purse.reserve(&asked);
        assert_eq!(taken(json!({"budget": 0.6})), Ok(0.6));
        assert!(taken(json!({"budget": 0.6})).is_err());
        // Less than nothing would add to what is left.
        assert!(taken(json!({"budget": -5.0})).is_err());
        assert!(taken(json!({"budget": 0.6})).is_err());
        purse.settle(0.6, br#"{"cost_usd": 0.1}"#);
        assert_eq!(taken(json!({"budget": 0.6})), Ok(0.6));
        // An unknown cost may have been all of it.
        purse.settle(0.6, b"interrupted");
        let left = taken(json!({})).unwrap_or_default();
        assert!((left - 0.3).abs() < 1e-9, "{left}");
        assert!(taken(json!({})).is_err());
    }
}
