//! The program as cargo builds it for a target, and what else of it a release needs.

use std::env::{self, consts};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde::Deserialize;

/// A program that is built, and what it prints for its users' shells and `man`.
pub struct Built {
    /// Folder of what cargo makes, `target`.
    pub folder: PathBuf,
    /// When its source was made, in seconds since 1970.
    pub time: u64,
    /// The file itself.
    pub program: Vec<u8>,
    /// Completions.
    pub bash: Vec<u8>,
    /// Completions.
    pub fish: Vec<u8>,
    /// Completions.
    pub zsh: Vec<u8>,
    /// Manual page.
    pub man: Vec<u8>,
}

/// The part of `cargo metadata` that is of use.
#[derive(Deserialize)]
struct Metadata {
    target_directory: PathBuf,
}

/// This machine; on Linux with musl, which needs nothing of the system that it runs on.
pub fn usual_target() -> String {
    let machine = consts::ARCH;
    match consts::OS {
        "linux" => format!("{machine}-unknown-linux-musl"),
        "macos" => format!("{machine}-apple-darwin"),
        other => format!("{machine}-unknown-{other}"),
    }
}

impl Built {
    /// Builds the program and runs it.
    ///
    /// # Errors
    /// There is no standard library of the target, it does not compile or run here, or nothing says when the source was
    /// made.
    pub fn for_target(target: &str) -> Result<Self, Box<dyn Error>> {
        check_standard_library(target)?;
        let time = time_of_source()?;
        run(&mut cargo("build", target)?)?;
        let metadata =
            printed(command("cargo").args(["metadata", "--no-deps", "--format-version=1"]))?;
        let metadata: Metadata = serde_json::from_slice(&metadata)?;
        let folder = metadata.target_directory;
        let completions = |kind| {
            let mut command = cargo("run", target)?;
            printed(command.args(["--quiet", "--", "completions", kind]))
        };
        Ok(Self {
            time,
            program: std::fs::read(folder.join(target).join("dist/nearmiss"))?,
            bash: completions("bash")?,
            fish: completions("fish")?,
            zsh: completions("zsh")?,
            man: completions("man")?,
            folder,
        })
    }
}

/// A command of cargo about the program. `cargo run` also runs programs of other machines, where cargo is told how
/// (`CARGO_TARGET_…_RUNNER`).
fn cargo(verb: &str, target: &str) -> Result<Command, Box<dyn Error>> {
    let mut command = command("cargo");
    command.args([verb, "--locked", "--profile=dist", "--package=nearmiss"]);
    command.args(["--target", target]);
    command.args(["--config", &remapped(target)?]);
    Ok(command)
}

/// Panics name files of crates and of Rust: these have the same names wherever they lie, without anybody's home.
fn remapped(target: &str) -> Result<String, Box<dyn Error>> {
    let cargo = match env::var_os("CARGO_HOME") {
        Some(folder) => folder.into(),
        None => env::home_dir().ok_or("no home folder")?.join(".cargo"),
    };
    let rust = String::from_utf8(printed(command("rustc").arg("--print=sysroot"))?)?;
    let flags = [(cargo, "cargo"), (rust.trim().into(), "rust")]
        .map(|(folder, name)| format!("--remap-path-prefix={}={name}", folder.display()));
    Ok(format!("target.{target}.rustflags={flags:?}"))
}

/// A file of the source, as `LICENSE`.
///
/// # Errors
/// It cannot be read.
pub fn source(file: &str) -> Result<Vec<u8>, Box<dyn Error>> {
    let file = root().join(file);
    std::fs::read(&file).map_err(|error| format!("{}: {error}", file.display()).into())
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// What rustc says of a missing library is lost among what it compiles.
fn check_standard_library(target: &str) -> Result<(), Box<dyn Error>> {
    let folder = printed(command("rustc").args(["--print=target-libdir", "--target", target]))?;
    let folder = String::from_utf8(folder)?;
    let mut files = Path::new(folder.trim()).read_dir().into_iter().flatten();
    let is_there = files.any(|file| {
        let name = file.map(|file| file.file_name());
        name.is_ok_and(|name| name.to_string_lossy().starts_with("libstd-"))
    });
    let missing =
        || format!("Rust has no library for {target} here; `rustup target add {target}` brings it");
    is_there.then_some(()).ok_or_else(|| missing().into())
}

/// `SOURCE_DATE_EPOCH`, or the time of the commit.
fn time_of_source() -> Result<u64, Box<dyn Error>> {
    let time = match env::var("SOURCE_DATE_EPOCH") {
        Ok(time) => time,
        Err(_) => String::from_utf8(printed(command("git").args(["log", "-1", "--format=%ct"]))?)?,
    };
    let wrong = |error| {
        format!("the time of the source is not in seconds: {error} (SOURCE_DATE_EPOCH sets it)")
    };
    Ok(time.trim().parse().map_err(wrong)?)
}

fn command(program: &str) -> Command {
    let mut command = Command::new(program);
    command.current_dir(root());
    command
}

/// What a command prints.
fn printed(command: &mut Command) -> Result<Vec<u8>, Box<dyn Error>> {
    Ok(run(command.stdout(Stdio::piped()))?.stdout)
}

fn run(command: &mut Command) -> Result<Output, Box<dyn Error>> {
    let name = command.get_program().to_string_lossy().into_owned();
    let child = command
        .spawn()
        .map_err(|error| format!("{name}: {error}"))?;
    let output = child.wait_with_output()?;
    if output.status.success() {
        return Ok(output);
    }
    let arguments = command.get_args().map(|word| word.to_string_lossy());
    let arguments: Vec<_> = arguments.collect();
    Err(format!("{name} {}: {}", arguments.join(" "), output.status).into())
}
