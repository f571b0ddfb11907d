//! The pictures that models were sent, on the page of answers: shown as they were, or said to be missing.

use std::path::PathBuf;

use nearmiss::store::{Store, StoredImage};
use serde_json::json;

use super::answer_page::answer;
use crate::support::browser::Browser;
use crate::support::program::Home;

/// Two answers to the same picture, one to a picture that the store lost, and one without any.
fn with_pictures(home: &Home) -> PathBuf {
    let store = Store::open(&home.data().join("runs.sqlite")).unwrap();
    let kept = StoredImage {
        sha256: "1".repeat(64),
        media_type: "image/png".into(),
        width: 2,
        height: 1,
        // Two red pixels.
        bytes: vec![
            137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 2, 0, 0, 0, 1,
            8, 2, 0, 0, 0, 123, 64, 232, 221, 0, 0, 0, 13, 73, 68, 65, 84, 120, 156, 99, 248, 207,
            192, 0, 68, 0, 8, 254, 1, 255, 198, 158, 121, 247, 0, 0, 0, 0, 73, 69, 78, 68, 174, 66,
            96, 130,
        ]
        .into(),
    };
    store.keep_image(&kept).unwrap();
    let of = |model: usize, picture: Option<&str>| {
        let mut run = answer(0, "ZAM_CutIn-1_1_T-1", model, 0);
        if let Some(picture) = picture {
            run.question.frame = "picture".into();
            let image = json!({
                "media_type": "image/png", "sha256": picture, "width": 2, "height": 1,
            });
            let message = json!({
                "role": "user", "content": "The picture shows the scene.", "images": [image],
            });
            run.question.messages = json!([message]).to_string();
            run.key = run.question.key();
        }
        run
    };
    let (here, lost) = (kept.sha256.as_str(), "2".repeat(64));
    let runs = [
        of(0, Some(here)),
        of(1, Some(here)),
        of(2, Some(&lost)),
        of(3, None),
    ];
    assert_eq!(store.add(&runs).unwrap(), runs.len());
    home.write("truth.csv", "scenario,label\nZAM_CutIn-1_1_T-1,1\n");
    home.run(&["report", "--truth", "truth.csv", "-o", "page.html"])
        .status(0);
    home.files().join("page.html")
}

#[test]
fn a_page_holds_the_pictures_that_models_were_sent() {
    let home = Home::new();
    let html = std::fs::read_to_string(with_pictures(&home)).unwrap();
    assert_eq!(html.matches("id=\"data-sent-").count(), 1, "once");
    assert!(
        html.contains("\"data:image/png;base64,iVBORw0KGgo"),
        "as it was sent"
    );
    assert_eq!(html.matches("{\"picture\":0,\"size\":[2,1]}").count(), 2);
    let missing = "The store does not have the picture 222222222222…";
    assert_eq!(html.matches(missing).count(), 1);
    assert_eq!(html.matches("\"sent\":[]").count(), 1);
}

#[test]
fn a_browser_shows_the_picture_that_a_model_was_sent() {
    let Some(mut browser) = Browser::start(1400, 900) else {
        return;
    };
    let home = Home::new();
    let file = with_pictures(&home);
    browser.open(&file, "");
    browser.key("ArrowDown");
    browser.key("ArrowUp");
    browser.key("Enter");
    let sent = "(async () => { const i = document.querySelector('#panel img.sent'); if (!i) return document.querySelector('#panel').textContent; await i.decode(); return [i.naturalWidth, i.alt.includes('ZAM_CutIn-1_1_T-1')]; })()";
    let mut shown = Vec::new();
    for _ in 0..4 {
        shown.push(browser.value(sent));
        browser.key("ArrowRight");
    }
    let seen = shown.iter().filter(|value| **value == json!([2, true]));
    assert_eq!(seen.count(), 2, "{shown:?}");
    let missing = shown
        .iter()
        .filter_map(|value| value.as_str())
        .filter(|text| text.contains("The store does not have the picture"));
    assert_eq!(missing.count(), 1, "{shown:?}");
    let complaints = browser.complaints(&file);
    assert!(complaints.is_empty(), "{complaints:#?}");
}
