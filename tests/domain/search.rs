//! Searching folders: scenarios are found, what only looks like one is named with why, and the rest is not worth a
//! word.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::{Path, PathBuf};

use nearmiss::formats::{LibraryError, PassedOverReason, SearchResults, find};
use tempfile::{TempDir, tempdir};

use crate::support::program;

const ROOT: &str = "<commonRoad timeStepSize=\"0.1\" commonRoadVersion=\"2020a\">";

fn put(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, bytes).unwrap();
}

fn search(folder: &TempDir) -> Result<SearchResults, LibraryError> {
    find(&[folder.path().to_path_buf()])
}

/// Names of what was found, and of what was passed over with why.
fn both(folder: &TempDir) -> (Vec<String>, Vec<String>) {
    let found = search(folder).unwrap();
    let names = found.entries.iter().map(|e| e.name.clone()).collect();
    let shown = |path: &Path| {
        let inside = path.strip_prefix(folder.path()).unwrap();
        inside.display().to_string()
    };
    let passed_over = found
        .passed_over
        .iter()
        .map(|p| format!("{}: {}", shown(&p.path), p.why));
    (names, passed_over.collect())
}

fn utf16(text: &str, unit: fn(u16) -> [u8; 2]) -> Vec<u8> {
    text.encode_utf16().flat_map(unit).collect()
}

#[test]
fn scenarios_are_found_however_late_their_root_is() {
    let folder = tempdir().unwrap();
    let put = |name: &str, text: String| put(folder.path(), name, text);
    put("plain.xml", ROOT.into());
    put("UPPER.XML", ROOT.into());
    put("marked.xml", format!("\u{feff}{ROOT}"));
    let licence =
        |length: usize| format!("<?xml version=\"1.0\"?>\n<!--{}-->\n", "é ".repeat(length));
    for length in [2030, 2040, 5000, 60_000] {
        put(&format!("late-{length}.xml"), licence(length / 3) + ROOT);
    }
    let author = format!(
        "<commonRoad author=\"{}\" timeStepSize=\"0.1\">",
        "a".repeat(9000)
    );
    put("long-tag.xml", author);
    let (found, passed_over) = both(&folder);
    assert_eq!(
        found,
        [
            "UPPER",
            "late-2030",
            "late-2040",
            "late-5000",
            "late-60000",
            "long-tag",
            "marked",
            "plain"
        ]
    );
    assert_eq!(passed_over, [""; 0]);
}

#[test]
fn what_looks_like_a_scenario_and_is_not_known_to_be_one_is_named_with_why() {
    let folder = tempdir().unwrap();
    let at = folder.path();
    put(at, "good.xml", ROOT);
    put(at, "empty.xml", "");
    put(at, "empty.pb", "");
    put(at, "packed.xml", [0x1f, 0x8b, 8, 0]);
    put(at, "packed.pb", [0x1f, 0x8b, 8, 0]);
    put(at, "sub/zip.xml", b"PK\x03\x04rest");
    put(
        at,
        "marked.xml",
        utf16(&format!("\u{feff}{ROOT}"), u16::to_le_bytes),
    );
    put(
        at,
        "big.xml",
        utf16(&format!("\u{feff}{ROOT}"), u16::to_be_bytes),
    );
    put(at, "bare.xml", utf16(ROOT, u16::to_le_bytes));
    put(at, "words.xml", "these are words");
    put(
        at,
        "deep.xml",
        format!("<!--{}-->{ROOT}", " ".repeat(70_000)),
    );
    put(at, "graph.pb", b"\x0a\x03abc");
    put(at, "markup.pb", ROOT);
    // Plainly something else.
    put(
        at,
        "pom.xml",
        "<?xml version=\"1.0\"?><project><commonRoad/></project>",
    );
    put(at, "solution.xml", "<CommonRoadSolution benchmark_id=\"\">");
    put(at, "map.xml", "<commonRoadMap>");
    put(at, "comment.xml", "<!-- <commonRoad> --><html/>");
    put(
        at,
        "wide-pom.xml",
        utf16("\u{feff}<project>", u16::to_le_bytes),
    );
    put(at, "notes.txt", "");
    put(at, ".git/empty.xml", "");
    let (found, passed_over) = both(&folder);
    assert_eq!(found, ["bare", "big", "good", "marked"], "UTF-16 is read");
    assert_eq!(
        passed_over,
        [
            "deep.xml: no XML element in its first 64 KiB",
            "empty.pb: empty",
            "empty.xml: empty",
            "graph.pb: not a CommonRoad message, or damaged at its beginning",
            "markup.pb: XML; its name should end in .xml",
            "packed.pb: compressed with gzip; unpack it first",
            "packed.xml: compressed with gzip; unpack it first",
            "sub/zip.xml: a ZIP archive; unpack it first",
            "words.xml: no XML element in its first 64 KiB",
        ]
    );
}

#[cfg(unix)]
#[test]
fn of_the_folders_of_the_paper_those_of_results_are_passed_over() {
    let folder = tempdir().unwrap();
    let put = |name: &str, text: &str| put(folder.path(), name, text);
    for name in [
        "Scenarios/a.xml",
        "more/b.xml",
        "Generation/c.xml",
        "Results/d.xml",
    ] {
        put(name, ROOT);
    }
    let tracks = "time,id,x,y\n0,1,0,0\n0.1,1,1,0\n0.2,1,2,0\n";
    put("own/tracks.csv", tracks);
    // What lies beside an ego's recording are its results.
    put("more/b/ego_trajectory.csv", "timestep\n");
    put("more/b/close_dynamic_obstacles.csv", tracks);
    let (mut found, _) = both(&folder);
    found.sort();
    assert_eq!(found, ["a", "b", "tracks"]);
}

