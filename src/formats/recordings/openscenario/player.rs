//! Plays what only a player works out: esmini, without a window, in a folder of its own, within bounds; its recordings are
//! kept.

use std::convert::Infallible;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant, UNIX_EPOCH};

use nearmiss_base::system::processes::{ended, limit, with_default};
use nearmiss_base::system::{self, FileCache, ProcessGroup, Unfinished};
use nearmiss_scene::scenario::ContentHash;

/// A program that plays OpenSCENARIO files as esmini does.
#[derive(Debug, Clone)]
pub struct Player {
    /// Its file.
    pub program: PathBuf,
    /// The folder in which its recordings are kept, if they are.
    pub kept: Option<PathBuf>,
    /// It is ended after so long.
    pub longest: Duration,
}

/// How long a scenario is played at most: esmini takes a second for hours.
pub const LONGEST: Duration = Duration::from_secs(60);

/// A player writes so much at most, bytes.
const MOST_WRITTEN: u64 = 128 << 20;

/// The folder of kept recordings grows to so much, bytes.
const MOST_KEPT: u64 = 1 << 30;

/// How often a player is looked at.
const POLL: Duration = Duration::from_millis(5);

/// The names of its files in its folder.
const RECORDING: &str = "played.csv";
const LOG: &str = "log.txt";
const SAID: &str = "said.txt";

static PLAYER: OnceLock<Result<Player, String>> = OnceLock::new();

/// Says who plays OpenSCENARIO files whose motion only a player works out; or in words why none does, and what to do. Said
/// once, before the first one is read, so that all readings of a file are the same.
pub fn play_with(player: Result<Player, String>) {
    // What is said again is what is said already: there is one configuration.
    let _ = PLAYER.set(player);
}

/// Why a file was not played, in words.
#[derive(Debug)]
pub enum NotPlayed {
    /// There is no player: what to install or set.
    NoPlayer(String),
    /// The player failed, or was ended.
    Failed(String),
}

/// Recordings, and failures, that are kept for other readings of a file, bytes.
const MAX_CACHED: usize = 64 << 20;

static PLAYED: FileCache<Result<Vec<u8>, String>> = FileCache::new(MAX_CACHED);

/// The recording of the first one of some files, in steps of so many seconds; it names the others.
///
/// # Errors
/// There is no player, or it failed.
pub fn play(files: &[PathBuf], time_step: f64) -> Result<Vec<u8>, NotPlayed> {
    let player = match PLAYER.get() {
        None => return Err(NotPlayed::NoPlayer(NO_PLAYER.into())),
        Some(Err(why)) => return Err(NotPlayed::NoPlayer(why.clone())),
        Some(Ok(player)) => player,
    };
    let paths: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    let played = PLAYED.get(&paths, || {
        let played = player.recording(files, time_step);
        let size = played.as_ref().map_or(0, Vec::len);
        Ok::<_, Infallible>((played, size))
    });
    match played.as_deref() {
        Ok(Ok(recording)) => Ok(recording.clone()),
        Ok(Err(why)) => Err(NotPlayed::Failed(why.clone())),
        Err(never) => match *never {},
    }
}

/// What is said where no player was named.
const NO_PLAYER: &str = "esmini plays it where it is installed";

impl Player {
    /// The recording of the first one of some files: that which is kept, else played now.
    fn recording(&self, files: &[PathBuf], time_step: f64) -> Result<Vec<u8>, String> {
        let name = format!("{}.csv", self.key(files, time_step));
        let Some(folder) = &self.kept else {
            return self.play(&files[0], time_step);
        };
        let kept = folder.join(name);
        if let Ok(recording) = std::fs::read(&kept) {
            return Ok(recording);
        }
        let recording = self.play(&files[0], time_step)?;
        // Where it cannot be kept it is played again.
        if system::make_folder(folder).is_ok() {
            make_room(folder, recording.len() as u64);
            let _ = system::save_private(&kept, &recording);
        }
        Ok(recording)
    }

    /// What a recording depends on: who plays it, and every file that is read.
    fn key(&self, files: &[PathBuf], time_step: f64) -> ContentHash {
        let hash = |bytes: &[u8]| ContentHash::digest(bytes).bytes();
        let mut parts = vec![hash(format!("{} {time_step}", self.identity()).as_bytes())];
        for (i, path) in files.iter().enumerate() {
            // Catalogs are found by their names.
            let name = path.file_name().filter(|_| i > 0).unwrap_or_default();
            let bytes = system::read_file(path, system::LARGEST).unwrap_or_default();
            parts.extend([hash(name.as_encoded_bytes()), hash(&bytes)]);
        }
        ContentHash::of_parts(parts.iter().map(<[u8; 32]>::as_slice))
    }

    /// Which program it is: another one of the same name differs in size or date.
    fn identity(&self) -> String {
        let about = std::fs::metadata(&self.program).ok();
        let changed = { about.as_ref() }
            .and_then(|about| about.modified().ok()?.duration_since(UNIX_EPOCH).ok());
        format!(
            "{} {} {}",
            self.program.display(),
            about.map_or(0, |about| about.len()),
            changed.unwrap_or_default().as_nanos()
        )
    }

