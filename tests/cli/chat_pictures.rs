//! Examples for fine-tuning with pictures: in the documented form, and each that is left out counted with its reason.

use nearmiss::store::{Run, Store, StoredImage};
use serde_json::{Value, json};

use super::chats::{answer, read};
use super::support::program::Home;

const KEPT: &str = "1111111111111111111111111111111111111111111111111111111111111111";
const LOST: &str = "2222222222222222222222222222222222222222222222222222222222222222";
const MOVING: &str = "3333333333333333333333333333333333333333333333333333333333333333";

/// An answer to so many times this picture, shown by one of the roles.
fn seen(n: i64, role: &str, pictures: &[&str]) -> Run {
    let mut run = answer(n);
    let mut messages: Vec<Value> = serde_json::from_str(&run.question.messages).unwrap();
    let image = |sha256: &&str| {
        json!({
            "media_type": "image/png", "sha256": sha256, "width": 2, "height": 1,
        })
    };
    let shown: Vec<Value> = pictures.iter().map(image).collect();
    let message = messages.iter_mut().find(|m| m["role"] == role).unwrap();
    message["images"] = shown.into();
    run.question.messages = json!(messages).to_string();
    run.question.frame = "ego+picture".into();
    run.key = run.question.key();
    run
}

fn filled(home: &Home) {
    let image = |sha256: &str, media_type: &str| StoredImage {
        sha256: sha256.into(),
        media_type: media_type.into(),
        width: 2,
        height: 1,
        bytes: b"abc".to_vec().into(),
    };
    let store = Store::open(&home.data().join("runs.sqlite")).unwrap();
    store.keep_image(&image(KEPT, "image/png")).unwrap();
    store.keep_image(&image(MOVING, "image/gif")).unwrap();
    let runs = [
        answer(1),
        seen(2, "user", &[KEPT]),
        seen(3, "user", &[LOST]),
        seen(4, "user", &[MOVING]),
        seen(5, "user", &[KEPT; 11]),
        seen(6, "system", &[KEPT]),
    ];
    assert_eq!(store.add(&runs).unwrap(), runs.len());
    let labels: String = (1..=6)
        .map(|n| format!("ZAM_Made-{n}_1_T-1,critical,7\n"))
        .collect();
    home.write("truth.csv", format!("scenario,label,obstacle_id\n{labels}"));
}

fn export(home: &Home, folder: &str, more: &[&str]) -> crate::support::program::Ended {
    let all = [
        "runs",
        "export",
        "--format",
        "chat",
        "--truth",
        "truth.csv",
        "--validation",
        "0",
        "-o",
        folder,
    ];
    home.run(&[&all[..], more].concat()).status(0)
}

#[test]
fn a_picture_stands_before_its_words_as_it_was_sent() {
    let home = Home::new();
    filled(&home);
    export(&home, "chats", &[]).says(&[
        "left out 1 answer to pictures that the store does not have",
        "left out 3 answers to pictures that training files cannot have",
        "1 example with a picture",
        "--no-pictures",
    ]);
    let text = read(&home, "chats/train.jsonl");
    let lines: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(lines.len(), 2);
    assert_eq!(lines[0]["messages"][1]["content"], "question 1: \u{202e}ü");
    let wanted = json!([
        {"type": "image_url", "image_url": {"url": "data:image/png;base64,YWJj"}},
        {"type": "text", "text": "question 2: \u{202e}ü"},
    ]);
    assert_eq!(lines[1]["messages"][1]["content"], wanted);
    assert!(lines[1]["messages"][2]["content"].is_string());
    let manifest: Value = serde_json::from_str(&read(&home, "chats/manifest.json")).unwrap();
    assert_eq!(manifest["files"][0]["with_pictures"], 1);
    assert_eq!(
        manifest["left_out"],
        json!({"no_picture": 1, "picture_form": 3})
    );
    let schema = home.run(&["help", "json", "--schema", "runs-export-chat"]);
    let schema: Value = serde_json::from_str(&schema.status(0).stdout).unwrap();
    assert!(
        jsonschema::validator_for(&schema)
            .unwrap()
            .is_valid(&manifest)
    );
}

#[test]
fn pictures_are_left_out_where_only_words_are_wanted() {
    let home = Home::new();
    filled(&home);
    export(&home, "words", &["--no-pictures"]).says(&["left out 5 answers to pictures"]);
    assert_eq!(read(&home, "words/train.jsonl").lines().count(), 1);
    let other = home.run(&["runs", "export", "--no-pictures"]).status(2);
    other.says(&["--no-pictures", "--format chat"]);
}
