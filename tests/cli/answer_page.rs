//! The page of answers in `report -o x.html`: what it holds, and how it works in a real browser.

use std::path::PathBuf;

use nearmiss::formats::bundled;
use nearmiss::store::{Consumed, Ending, NewRun, Origin, Run, RunId, RunState, Store};
use nearmiss::verdict::{ParsedAnswer, Task, Verdict};
use serde_json::json;

use crate::support::browser::Browser;
use crate::support::program::Home;

/// An answer that breaks out of a careless page.
const HOSTILE: &str =
    "</script><img src=x onerror=\"window.broken=1\"><!--<script>window.broken=1</script>";

const MODELS: [&str; 5] = [
    "lab/small",
    "lab/large",
    "lab/fast",
    "other/one",
    "other/two",
];
const TECHNIQUES: [&str; 4] = ["base", "cp", "cp+cot", "cp+cot+icl"];

/// Questions about the bundled scenarios first, then about scenarios that are not at hand.
fn scenarios(count: usize) -> Vec<String> {
    let bundled = bundled().into_iter().map(|entry| entry.name);
    let others = (0..).map(|n| format!("ZAM_Far-{n}_1_T-1"));
    bundled.chain(others).take(count).collect()
}

fn collides(question: usize) -> bool {
    question.is_multiple_of(3)
}

/// An answer of the models to a question about a scenario.
pub fn answer(question: usize, scenario: &str, model: usize, techniques: usize) -> Run {
    let number = (question * MODELS.len() + model) * TECHNIQUES.len() + techniques;
    let right = (number * 7919) % 10 < 8;
    let dangerous = collides(question) == right;
    let said = ParsedAnswer::Verdict(Verdict {
        task: Task::Collision,
        dangerous,
        obstacles: Vec::new(),
        justification: "The gap shrinks.".into(),
        critical: None,
        probability: None,
        token_probability: None,
        unknown: Vec::new(),
    });
    let lost = number % 97 == 5;
    let prompt =
        format!("Scene {scenario}. Obstacle 2 is ahead of the ego; the gap is 12.3 m. ").repeat(40);
    let system = format!("You judge scenes. {} {HOSTILE}", TECHNIQUES[techniques]).repeat(20);
    let question = NewRun {
        sample: 0,
        batch: None,
        scenario: scenario.into(),
        scenario_hash: None,
        ego: "recorded".into(),
        task: Task::Collision,
        frame: "ego".into(),
        techniques: TECHNIQUES[techniques].into(),
        window: Some((0, 9)),
        model: MODELS[model].into(),
        provider: "lab".into(),
        dialect: Some("openai_chat".into()),
        endpoint: "lab".into(),
        address: Some("http://127.0.0.1/v1".into()),
        template: "t.md".into(),
        template_version: Some("1".into()),
        template_hash: "0".repeat(64),
        messages: json!([
            { "role": "system", "content": system },
            { "role": "user", "content": prompt },
        ])
        .to_string(),
        parameters: "{}".into(),
        answer_schema: None,
        images: Vec::new(),
    };
    let words = "The gap shrinks step by step, and the ego does not brake. ".repeat(12);
    Run {
        id: RunId(0),
        created_ms: 1_700_000_000_000 + number as i64,
        updated_ms: 1_700_000_000_000 + number as i64,
        key: question.key(),
        origin: Origin::Recorded,
        source: None,
        question,
        answer: format!(
            "Answer {number} {HOSTILE}. {words}Obstacle 301 has a distance of 500.0 m.\n{}",
            json!({ "collision": dangerous, "obstacles": [], "justification": "The gap shrinks." })
        ),
        reasoning: String::new(),
        verdict_json: (!lost).then(|| serde_json::to_string(&said).unwrap()),
        ending: Ending {
            verdict: (!lost).then_some(said),
            model_returned: Some("small-2024".into()),
            consumed: Consumed {
                duration_ms: Some(1200),
                input_tokens: Some(900),
                output_tokens: Some(120),
                ..Consumed::default()
            },
            ..Ending::bare(RunState::Answered)
        },
        tool_rounds: None,
        most_usd: None,
        notes: String::new(),
        pinned: false,
        deleted_ms: None,
    }
}