    /// Plays a file now.
    fn play(&self, file: &Path, time_step: f64) -> Result<Vec<u8>, String> {
        let program = self.program.display();
        let io = |what: &str, error: &std::io::Error| {
            format!("{program}: {what}: {}", system::error_text(error))
        };
        let cannot = |error: std::io::Error| io("its folder", &error);
        let folder = tempfile::Builder::new()
            .prefix("nearmiss-")
            .tempdir()
            .map_err(cannot)?;
        let _gone_at_the_end = Unfinished::begin(folder.path());
        let said = File::create_new(folder.path().join(SAID)).map_err(cannot)?;
        let mut command = Command::new(&self.program);
        command
            .arg("--osc")
            .arg(std::path::absolute(file).map_err(cannot)?)
            .args(["--headless", "--disable_stdout", "--seed", "0"])
            .args(["--fixed_timestep", &time_step.to_string()])
            .args(["--csv_logger", RECORDING, "--logfile_path", LOG])
            .current_dir(folder.path())
            .stdin(Stdio::null())
            .stdout(said.try_clone().map_err(cannot)?)
            .stderr(said);
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let child =
            with_default(|| command.spawn()).map_err(|error| io("cannot be run", &error))?;
        let mut running = Running::new(child);
        limit(&running.child, 2 * self.longest.as_secs(), MOST_WRITTEN);
        let until = Instant::now() + self.longest;
        let why = loop {
            // Of what had ended by then it was the end.
            if written(folder.path()) >= MOST_WRITTEN {
                let most = MOST_WRITTEN >> 20;
                break Some(format!("wrote {most} MiB without coming to an end"));
            }
            if let Some(how) = ended(&mut running.child) {
                break (how != "exit status 0").then(|| format!("failed ({how})"));
            }
            if Instant::now() > until {
                let seconds = self.longest.as_secs_f64();
                break Some(format!("did not end within {seconds} s"));
            }
            std::thread::sleep(POLL);
        };
        drop(running);
        let failed = |why: &str| {
            let mut words = format!("{program} {why}");
            if let Some(last) = last_error(folder.path()) {
                words.push_str(": ");
                words.push_str(&last);
            }
            words
        };
        if let Some(why) = why {
            return Err(failed(&why));
        }
        match std::fs::read(folder.path().join(RECORDING)) {
            Ok(recording) => Ok(without_path(&recording)),
            Err(_) => Err(failed("recorded nothing")),
        }
    }
}

/// A player that runs; nothing of it is left behind.
struct Running {
    child: Child,
    group: ProcessGroup,
}

