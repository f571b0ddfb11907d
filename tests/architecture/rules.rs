//! Who may import whom: the arrows the design allows, and nothing else.

use std::path::{Path, PathBuf};

use super::source::{self, Source, Target};

/// Modules that share a crate, and what each may import of it; a module that is not here fails. What crates see of each
/// other the compiler holds.
fn may_import(module: &str) -> Option<&'static [&'static str]> {
    Some(match module {
        "geometry" | "system" | "scenario" | "verdict" | "planner" | "prompts" | "llm"
        | "tools" => &[],
        "metrics" | "traffic_rules" => &["scenario"],
        "description" | "story" => &["metrics", "scenario"],
        "corpus" => &["metrics", "scenario", "story"],
        "judge" => &["metrics", "scenario", "verdict"],
        "driver" => &[],
        "simulation" => &["driver", "planner"],
        "generation" => &["driver", "simulation", "planner"],
        "evaluation" => &["tools"],
        "paper" => &["evaluation"],
        _ => return None,
    })
}

/// Crates of several modules, and the program, which brings the two faces together.
const SHARED: [&str; 5] = ["base", "scene", "drive", "ask", "study"];

/// What the program itself may import.
const FACES: [&str; 2] = ["cli", "tui"];

/// Outside crates with one home: the beginning of the crate's name, and the files that may use it.
const HOMES: [(&str, &[&str]); 32] = [
    ("ratatui", &["tui/", "render/cells/"]),
    ("crossterm", &["tui/terminal.rs", "tui/keymap/"]),
    ("reqwest", &["ask/llm/"]),
    ("hyper", &["cli/mcp/"]),
    ("http_body_util", &["cli/mcp/"]),
    ("getrandom", &["cli/mcp/http.rs"]),
    ("rmcp", &["cli/mcp/"]),
    ("quick_xml", &["formats/commonroad/"]),
    (
        "encoding_rs",
        &["formats/commonroad/encoding.rs", "ask/llm/body_text.rs"],
    ),
    (
        "prost",
        &[
            "formats/commonroad/protobuf/",
            "formats/recordings/waymo/",
            "formats/recordings/osi/",
        ],
    ),
    ("rusqlite", &["store/", "formats/recordings/nuplan/"]),
    ("minijinja", &["ask/prompts/"]),
    ("parry", &["base/geometry/"]),
    ("rstar", &["base/geometry/", "scene/scenario/road/"]),
    ("i_overlay", &["base/geometry/"]),
    ("petgraph", &["scene/scenario/road/"]),
    ("shell_words", &["drive/simulation/external/"]),
    ("tar", &["workflow/bundle/", "release/"]),
    // Bundles, answers that a server packs unasked, images for kitty, tables of tracks, and releases.
    (
        "flate2",
        &[
            "workflow/bundle/",
            "ask/llm/body_text.rs",
            "tui/pixels/kitty.rs",
            "formats/recordings/tracks/",
            "release/",
        ],
    ),
    (
        "zstd",
        &["formats/recordings/tracks/", "formats/recordings/osi/"],
    ),
    (
        "arrow_array",
        &[
            "record/arrow.rs",
            "formats/recordings/py123d.rs",
            "formats/recordings/tracks/arrow.rs",
            "python/table.rs",
        ],
    ),
    (
        "arrow_cast",
        &["formats/recordings/tracks/arrow.rs", "python/table.rs"],
    ),
    (
        "arrow_ipc",
        &[
            "record/writer.rs",
            "formats/recordings/py123d.rs",
            "formats/recordings/tracks/arrow.rs",
            "python/table.rs",
        ],
    ),
    (
        "arrow_schema",
        &[
            "record/",
            "formats/recordings/tracks/arrow.rs",
            "python/table.rs",
        ],
    ),
    ("statrs", &["study/evaluation/statistics/"]),
    ("pyo3", &["python/"]),
    (
        "parquet",
        &[
            "record/",
            "scene/corpus/parts.rs",
            "formats/recordings/argoverse/",
            "formats/recordings/tracks/arrow.rs",
        ],
    ),
    ("indicatif", &["cli/"]),
    ("tiny_skia", &["render/"]),
    ("png", &["render/"]),
    ("gif", &["render/"]),
    ("noto_sans_mono_bitmap", &["render/glyphs.rs"]),
];

/// What the parts of the terminal may import of each other; parts that are not here are free.
/// Views read the tables of actions and keys because footer, help and palette are made from them. Features and `update`
/// see services because a request says what its work is; only the loop has any, so `update` does none of it.
const TUI_ALLOWED: [(&str, &[&str]); 5] = [
    (
        "views",
        &[
            "model", "loaded", "theme", "widgets", "views", "features", "layout", "action",
            "keymap", "clock", "pixels",
        ],
    ),
    (
        "features",
        &[
            "model", "loaded", "theme", "widgets", "features", "action", "message", "keymap",
            "clock", "layout", "pixels", "request", "services", "session", "update",
        ],
    ),
    (
        "update",
        &[
            "model", "action", "message", "keymap", "update", "features", "clock", "loaded",
            "session", "request", "services",
        ],
    ),
    (
        "services",
        &["loaded", "message", "model", "request", "services"],
    ),
    // A session is restored by opening scenarios and moving the clock, as keys do.
    (
        "session",
        &[
            "model", "action", "message", "update", "features", "request", "services",
        ],
    ),
];

/// What no other part of the terminal may import: the root module and the loop put the parts together.
const TUI_ENDS: [&str; 6] = ["views", "features", "update", "services", "terminal", "run"];

/// What other parts import of them all the same: the model holds the state of features and the screens that are open,
/// an effect may be a step of a screen, and a request is given its services.
const TUI_EXCEPTIONS: [(&str, &str); 3] = [
    ("model", "features"),
    ("message", "features"),
    ("request", "services"),
];

