//! `nearmiss slurm`: writes Slurm scripts that run a command in parts.

mod command;
mod script;

use std::path::{Path, PathBuf};

use super::output::{self, Target};
use super::{Failure, Outcome};
use command::PartCommand;
use script::{Resources, Scripts, quoted};

/// Arguments of `slurm`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Writes DIR/array.sh, a job array with a task for each part, and for `evaluate` DIR/join.sh, which joins the parts and \
writes the report. Prints the command that submits them: `nearmiss slurm … | sh` does so.")]
pub struct Slurm {
    /// Number of parts, each a task of the job array.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    parts: u32,
    /// Folder for scripts, logs and stores, on a file system that all nodes share; created if missing.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Maximum number of parts that run at the same time [default: as many as the cluster allows].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    at_once: Option<u32>,
    /// Partition.
    #[arg(long, value_name = "NAME", value_parser = word)]
    partition: Option<String>,
    /// Account.
    #[arg(long, value_name = "NAME", value_parser = word)]
    account: Option<String>,
    /// Time limit of a part, such as 90 (minutes), 12:00:00 or 1-12:00:00.
    #[arg(long, value_name = "TIME", value_parser = time)]
    time: Option<String>,
    /// Memory of a part, such as 4G.
    #[arg(long, value_name = "SIZE", value_parser = memory)]
    memory: Option<String>,
    /// Processors of a part.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    cpus: Option<u32>,
    /// The program on the nodes [default: this one].
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
    /// File with environment variables that each part reads, such as keys: lines NAME=value in the syntax of sh.
    #[arg(long, value_name = "FILE")]
    env_file: Option<PathBuf>,
    /// Replace earlier scripts in DIR.
    #[arg(long)]
    overwrite: bool,
    /// The command behind `--`, without --shard and --resume: evaluate FILE.toml, or metrics, index, plan, generate,
    /// render or convert with -o. `{part}` in it becomes the number of the part.
    #[arg(last = true, required = true, value_name = "COMMAND")]
    command: Vec<String>,
}

/// Runs `slurm`.
pub fn run(arguments: &Slurm) -> Outcome {
    let command = PartCommand::new(&arguments.command, arguments.parts)?;
    let folder = absolute(&arguments.output)?;
    if folder.to_string_lossy().contains('\\') {
        return Err(Failure::input(format!(
            "{}: Slurm writes no logs to a path with a backslash; choose another folder",
            folder.display()
        )));
    }
    let program = match &arguments.program {
        Some(program) => there(program)?,
        None => std::env::current_exe().map_err(|e| Failure::system("this program", &e))?,
    };
    let env_file = arguments.env_file.as_deref().map(there).transpose()?;
    let here = std::env::current_dir().map_err(|e| Failure::system("this folder", &e))?;
    let scripts = Scripts {
        command: &command,
        parts: arguments.parts,
        at_once: arguments.at_once,
        folder: text(&folder)?,
        program: text(&program)?,
        here: text(&here)?,
        env_file: env_file.as_deref().map(text).transpose()?,
        resources: Resources {
            partition: arguments.partition.as_deref(),
            account: arguments.account.as_deref(),
            time: arguments.time.as_deref(),
            memory: arguments.memory.as_deref(),
            cpus: arguments.cpus,
        },
    };
    let logs = folder.join("logs");
    std::fs::create_dir_all(&logs).map_err(|e| Failure::system(logs.display(), &e))?;
    let array = folder.join("array.sh");
    let join = folder.join("join.sh");
    // Both can be begun, or neither is written.
    let first = Target::begin(Some(&array), arguments.overwrite)?;
    let second = scripts.join().map(|text| {
        let target = Target::begin(Some(&join), arguments.overwrite)?;
        Ok::<_, Failure>((target, text))
    });
    let second = second.transpose()?;
    first.save(scripts.array().as_bytes())?;
    if let Some((target, text)) = second {
        target.save(text.as_bytes())?;
    }
    warn(&[&folder, &here, &program], env_file.as_deref());
    command.notes(arguments.parts).iter().for_each(|note| {
        output::say(&output::visible(&format!("nearmiss: {note}")));
    });
    let array = quoted(text(&array)?);
    output::text(&match command.is_joined() {
        true => format!(
            "sbatch --kill-on-invalid-dep=yes --dependency=afterok:\"$(sbatch --parsable {array})\" {}\n",
            quoted(text(&join)?)
        ),
        false => format!("sbatch {array}\n"),
    })
}

