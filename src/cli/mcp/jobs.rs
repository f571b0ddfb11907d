//! Jobs that take time: commands of this program in processes of their own, with progress, cancelled by ending them.

use std::io::Read;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::catalogue::{Job, JobOption, JobValue};
use crate::system::ProcessGroup;

/// How often a job is looked at.
const POLL: Duration = Duration::from_millis(50);

/// How often progress is reported.
const TOLD: Duration = Duration::from_secs(1);

/// How long a command that is asked to end may take for that.
const GRACE: Duration = Duration::from_secs(3);

/// Longest time that a job may take.
const LONGEST_TIME: Duration = Duration::from_secs(3600);

/// Longest result that is given, bytes.
const LONGEST: u64 = 8 << 20;

/// The end of a job.
#[derive(Debug)]
pub enum JobEnd {
    /// Its output.
    Done(String),
    /// Why there is none.
    Failed(String),
    /// The client asked for an end.
    Cancelled,
}

/// The arguments of a job's command.
///
/// # Errors
/// In words: an argument is unknown, or not of its kind.
pub fn arguments(job: &Job, scenario: &str, given: &Value) -> Result<Vec<String>, String> {
    let mut words = vec![job.command.to_string(), scenario.to_string()];
    for (name, value) in given.as_object().into_iter().flatten() {
        // Some models write null for what they leave out.
        if name == "scenario" || value.is_null() {
            continue;
        }
        let known = job.options.iter().find(|known| known.name == name);
        let Some(known) = known else {
            let options = job.options.iter().map(|known| known.name);
            let all = std::iter::once("scenario").chain(options);
            let name: String = name.chars().take(64).collect();
            return Err(crate::system::unknown("argument", &name, all));
        };
        words.push(format!("{}={}", known.option, word(known, value)?));
    }
    Ok(words)
}

/// A value as a word of the command line.
fn word(option: &JobOption, value: &Value) -> Result<String, String> {
    let (word, expected) = match (option.value, value) {
        (JobValue::Text, Value::String(text)) if !text.starts_with('-') => {
            (Some(text.clone()), String::new())
        }
        (JobValue::Text, _) => (None, "text that does not begin with `-`".into()),
        (JobValue::Word(words), value) => {
            let given = value.as_str().filter(|given| words.contains(given));
            (given.map(str::to_string), words.join(" or "))
        }
        (JobValue::Whole(least, most), value) => {
            let whole = value.as_i64().map(i128::from);
            let whole = whole.or_else(|| value.as_u64().map(i128::from));
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

/// An error of a job's command in the words of its arguments: clients have no options.
pub fn told(job: &Job, why: &str) -> String {
    // What clap adds leads to a text that clients do not see.
    let why = why.replace("For more information, try '--help'.", "");
    let told = job.options.iter().fold(why, |why, option| {
        why.replace(option.option, &format!("`{}`", option.name))
    });
    told.trim_end().to_string()
}

/// Runs a job; `tell` is given the seconds it has taken so far.
pub fn run(
    job: &Job,
    mut words: Vec<String>,
    cancel: &AtomicBool,
    mut tell: impl FnMut(u64),
) -> JobEnd {
    let folder = match tempfile::tempdir() {
        Ok(folder) => folder,
        Err(why) => return JobEnd::Failed(why.to_string()),
    };
    let picture: Option<PathBuf> = (job.name == "render").then(|| folder.path().join("figure.svg"));
    match &picture {
        Some(path) => words.push(format!("--output={}", path.display())),
        None => words.push("--json".into()),
    }
    let program = std::env::current_exe();
    let child = program.and_then(|program| {
        let mut command = Command::new(program);
        // A group of its own: Ctrl-C reaches it once, from here, so that it may finish.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        command
            .args(&words)
            .current_dir(folder.path())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
    });
    let mut child = match child {
        Ok(child) => child,
        Err(why) => return JobEnd::Failed(why.to_string()),
    };
    let group = ProcessGroup::led_by(child.id());
    let out = read_aside(child.stdout.take());
    let err = read_aside(child.stderr.take());
    let begun = Instant::now();
    let mut told = begun;
    let status = loop {
        if cancel.load(Ordering::SeqCst) {
            end(&mut child);
            return JobEnd::Cancelled;
        }
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) => std::thread::sleep(POLL),
            Err(why) => return JobEnd::Failed(why.to_string()),
        }
        if begun.elapsed() > LONGEST_TIME {
            end(&mut child);
            let most = LONGEST_TIME.as_secs() / 60;
            return JobEnd::Failed(format!("it took longer than {most} minutes"));
        }
        if told.elapsed() >= TOLD {
            told = Instant::now();
            tell(begun.elapsed().as_secs());
        }
    };
    drop(group);
    let text = |reader: Option<std::thread::JoinHandle<String>>| {
        reader
            .and_then(|reader| reader.join().ok())
            .unwrap_or_default()
    };
    let (out, err) = (text(out), text(err));
    if out.len() as u64 > LONGEST {
        return JobEnd::Failed(format!("the result has more than {LONGEST} bytes"));
    }
    // Status 1 is a finding: the output says it.
    match (status.code(), picture) {
        (Some(0), Some(path)) => match std::fs::read_to_string(path) {
            Ok(svg) if svg.len() as u64 > LONGEST => {
                JobEnd::Failed(format!("the picture has more than {LONGEST} bytes"))
            }
            Ok(svg) => JobEnd::Done(svg),
            Err(why) => JobEnd::Failed(why.to_string()),
        },
        (Some(0 | 1), None) if !out.trim().is_empty() => JobEnd::Done(out),
        _ => JobEnd::Failed(match err.trim() {
            "" => "it ended without a result".into(),
            words => words.to_string(),
        }),
    }
}

/// Ends a command: asks it to end, so that it keeps what it has paid for, and ends it after [`GRACE`].
fn end(child: &mut Child) {
    #[cfg(unix)]
    if let Some(process) = i32::try_from(child.id())
        .ok()
        .and_then(rustix::process::Pid::from_raw)
    {
        let _ = rustix::process::kill_process(process, rustix::process::Signal::INT);
        let until = Instant::now() + GRACE;
        while Instant::now() < until && matches!(child.try_wait(), Ok(None)) {
            std::thread::sleep(POLL);
        }
    }
    let _ = child.kill();
    let _ = child.wait();
}

fn read_aside(pipe: Option<impl Read + Send + 'static>) -> Option<std::thread::JoinHandle<String>> {
    let pipe = pipe?;
    Some(std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let mut pipe = pipe.take(LONGEST + 1);
        let _ = pipe.read_to_end(&mut bytes);
        // What is too long is refused below; it is still read, so that the command can end.
        let _ = std::io::copy(&mut pipe.into_inner(), &mut std::io::sink());
        String::from_utf8_lossy(&bytes).into_owned()
    }))
}

/// The result of a job as the protocol has it.
pub fn result(job: &Job, text: &str) -> Value {
    let mut result = json!({"content": [{"type": "text", "text": text}], "isError": false});
    let line = text.lines().next().unwrap_or_default();
    if job.name != "render"
        && let Ok(document @ Value::Object(_)) = serde_json::from_str::<Value>(line)
    {
        result["structuredContent"] = document;
    }
    result
}

#[cfg(all(test, unix))]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A shell that has begun to wait, with what it does when it is asked to end.
    fn waiting(folder: &std::path::Path, when_asked: &str) -> Child {
        let script = format!("trap '{when_asked}' INT; touch begun; while :; do sleep 0.05; done");
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
}