/// Windows that stand alone: of features they see what all screens have in common, and no other one.
const WINDOWS: [&str; 8] = [
    "about", "details", "help", "models", "palette", "pictures", "source", "themes",
];

/// What screens have in common.
const SCREENS_SHARE: [&str; 6] = ["Screen", "Step", "PAGE", "WHEEL", "moves_scene", "picker"];

/// Files of a feature that only show or hold what it has, and what they must not import: they ask for nothing.
const PASSIVE: [&str; 2] = ["draw", "state"];
const ASKING: [&str; 4] = ["update", "services", "request", "message"];

/// The loop, the workbench without a terminal, and what commands ask of it: like the root module, they put the parts
/// together.
const TUI_LOOPS: [&str; 4] = ["run", "screenshot", "shell", "headless"];

/// How a program writes to a terminal.
const WRITING: [&str; 8] = [
    "stdout",
    "stderr",
    "print!",
    "println!",
    "eprint!",
    "eprintln!",
    "execute!",
    "queue!",
];

/// Everything that is wrong with one file, a line each.
pub fn complaints(path: &Path, source: &Source) -> Vec<String> {
    let file = path.to_string_lossy().replace('\\', "/");
    let module = source::module_of(path);
    let mut found = Vec::new();
    for named in &source.named {
        let why = match &named.target {
            Target::Inside(target) => inside(&module, target),
            Target::Outside(target) => outside(&file, target),
        };
        found.extend(why.map(|why| format!("src/{file}:{}: {why}", named.line)));
    }
    if file.starts_with("tui/") && file != "tui/terminal.rs" {
        for (line, word) in &source.words {
            if WRITING.contains(&word.as_str()) {
                found.push(format!(
                    "src/{file}:{line}: `{word}`, but only tui/terminal.rs writes to the terminal"
                ));
            }
        }
    }
    found
}

fn inside(from: &[String], to: &[String]) -> Option<String> {
    let own = from.first()?;
    if own == "main" {
        let wanted = to.first()?.as_str();
        return (!FACES.contains(&wanted))
            .then(|| format!("the program must not import `{wanted}`"));
    }
    if SHARED.contains(&own.as_str()) {
        let (part, wanted) = (from.get(1)?, to.get(1)?.as_str());
        let Some(allowed) = may_import(part) else {
            return Some(format!("module `{part}` is in no rule of the design"));
        };
        return (part != wanted && !allowed.contains(&wanted))
            .then(|| format!("`{part}` must not import `{}`", to.join("::")));
    }
    if own != "tui" {
        return None;
    }
    let part = from.get(1)?.as_str();
    let Some(wanted) = to.get(1).map(String::as_str) else {
        return Some("name the part of the terminal that is meant, not `tui` itself".into());
    };
    if part == "features" && wanted == "features" && !is_of_window(from, to) {
        return Some(format!("a window must not import `{}`", to.join("::")));
    }
    let file = from.get(3).map_or("", String::as_str);
    if part == "features" && PASSIVE.contains(&file) && ASKING.contains(&wanted) {
        return Some(format!(
            "`{file}` of a feature must not import `{}`",
            to.join("::")
        ));
    }
    if part == wanted || TUI_LOOPS.contains(&part) {
        return None;
    }
    let allowed = TUI_ALLOWED.iter().find(|(name, _)| *name == part);
    let fine = match allowed {
        Some((_, allowed)) => allowed.contains(&wanted),
        None => !TUI_ENDS.contains(&wanted) || TUI_EXCEPTIONS.contains(&(part, wanted)),
    };
    (!fine).then(|| format!("`tui::{part}` must not import `{}`", to.join("::")))
}

/// Whether what a window imports of the features is its own, or shared; others bring them together.
fn is_of_window(from: &[String], to: &[String]) -> bool {
    let (Some(own), Some(other)) = (from.get(2), to.get(2)) else {
        return true;
    };
    !WINDOWS.contains(&own.as_str()) || own == other || SCREENS_SHARE.contains(&other.as_str())
}

fn outside(file: &str, path: &[String]) -> Option<String> {
    let mut name = path.first()?.as_str();
    // The same crate under another roof.
    if name == "ratatui" && path.get(1).is_some_and(|s| s == "crossterm") {
        name = "crossterm";
    }
    let (start, homes) = HOMES.iter().find(|(start, _)| name.starts_with(start))?;
    let at_home = homes
        .iter()
        .any(|home| file == *home || home.ends_with('/') && file.starts_with(home));
    (!at_home).then(|| {
        format!(
            "`{name}`, but {start} is used in {} only",
            homes.join(" and ")
        )
    })
}

/// Every source file below `folder`, relative to it, with its text.
pub fn files(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|x| x == "rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                found.push((path.strip_prefix(folder).unwrap().to_path_buf(), text));
            }
        }
    }
    found.sort();
    found
}

/// Everything that is wrong with a set of files.
pub fn check(files: &[(PathBuf, String)]) -> Vec<String> {
    let sources: Vec<_> = files
        .iter()
        .map(|(path, text)| (path, source::read(path, text)))
        .collect();
    let for_tests: Vec<_> = sources
        .iter()
        .flat_map(|(_, s)| s.test_files.clone())
        .collect();
    sources
        .iter()
        .filter(|(path, _)| {
            // What lies below a module for tests is for tests too.
            let below = |test: &std::path::PathBuf| {
                test.ends_with("mod.rs")
                    && test.parent().is_some_and(|folder| path.starts_with(folder))
            };
            !for_tests.contains(*path) && !for_tests.iter().any(below)
        })
        .flat_map(|(path, source)| complaints(path, source))
        .collect()
}
