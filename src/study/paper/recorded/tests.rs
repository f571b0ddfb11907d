//! Tests on a small folder in the layout of the paper's repository, with every possible defect.
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