impl Running {
    fn new(child: Child) -> Self {
        let group = ProcessGroup::led_by(child.id());
        Self { child, group }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.group.kill();
        self.group.forget();
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Bytes in a folder.
fn written(folder: &Path) -> u64 {
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    files
        .filter_map(|file| Some(file.metadata().ok()?.len()))
        .sum()
}

/// So much of the end of a log is looked at, bytes.
const END: usize = 64 << 10;

/// The last error that a player told, else the last line that it said.
fn last_error(folder: &Path) -> Option<String> {
    let text = |name: &str| {
        let bytes = std::fs::read(folder.join(name)).unwrap_or_default();
        let end = &bytes[bytes.len().saturating_sub(END)..];
        String::from_utf8_lossy(end).into_owned()
    };
    let texts = [text(LOG), text(SAID)];
    let mut errors = { texts.iter().flat_map(|text| text.lines().rev()) }
        .filter_map(|line| Some(line.rsplit_once("[error]")?.1));
    let last = || {
        let mut lines = texts.iter().rev().flat_map(|text| text.lines().rev());
        lines.find(|line| !line.trim().is_empty())
    };
    let line = errors.next().or_else(last)?;
    Some(line.trim().chars().take(LONGEST_LINE).collect())
}

/// Letters of a line that is shown.
const LONGEST_LINE: usize = 300;

/// A recording without the line that says where the file lay: it is the same wherever that is.
fn without_path(recording: &[u8]) -> Vec<u8> {
    let lines = recording.split_inclusive(|byte| *byte == b'\n');
    let others = lines.filter(|line| !line.starts_with(b"Scenario File Name:"));
    others.flatten().copied().collect()
}

/// Removes the oldest recordings until so much more is no more than [`MOST_KEPT`].
fn make_room(folder: &Path, more: u64) {
    let all = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<_> = all
        .filter_map(|file| {
            let about = file.metadata().ok().filter(std::fs::Metadata::is_file)?;
            Some((about.modified().ok()?, about.len(), file.path()))
        })
        .collect();
    files.sort();
    let mut size_of_all = more + files.iter().map(|(_, size, _)| size).sum::<u64>();
    for (_, size, path) in files {
        if size_of_all <= MOST_KEPT {
            return;
        }
        let _ = std::fs::remove_file(path);
        size_of_all -= size;
    }
}

#[cfg(all(test, unix))]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::os::unix::fs::PermissionsExt;

    use super::*;

    /// A folder with a scenario, a catalog and a program that does what a script says; its recording is `$out`.
    fn stage(script: &str) -> (tempfile::TempDir, Player, Vec<PathBuf>) {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let program = at("player.sh");
        let text = format!(
            "#!/bin/sh\nhome='{}'\nwhile [ $# -gt 0 ]; do case $1 in --csv_logger) out=$2;; --osc) osc=$2;; esac; shift; done\n{script}\n",
            folder.path().display()
        );
        std::fs::write(&program, text).unwrap();
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
        let files = vec![at("x.xosc"), at("cars.xosc")];
        for file in &files {
            std::fs::write(file, "1").unwrap();
        }
        let player = Player {
            program,
            kept: Some(at("kept")),
            longest: Duration::from_secs(20),
        };
        (folder, player, files)
    }

    #[test]
    fn each_file_is_played_once_and_again_when_something_of_it_changes() {
        let script = "echo . >> $home/played; printf 'esmini GIT TAG: v1\\nScenario File Name: %s\\nrows\\n' $osc > $out; pwd > $home/where";
        let (folder, player, files) = stage(script);
        let at = |name: &str| folder.path().join(name);
        let played = || {
            std::fs::read_to_string(at("played"))
                .unwrap()
                .lines()
                .count()
        };
        let recording = || player.recording(&files, 0.1).unwrap();
        assert_eq!(recording(), b"esmini GIT TAG: v1\nrows\n");
        assert_eq!(recording(), b"esmini GIT TAG: v1\nrows\n");
        assert_eq!(played(), 1);
        // Its folder was one of its own, and is gone.
        let own = PathBuf::from(std::fs::read_to_string(at("where")).unwrap().trim());
        assert!(own != folder.path() && !own.exists(), "{}", own.display());
        for (i, file) in files.iter().chain([&player.program]).enumerate() {
            let mut text = std::fs::read_to_string(file).unwrap();
            text.push_str("\n# other\n");
            std::fs::write(file, text).unwrap();
            recording();
            assert_eq!(played(), 2 + i);
        }
        player.recording(&files, 0.2).unwrap();
        assert_eq!(played(), 5);
    }

    #[test]
    fn one_that_hangs_is_ended_with_all_that_it_started() {
        let script = "echo '[1.0] [error] waits for the wind' > log.txt; sleep 600 & echo $! > $home/child; sleep 600";
        let (folder, mut player, files) = stage(script);
        player.longest = Duration::from_secs(1);
        let begun = Instant::now();
        let why = player.recording(&files, 0.1).unwrap_err();
        assert!(begun.elapsed() < Duration::from_secs(15));
        assert!(
            why.ends_with("did not end within 1 s: waits for the wind"),
            "{why}"
        );
        let child = std::fs::read_to_string(folder.path().join("child")).unwrap();
        let status = Path::new("/proc").join(child.trim()).join("status");
        // One that was killed may wait for its parent to notice.
        let runs = || std::fs::read_to_string(&status).is_ok_and(|s| !s.contains("State:\tZ"));
        let until = Instant::now() + Duration::from_secs(5);
        while runs() && Instant::now() < until {
            std::thread::sleep(POLL);
        }
        assert!(!runs());
        assert!(!folder.path().join("kept").exists());
    }

    #[test]
    fn one_that_fails_or_floods_or_says_nothing_is_told_with_its_last_error() {
        let why = |script: &str| {
            let (_folder, player, files) = stage(script);
            player.recording(&files, 0.1).unwrap_err()
        };
        let log = "printf '[] [error] first\\n[] [error] Exception: [] [error] no road 7\\n[] [info] bye\\n' > log.txt";
        assert!(why(&format!("{log}; exit 3")).ends_with("failed (exit status 3): no road 7"));
        assert!(why("echo 'what is --seed?' >&2; exit 1").ends_with("what is --seed?"));
        assert!(why("exit 0").ends_with("recorded nothing"));
        assert!(why("exec yes > $out").ends_with("wrote 128 MiB without coming to an end"));
        let (folder, mut player, files) = stage("");
        player.program = folder.path().join("no-such");
        assert!(
            player
                .recording(&files, 0.1)
                .unwrap_err()
                .contains("cannot be run")
        );
    }

    #[test]
    fn the_oldest_recordings_make_room() {
        let folder = tempfile::tempdir().unwrap();
        for (name, age) in [("new", 1), ("old", 100)] {
            let file = File::create(folder.path().join(name)).unwrap();
            file.set_len(MOST_KEPT / 2).unwrap();
            let changed = std::time::SystemTime::now() - Duration::from_secs(age);
            file.set_modified(changed).unwrap();
        }
        make_room(folder.path(), 1);
        let left = std::fs::read_dir(folder.path()).unwrap().flatten();
        let left: Vec<_> = left.map(|file| file.file_name()).collect();
        assert_eq!(left, ["new"]);
    }
}
