//! Answers recorded by others: a folder laid out as the repository of "From Words to Collisions".
//!
//! `Results/output_validation/NAME/scenario/ego_cot/gemini/analysis/ego_analysis_all_timesteps.txt` is the answer of
//! one model about one scenario; `output_validation_normal` holds the safe ones, `agent` the safety inference,
//! `scenario/safety` the choice of attackers, and `context` beside `analysis` the description that was sent.

use std::path::{Path, PathBuf};

use crate::evaluation::labels::{file_name, results_folder, sorted_paths};
use crate::evaluation::{Loss, Problem};
use nearmiss_ask::prompts::Techniques;
use nearmiss_base::system;
use nearmiss_scene::verdict::{NoVerdict, Reading, Task, read};

/// A recorded answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// Name of the scenario.
    pub scenario: String,
    /// Whether its folder is that of the collisions.
    pub collision: bool,
    /// The task.
    pub task: Task,
    /// From where the scene was described: the name of a frame, `cartesian`, `ego` or `metrics`.
    pub frame: &'static str,
    /// The prompting techniques that were used.
    pub techniques: Techniques,
    /// Who answered, as `recorded/NAME`: the model that the paper's scripts ask.
    pub model: String,
    /// The answer as it was written.
    pub text: String,
    /// The file with the answer.
    pub file: PathBuf,
    /// The description that was sent, where it was kept.
    pub context: Option<String>,
}

/// The folders of the two halves of the data, and whether they collide.
const HALVES: [(&str, bool); 2] = [
    ("output_validation", true),
    ("output_validation_normal", false),
];

/// Largest answer or context that is read, bytes.
const LARGEST: u64 = 4_000_000;

impl Recorded {
    /// What the answer says.
    ///
    /// # Errors
    /// It holds no such thing.
    pub fn read(&self) -> Result<Reading, NoVerdict> {
        read(self.task, &self.text)
    }
}

/// Whether there is a folder of recorded answers where [`find`] looks for one.
#[must_use]
pub fn is_laid_out(root: &Path) -> bool {
    let has = |folder: &Path| HALVES.iter().any(|(half, _)| folder.join(half).is_dir());
    has(root) || has(&root.join("Results"))
}

/// Every answer below `root`, in the order of its path, and everything there that is none.
///
/// `root` is the repository, its `Results`, or a folder with `output_validation` or `output_validation_normal`.
#[must_use]
pub fn find(root: &Path) -> (Vec<Recorded>, Vec<Problem>) {
    let mut search = Search::default();
    let folder = results_folder(root);
    let mut halves = 0;
    for (name, collision) in HALVES {
        let half = folder.join(name);
        if half.is_dir() {
            halves += 1;
            for scenario in search.folders(&half) {
                search.scenario(&scenario, collision);
            }
        }
    }
    if halves == 0 {
        search.complain(
            root,
            "no recorded answers; expected `Results/output_validation` or `Results/output_validation_normal`",
        );
    }
    (search.found, search.problems)
}

/// Results so far.
#[derive(Default)]
struct Search {
    found: Vec<Recorded>,
    problems: Vec<Problem>,
}

impl Search {
    fn complain(&mut self, path: &Path, message: impl Into<String>) {
        self.add(path, message, Loss::Unread);
    }

    fn note(&mut self, path: &Path, message: impl Into<String>) {
        self.add(path, message, Loss::Nothing);
    }

    fn absent(&mut self, path: &Path, message: impl Into<String>) {
        self.add(path, message, Loss::Absent);
    }

    fn add(&mut self, path: &Path, message: impl Into<String>, loss: Loss) {
        self.problems.push(Problem {
            path: path.to_path_buf(),
            message: message.into(),
            loss,
        });
    }

    /// What is in a folder, in order; nothing, and a problem, if it cannot be read.
    fn inside(&mut self, folder: &Path) -> Vec<PathBuf> {
        sorted_paths(folder).unwrap_or_else(|problem| {
            self.problems.push(problem);
            Vec::new()
        })
    }

    fn folders(&mut self, folder: &Path) -> Vec<PathBuf> {
        let mut paths = self.inside(folder);
        paths.retain(|path| path.is_dir());
        paths
    }

    fn scenario(&mut self, folder: &Path, collision: bool) {
        for (name, task) in [("agent", Task::Safety), ("scenario", Task::Collision)] {
            let tasks = folder.join(name);
            if !tasks.is_dir() {
                self.absent(&tasks, "missing: no answers to this task");
                continue;
            }
            for method in self.folders(&tasks) {
                let Some(asked) = FolderQuestion::from_name(task, &file_name(&method)) else {
                    let known =
                        "cart or ego, and base, ablation, cot or icl, as in ego_cot; or safety";
                    self.complain(
                        &method,
                        format!("unknown prompt configuration, skipped; available: {known}"),
                    );
                    continue;
                };
                for engine in self.folders(&method) {
                    self.answer(folder, &engine, asked, collision);
                }
            }
        }
    }

