//! Jobs that take time: commands of this program in processes of their own, with progress, cancelled by ending them.

use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};

use super::aside::Aside;
use super::catalogue::{Gives, Job, JobOption, JobValue, is_moment};
use super::places::Places;
use nearmiss_base::system::ProcessGroup;

/// How often a job is looked at.
const POLL: Duration = Duration::from_millis(50);

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
    Done(Vec<u8>),
    /// Why there is none.
    Failed(String),
    /// The client asked for an end.
    Cancelled,
}

/// What arguments are on the command line.
///
/// # Errors
/// In words: one is unknown, missing, or not of its kind.
pub fn words(options: &[JobOption], given: &Value) -> Result<Vec<String>, String> {
    if !(given.is_object() || given.is_null()) {
        return Err("the arguments are no JSON object".into());
    }
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

/// An error of a job's command in the words of its arguments: clients have no options.
pub fn told(job: &Job, why: &str) -> String {
    // What clap adds leads to a text that clients do not see.
    let why = why.replace("For more information, try '--help'.", "");
    let options = job
        .options
        .iter()
        .filter(|option| !option.option.is_empty());
    let told = options.fold(why, |why, option| {
        why.replace(option.option, &format!("`{}`", option.name))
    });
    told.trim_end().to_string()
}

/// Runs a job about a scenario.
pub fn run(job: &Job, scenario: &str, words: &[String], aside: &Aside<'_>) -> JobEnd {
    let folder = match tempfile::tempdir() {
        Ok(folder) => folder,
        Err(why) => return JobEnd::Failed(why.to_string()),
    };
    let picture = (job.gives == Gives::Picture).then(|| folder.path().join("figure.png"));
    let output = match (&picture, job.gives) {
        (Some(path), _) => Some(format!("--output={}", path.display())),
        (None, Gives::Json) => Some("--format=json".to_string()),
        (None, _) => None,
    };
    let program = std::env::current_exe();
    let child = program.and_then(|program| {
        let mut command = Command::new(program);
        // A group of its own: Ctrl-C reaches it once, from here, so that it may finish.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        command
            .args(job.command)
            .arg(scenario)
            .args(words.iter().chain(&output))
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
    let status = loop {
        if aside.is_cancelled() {
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
        let seconds = begun.elapsed().as_secs();
        let said = format!("{} runs for {seconds} s", job.name);
        aside.tell(usize::try_from(seconds).unwrap_or(usize::MAX), None, &said);
    };
    drop(group);
    let [out, err] = [out, err].map(|reader| {
        let read = reader.and_then(|reader| reader.join().ok());
        read.unwrap_or_default()
    });
    // Status 1 is a finding: the output says it.
    let given = match (status.code(), picture) {
        (Some(0), Some(path)) => match std::fs::read(path) {
            Ok(picture) => picture,
            Err(why) => return JobEnd::Failed(why.to_string()),
        },
        (Some(0 | 1), None) if !out.trim_ascii().is_empty() => out,
        _ => {
            let words = String::from_utf8_lossy(&err);
            return JobEnd::Failed(match words.trim() {
                "" => "it ended without a result".into(),
                words => words.to_string(),
            });
        }
    };
    if given.len() as u64 > LONGEST {
        JobEnd::Failed(format!("the result has more than {LONGEST} bytes"))
    } else {
        JobEnd::Done(given)
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

fn read_aside(pipe: Option<impl Read + Send + 'static>) -> Option<JoinHandle<Vec<u8>>> {
    let pipe = pipe?;
    Some(std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let mut pipe = pipe.take(LONGEST + 1);
        let _ = pipe.read_to_end(&mut bytes);
        // What is too long is refused above; it is still read, so that the command can end.
        let _ = std::io::copy(&mut pipe.into_inner(), &mut std::io::sink());
        bytes
    }))
}

/// The result of a job as the protocol has it.
pub fn result(job: &Job, given: &[u8], places: &Places) -> Value {
    if job.gives == Gives::Picture {
        let picture = BASE64_STANDARD.encode(given);
        let content = json!([{"type": "image", "data": picture, "mimeType": "image/png"}]);
        return json!({"content": content, "isError": false});
    }
    let text = places.told(&String::from_utf8_lossy(given));
    let mut result = json!({"content": [{"type": "text", "text": text}], "isError": false});
    let line = text.lines().next().unwrap_or_default();
    if let Ok(document @ Value::Object(_)) = serde_json::from_str::<Value>(line) {
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