/// A store with `questions` × 20 answers, and their truth in `truth.csv`.
pub fn filled(home: &Home, questions: usize) -> usize {
    let store = Store::open(&home.data().join("runs.sqlite")).unwrap();
    let names = scenarios(questions);
    let mut runs = Vec::new();
    let mut truth = String::from("scenario,label\n");
    for (question, name) in names.iter().enumerate() {
        truth += &format!("{name},{}\n", u8::from(collides(question)));
        for model in 0..MODELS.len() {
            runs.extend((0..TECHNIQUES.len()).map(|t| answer(question, name, model, t)));
        }
    }
    assert_eq!(store.add(&runs).unwrap(), runs.len());
    home.write("truth.csv", truth);
    runs.len()
}

/// A report of them as a page.
fn page(home: &Home, questions: usize) -> PathBuf {
    let answers = filled(home, questions);
    let begun = std::time::Instant::now();
    home.run(&["report", "--truth", "truth.csv", "-o", "page.html"])
        .status(0);
    let file = home.files().join("page.html");
    let bytes = std::fs::metadata(&file).unwrap().len();
    println!("{answers} answers: {bytes} bytes in {:?}", begun.elapsed());
    file
}

#[test]
fn a_page_holds_texts_once_and_nothing_that_runs() {
    let home = Home::new();
    let file = page(&home, 12);
    let html = std::fs::read_to_string(&file).unwrap();
    assert!(!html.contains("<img"), "an answer became markup");
    let own = html.matches("<script>").count();
    assert_eq!(own, 1, "only the page's own script runs");
    assert_eq!(
        html.matches("</script>").count(),
        html.matches("<script").count()
    );
    assert!(html.contains("default-src 'none'") && html.contains("script-src 'sha256-"));
    // A prompt of a scenario is the same for all models and techniques; each has a system message of its own.
    assert_eq!(html.matches("Scene ZAM_CutIn-1_1_T-1. ").count(), 40);
    // The maps of the bundled scenarios, one each.
    assert_eq!(
        html.matches("<script type=\"application/json\" id=\"data-picture-")
            .count(),
        8
    );
    for outside in [
        "src=\"http",
        "href=\"http",
        "@import",
        "url(http",
        "url('",
        "url(\\\"",
    ] {
        assert!(!html.contains(outside), "{outside}");
    }
    // The same answers give the same page.
    home.run(&["report", "--truth", "truth.csv", "-o", "again.html"])
        .status(0);
    assert_eq!(
        std::fs::read_to_string(home.files().join("again.html")).unwrap(),
        html
    );
}