    /// The answers in the folder of a model: one, unless there are files of other names.
    fn answer(&mut self, scenario: &Path, engine: &Path, asked: FolderQuestion, collision: bool) {
        let analysis = engine.join("analysis");
        if !analysis.is_dir() {
            return self.absent(&analysis, "missing: no answer");
        }
        let mut files = self.inside(&analysis);
        files.retain(|path| path.is_file());
        let usual = |path: &PathBuf| file_name(path).ends_with("_all_timesteps.txt");
        let usual = files.iter().find(|p| usual(p)).cloned();
        let text = |path: &PathBuf| path.extension().is_some_and(|x| x == "txt");
        let chosen = usual.or_else(|| files.iter().find(|p| text(p)).cloned());
        let Some(file) = chosen else {
            return self.absent(&analysis, "no *.txt: no answer");
        };
        for other in files.iter().filter(|other| **other != file) {
            let message = format!("skipped; {} is the answer", file_name(&file));
            self.note(other, message);
        }
        if !file_name(&file).ends_with("_all_timesteps.txt") {
            self.note(&file, "not named …_all_timesteps.txt; taken as the answer");
        }
        let Some(text) = self.text(&file) else {
            return;
        };
        if text.trim().is_empty() {
            self.note(&file, "empty; the answer is kept");
        }
        let Some(model) = self.model(engine) else {
            return;
        };
        let contexts = engine.join("context");
        let mut context = None;
        if contexts.is_dir() {
            let files = self.inside(&contexts);
            let file = files
                .iter()
                .find(|path| path.extension().is_some_and(|x| x == "txt"));
            context = file.and_then(|file| self.text(file));
        }
        self.found.push(Recorded {
            scenario: file_name(scenario),
            collision,
            task: asked.task,
            frame: asked.frame,
            techniques: asked.techniques,
            model,
            text,
            file,
            context,
        });
    }

    /// The model behind the name of a folder, as the paper's scripts ask for it.
    fn model(&mut self, engine: &Path) -> Option<String> {
        let name = file_name(engine);
        let model = match name.as_str() {
            "gemini" => "gemini-1.5-pro",
            "openai" => "gpt-4o",
            "deepseek" => "deepseek-chat",
            other => {
                self.note(engine, "not a model of the paper; its folder name is used");
                other
            }
        };
        Some(format!("recorded/{model}"))
    }

    /// The text of a file; what is not UTF-8 in it is replaced, and said.
    fn text(&mut self, file: &Path) -> Option<String> {
        match std::fs::metadata(file) {
            Ok(data) if data.len() > LARGEST => {
                self.complain(
                    file,
                    format!("has {} bytes, too large for an answer; skipped", data.len()),
                );
                return None;
            }
            _ => {}
        }
        match system::read_file(file, system::LARGEST) {
            Ok(bytes) => Some(match String::from_utf8(bytes) {
                Ok(text) => text,
                Err(error) => {
                    self.complain(file, "not UTF-8; unreadable characters were replaced");
                    String::from_utf8_lossy(error.as_bytes()).into_owned()
                }
            }),
            Err(error) => {
                self.complain(
                    file,
                    format!("cannot be read: {}", system::error_text(&error)),
                );
                None
            }
        }
    }
}

/// The question that a folder's name denotes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct FolderQuestion {
    task: Task,
    frame: &'static str,
    techniques: Techniques,
}