/// Folders that every machine has of its own.
const LOCAL: [&str; 4] = ["/tmp", "/var/tmp", "/dev/shm", "/run"];

/// Says which files the nodes may not see, and who else can read the keys.
fn warn(paths: &[&Path], env_file: Option<&Path>) {
    let local = |path: &&Path| LOCAL.iter().any(|root| path.starts_with(root));
    let local = paths.iter().copied().chain(env_file).filter(local);
    let local: Vec<String> = local.map(|path| path.display().to_string()).collect();
    if !local.is_empty() {
        output::say(&format!(
            "nearmiss: every machine has its own {}; the nodes need the same files at {}",
            LOCAL.join(", "),
            local.join(", ")
        ));
    }
    let Some(file) = env_file else {
        return;
    };
    if is_open(file) {
        output::say(&format!(
            "nearmiss: {}: other users can read this file; `chmod 600` keeps keys private",
            file.display()
        ));
    }
}

/// Whether other users can read a file.
#[cfg(unix)]
fn is_open(file: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    let metadata = file.metadata();
    metadata.is_ok_and(|file| file.permissions().mode() & 0o077 != 0)
}

/// Whether other users can read a file: elsewhere that is not known.
#[cfg(not(unix))]
fn is_open(_file: &Path) -> bool {
    false
}

fn absolute(path: &Path) -> Result<PathBuf, Failure> {
    std::path::absolute(path).map_err(|e| Failure::system(path.display(), &e))
}

/// The absolute path of a file that is there.
fn there(path: &Path) -> Result<PathBuf, Failure> {
    let metadata = path.metadata();
    match metadata.map_err(|e| Failure::system(path.display(), &e))? {
        found if found.is_file() => absolute(path),
        _ => Err(Failure::input(format!(
            "{}: expected a file",
            path.display()
        ))),
    }
}

/// A path as a script can name it, in one line.
fn text(path: &Path) -> Result<&str, Failure> {
    let text = path
        .to_str()
        .filter(|text| !text.chars().any(char::is_control));
    text.ok_or_else(|| {
        Failure::input(format!(
            "{}: a script cannot name this path: it has control characters or is not UTF-8",
            path.display()
        ))
    })
}

/// A name in a line of `#SBATCH`.
fn word(text: &str) -> Result<String, String> {
    let allowed = |c: char| c.is_alphanumeric() || "_-.,:@%+/".contains(c);
    match !text.is_empty() && !text.starts_with('-') && text.chars().all(allowed) {
        true => Ok(text.into()),
        false => Err("expected a name without spaces and quotes".into()),
    }
}

fn time(text: &str) -> Result<String, String> {
    let (days, clock) = match text.split_once('-') {
        Some((days, clock)) => (Some(days), clock),
        None => (None, text),
    };
    let clock: Vec<&str> = clock.split(':').collect();
    let number = |word: &str| !word.is_empty() && word.chars().all(|c| c.is_ascii_digit());
    match clock.len() <= 3 && clock.into_iter().chain(days).all(number) {
        true => Ok(text.into()),
        false => {
            Err("expected minutes, hours:minutes:seconds or days-hours:minutes:seconds".into())
        }
    }
}

fn memory(text: &str) -> Result<String, String> {
    let number = text.strip_suffix(['K', 'M', 'G', 'T']).unwrap_or(text);
    match number.parse::<u64>() {
        Ok(1..) => Ok(text.into()),
        _ => Err("expected megabytes, or a number with K, M, G or T, such as 4G".into()),
    }
}