#[test]
fn links_are_followed_once_and_pipes_are_not_opened() {
    use std::os::unix::fs::symlink;
    let (folder, other) = (tempdir().unwrap(), tempdir().unwrap());
    let at = folder.path();
    put(at, "a/one.xml", ROOT);
    put(other.path(), "two.xml", ROOT);
    // Circles, and a second way to what is there.
    symlink(at, at.join("a/up")).unwrap();
    symlink(at.join("a"), at.join("Z")).unwrap();
    symlink(at.join("a"), at.join("a/self")).unwrap();
    symlink(other.path(), at.join("elsewhere")).unwrap();
    symlink(at.join("nowhere"), at.join("gone.xml")).unwrap();
    symlink(at.join("nowhere"), at.join("gone")).unwrap();
    let made = std::process::Command::new("mkfifo")
        .arg(at.join("pipe.xml"))
        .status();
    let (found, passed_over) = both(&folder);
    assert_eq!(found, ["one", "two"]);
    let mut expected = vec!["gone.xml: no such file or folder"];
    if made.is_ok_and(|status| status.success()) {
        expected.push("pipe.xml: not a regular file");
    }
    assert_eq!(passed_over, expected);
}

#[cfg(unix)]
#[test]
fn what_may_not_be_read_is_named() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempdir().unwrap();
    let at = folder.path();
    put(at, "good.xml", ROOT);
    put(at, "secret.xml", ROOT);
    put(at, "private/hidden.xml", ROOT);
    let allow = |name: &str, mode| {
        let rights = std::fs::Permissions::from_mode(mode);
        std::fs::set_permissions(at.join(name), rights).unwrap();
    };
    allow("secret.xml", 0o000);
    allow("private", 0o000);
    let open = std::fs::File::open(at.join("secret.xml")).is_ok();
    let found = search(&folder);
    let said = both(&folder);
    allow("private", 0o700);
    if open {
        crate::support::program::skipped("this user may read everything");
        return;
    }
    assert_eq!(said.0, ["good"]);
    assert_eq!(
        said.1,
        [
            "private: not searched: Permission denied (os error 13)",
            "secret.xml: Permission denied (os error 13)"
        ]
    );
    let found = found.unwrap();
    assert!(matches!(
        found.passed_over[0].why,
        PassedOverReason::Folder(_)
    ));
    let words = found.passed_over_in_short().unwrap();
    assert!(
        words.starts_with("1 file and 1 folder skipped: "),
        "{words}"
    );
}

#[test]
fn commands_say_what_was_passed_over() {
    let home = program::Home::new();
    let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let name = "ZAM_CutIn-1_1_T-1";
    for ending in ["xml", "ego_trajectory.csv"] {
        let file = format!("{name}.{ending}");
        home.write(
            format!("in/{file}"),
            std::fs::read(bundled.join(&file)).unwrap(),
        );
    }
    let folder = PathBuf::from("in");
    home.write("in/pom.xml", "<project/>");
    for (count, lines) in [(5, 6), (30, 1)] {
        for i in 0..count {
            home.write(folder.join(format!("e{i:02}.xml")), "");
        }
        for arguments in [
            &["metrics", "in"][..],
            &["convert", "in"],
            &["evaluate", "in"],
            &["in"],
        ] {
            let ended = home.run(arguments).status(0);
            let said = ended.stderr.lines();
            let said: Vec<_> = said
                .filter(|l| l.contains("skipped:") || l.contains("(empty)"))
                .collect();
            let first = format!("nearmiss: {count} files skipped:");
            assert!(said[0].starts_with(&first), "{}", ended.stderr);
            assert_eq!(said.len(), lines, "{arguments:?}: {}", ended.stderr);
            match lines {
                1 => assert!(said[0].ends_with("in/e02.xml (empty) and 27 more")),
                _ => assert_eq!(said[5], "  in/e04.xml (empty)"),
            }
            assert!(!ended.stderr.contains("pom.xml") && !ended.stdout.is_empty());
        }
    }
    home.write("none/e.xml", "");
    let ended = home.run(&["metrics", "none"]).status(2);
    assert!(
        ended.stderr.contains("no CommonRoad scenario")
            && ended
                .stderr
                .contains("; 1 file skipped: none/e.xml (empty)"),
        "{}",
        ended.stderr
    );
}

/// Links in `/proc` lead to the whole disk, and its files are made up while they are read.
#[cfg(target_os = "linux")]
#[test]
fn files_of_the_kernel_are_not_searched() {
    let begun = std::time::Instant::now();
    for folder in ["/proc", "/proc/self", "/sys/kernel"] {
        let error = find(&[folder.into()]).unwrap_err().to_string();
        assert!(error.contains("the system makes them up"), "{error}");
    }
    let folder = tempdir().unwrap();
    put(folder.path(), "a.xml", ROOT);
    std::os::unix::fs::symlink("/proc/self", folder.path().join("link")).unwrap();
    let (names, passed_over) = both(&folder);
    assert_eq!(names, ["a"]);
    assert!(
        passed_over[0].starts_with("link: not searched"),
        "{passed_over:?}"
    );
    assert!(begun.elapsed() < std::time::Duration::from_secs(5));
}