impl FolderQuestion {
    /// From the task and a name such as `cart_icl`: as the paper's ablation study has it, CoT includes CP, and ICL
    /// both.
    fn from_name(task: Task, method: &str) -> Option<Self> {
        if method == "safety" && task == Task::Collision {
            return Some(Self {
                task: Task::Attacker,
                frame: "metrics",
                techniques: Techniques::ALL,
            });
        }
        let (frame, technique) = method.split_once('_')?;
        let frame = match frame {
            "cart" => "cartesian",
            "ego" => "ego",
            _ => return None,
        };
        let (cp, cot, icl) = match technique {
            "base" => (false, false, false),
            "ablation" | "cp" => (true, false, false),
            "cot" => (true, true, false),
            "icl" => (true, true, true),
            _ => return None,
        };
        let techniques = Techniques { cp, cot, icl };
        Some(Self {
            task,
            frame,
            techniques,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::evaluation::Loss;

    const ANSWER: &str = r#"{"collision": true, "obstacles": [{"id": 7, "risk_score": 0, "reason": "r"}], "justification": "j"}"#;

    fn put(root: &Path, path: &str, bytes: impl AsRef<[u8]>) {
        let path = root.join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }

    #[test]
    fn everything_is_found_or_named() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let a = "Results/output_validation/ZAM_A-1";
        let b = "Results/output_validation_normal/ZAM_B-1";
        put(
            root,
            &format!("{a}/scenario/ego_cot/gemini/analysis/ego_analysis_all_timesteps.txt"),
            ANSWER,
        );
        put(
            root,
            &format!("{a}/scenario/ego_cot/gemini/context/context_all_timesteps.txt"),
            "what was sent",
        );
        put(
            root,
            &format!("{a}/scenario/safety/gemini/analysis/safety_analysis_all_timesteps.txt"),
            ANSWER,
        );
        put(
            root,
            &format!("{a}/scenario/cart_base/openai/analysis/answer.txt"),
            b"\xff{}",
        );
        put(
            root,
            &format!("{a}/scenario/cart_tree/openai/analysis/x_all_timesteps.txt"),
            ANSWER,
        );
        put(
            root,
            &format!("{a}/scenario/cart_icl/openai/other/x.txt"),
            ANSWER,
        );
        put(
            root,
            &format!("{b}/agent/ego_icl/deepseek/analysis/ego_analysis_all_timesteps.txt"),
            "",
        );
        put(
            root,
            &format!("{b}/agent/ego_icl/deepseek/analysis/notes.md"),
            "",
        );
        put(
            root,
            &format!("{b}/agent/cart_ablation/llama/analysis/cart_analysis_all_timesteps.txt"),
            ANSWER,
        );
        let (found, problems) = find(root);
        let short: Vec<_> = found
            .iter()
            .map(|r| {
                (
                    r.scenario.as_str(),
                    r.collision,
                    r.task,
                    r.frame,
                    r.techniques.to_string(),
                    r.model.as_str(),
                )
            })
            .collect();
        let text = |s: &str| s.to_string();
        assert_eq!(
            short,
            [
                (
                    "ZAM_A-1",
                    true,
                    Task::Collision,
                    "cartesian",
                    text("base"),
                    "recorded/gpt-4o"
                ),
                (
                    "ZAM_A-1",
                    true,
                    Task::Collision,
                    "ego",
                    text("cp+cot"),
                    "recorded/gemini-1.5-pro"
                ),
                (
                    "ZAM_A-1",
                    true,
                    Task::Attacker,
                    "metrics",
                    text("cp+cot+icl"),
                    "recorded/gemini-1.5-pro"
                ),
                (
                    "ZAM_B-1",
                    false,
                    Task::Safety,
                    "cartesian",
                    text("cp"),
                    "recorded/llama"
                ),
                (
                    "ZAM_B-1",
                    false,
                    Task::Safety,
                    "ego",
                    text("cp+cot+icl"),
                    "recorded/deepseek-chat"
                ),
            ]
        );
        assert_eq!(found[1].context.as_deref(), Some("what was sent"));
        assert_eq!(found[0].text, "\u{fffd}{}");
        let read = found[1].read().unwrap();
        assert!(
            read.said
                .verdict()
                .is_some_and(|v| v.danger().contains(&7) && !v.danger().contains(&8))
        );
        let count = |loss| problems.iter().filter(|p| p.loss == loss).count();
        let losses = [Loss::Absent, Loss::Nothing, Loss::Unread].map(count);
        assert_eq!(losses, [3, 4, 2], "{problems:#?}");
        let mut words: Vec<String> = problems
            .iter()
            .map(|p| format!("{}: {}", file_name(&p.path), p.message))
            .collect();
        words.sort();
        let wanted = [
            "agent: missing",
            "analysis: missing",
            "answer.txt: not UTF-8",
            "answer.txt: not named",
            "cart_tree: unknown prompt configuration",
            "ego_analysis_all_timesteps.txt: empty",
            "llama: not a model of the paper",
            "notes.md: skipped",
            "scenario: missing",
        ];
        assert_eq!(words.len(), wanted.len(), "{words:#?}");
        for (word, wanted) in words.iter().zip(wanted) {
            assert!(word.starts_with(wanted), "{word} | {wanted}");
        }
    }

    #[test]
    fn a_folder_without_answers_says_so() {
        let folder = tempfile::tempdir().unwrap();
        let (found, problems) = find(folder.path());
        assert!(found.is_empty() && problems.len() == 1);
        assert!(
            problems[0].to_string().contains("output_validation"),
            "{}",
            problems[0]
        );
    }
}