#[test]
fn a_browser_reads_wrong_answers_in_two_clicks_and_by_keys() {
    let Some(mut browser) = Browser::start(1400, 900) else {
        return;
    };
    let home = Home::new();
    let file = page(&home, 12);
    browser.open(&file, "");
    // One click filters, the second opens: verdict, answer, claims, prompt and picture are there.
    let text = |selector: &str| {
        format!(
            "document.querySelector({})?.textContent ?? ''",
            json!(selector)
        )
    };
    assert!(
        browser
            .value(&text("#answers .status"))
            .as_str()
            .unwrap()
            .starts_with("240 of 240 answers, 12 of 12 questions")
    );
    browser.key("w");
    assert_eq!(browser.value("[...document.querySelectorAll('.cell:not(.faint) b')].every((b) => b.textContent === 'W')"), true);
    browser.click(".cell.W:not(.faint)");
    let panel = browser.value(&text("#panel"));
    let panel = panel.as_str().unwrap();
    for words in [
        "W Wrong: says",
        "Answer",
        "Claims: 0 right, 1 wrong",
        "system ·",
        "user ·",
        HOSTILE,
        "model returned small-2024, asked for",
    ] {
        assert!(panel.contains(words), "{words}: {panel}");
    }
    let loaded = "(async () => { const i = document.querySelector('#picture'); await i.decode(); return i.naturalWidth > 100; })()";
    assert_eq!(browser.value(loaded), true);
    assert_eq!(
        browser.value("window.broken === undefined && !document.querySelector('#panel [onerror]')"),
        true
    );
    browser.click("#panel details.prompt summary");
    assert_eq!(browser.value("(async () => { const of = () => document.querySelector('#panel details.prompt pre'); while (!of()) await new Promise((r) => setTimeout(r, 20)); return of().textContent.startsWith('You judge scenes.'); })()"), true);
    // The claim leads to its place in the text.
    browser.click("#claims button");
    assert_eq!(browser.value(&text("mark.at")), "500.0 m");
    // Keys: the open answer follows; escape closes it, then clears the filter.
    browser.key("Escape");
    assert_eq!(
        browser.value("document.querySelector('#panel').hidden"),
        true
    );
    browser.key("Escape");
    assert!(
        browser
            .value(&text("#answers .status"))
            .as_str()
            .unwrap()
            .starts_with("240 of 240")
    );
    browser.key("ArrowDown");
    browser.key("Enter");
    let name = scenarios(2)[1].clone();
    let heading = text("#panel h2");
    assert_eq!(browser.value(&heading), name.as_str());
    let first = browser.value(&text("#text"));
    browser.key("ArrowRight");
    assert_ne!(browser.value(&text("#text")), first);
    browser.key("n");
    assert!(
        browser
            .value(&text("#badge"))
            .as_str()
            .unwrap()
            .starts_with("W Wrong")
    );
    browser.key("?");
    assert_eq!(browser.value("document.querySelector('#keys').open"), true);
    browser.key("Escape");
    browser.key("Escape");
    // The filter finds words of answers, and names.
    browser.key("/");
    browser.call("Input.insertText", json!({ "text": "answer 17 <" }));
    browser.value("(async () => { while (document.body.dataset.searched !== 'answer 17 <') await new Promise((r) => setTimeout(r, 20)); })()");
    assert!(
        browser
            .value(&text("#answers .status"))
            .as_str()
            .unwrap()
            .starts_with("1 of 240 answers")
    );
    // The address names the answer, and opens it.
    let fragment = browser.value("(() => { document.querySelector('.cell:not(.faint):not(.empty)').click(); return new Promise((r) => setTimeout(() => r(location.hash), 500)); })()");
    let shown = browser.value(&text("#text"));
    browser.open(&home.write("other.html", "<title>other</title>"), "");
    browser.open(&file, fragment.as_str().unwrap());
    assert_eq!(browser.value(&text("#text")), shown);
    browser.click("[data-tab=tables]");
    assert_eq!(
        browser.value("document.querySelector('main').hidden"),
        false
    );
    let complaints = browser.complaints(&file);
    let complaints: Vec<_> = complaints
        .iter()
        .filter(|c| !c.to_string().contains("other.html"))
        .collect();
    assert!(complaints.is_empty(), "{complaints:#?}");
}

/// 10,000 answers; the times are printed, and read by people.
#[test]
fn ten_thousand_answers_are_read_without_a_request() {
    let Some(mut browser) = Browser::start(1400, 900) else {
        return;
    };
    let home = Home::new();
    let file = page(&home, 500);
    browser.open(&file, "");
    let status = browser.value("document.querySelector('#answers .status').textContent");
    assert!(
        status
            .as_str()
            .unwrap()
            .starts_with("10,000 of 10,000 answers"),
        "{status}"
    );
    let nodes = browser.value("document.querySelectorAll('#answers *').length");
    assert!(
        nodes.as_u64().unwrap() < 4000,
        "{nodes} elements: only the lines that are seen exist"
    );
    let load = browser.value("performance.getEntriesByType('navigation')[0].duration");
    let scroll = browser.value(
        "(async () => { const g = document.querySelector('#grid'); let worst = 0, sum = 0;
           for (let i = 1; i <= 100; i++) { const from = performance.now(); g.scrollTop = i * 140;
             await new Promise(requestAnimationFrame); await new Promise((r) => setTimeout(r));
             const took = performance.now() - from; worst = Math.max(worst, took); sum += took; }
           return [sum / 100, worst, document.querySelectorAll('.line').length]; })()",
    );
    let filter = browser.value(
        "(async () => { const s = document.querySelector('#by-only'); const from = performance.now(); s.value = 'W';
           s.dispatchEvent(new Event('change')); return performance.now() - from; })()",
    );
    let search = browser.value(
        "(async () => { const w = document.querySelector('#by-words'); const from = performance.now(); w.value = 'answer 7777 <';
           w.dispatchEvent(new Event('input')); while (document.body.dataset.searched !== 'answer 7777 <') await new Promise((r) => setTimeout(r, 5));
           return performance.now() - from; })()",
    );
    let open = browser.value("(() => { const from = performance.now(); document.querySelector('.cell:not(.faint):not(.empty)')?.click(); return performance.now() - from; })()");
    println!(
        "load {load} ms; scroll mean, worst, lines {scroll} ms; filter {filter} ms; search {search} ms; open {open} ms"
    );
    let complaints = browser.complaints(&file);
    assert!(complaints.is_empty(), "{complaints:#?}");
}
