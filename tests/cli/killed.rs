//! Programs that are killed at any moment, and started again until every answer is there.

use std::collections::{BTreeMap, VecDeque};
use std::process::Child;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::CUT_IN;
use super::remote::delta;
use super::support::program::Home;
use super::support::server::{Script, Server};

const ANSWERS: usize = 200;
const WORKERS: usize = 6;
const KILLS: usize = 60;
const SEED: u64 = 0x9e37_79b9_7f4a_7c15;

/// What the server says to its n-th request: no two answers are the same.
fn text(n: usize) -> String {
    let words =
        json!({"collision": false, "obstacles": [], "justification": format!("answer {n}.")});
    format!("Step by step: the gap grows, no vehicle brakes. So:\n{words}\n")
}

fn script(n: usize) -> Script {
    let text = text(n);
    let characters: Vec<char> = text.chars().collect();
    let pieces = characters
        .chunks(14)
        .map(|c| delta(&c.iter().collect::<String>()));
    let begun = Script::chunked_events();
    let said = pieces.fold(begun, |script, piece| {
        script.chunk(piece).pause(Duration::from_millis(8))
    });
    said.chunk("data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\n")
        .chunk("data: [DONE]\n\n")
        .end_of_chunks()
}

/// Random numbers of Marsaglia's xorshift, the same in every run.
struct Chance(u64);

impl Chance {
    fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % end
    }
}

/// What the workers and the killer share.
struct Shared {
    waiting: Mutex<VecDeque<usize>>,
    running: [Mutex<Option<Child>>; WORKERS],
    /// Sample to what its program printed.
    done: Mutex<BTreeMap<usize, Value>>,
    killed: AtomicUsize,
    over: AtomicBool,
}

fn ask(home: &Home, url: &str, sample: usize) -> Child {
    let sample = sample.to_string();
    let arguments = [
        "ask",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--base-url",
        url,
        "--format=json",
        "--sample",
    ];
    home.start(&[&arguments[..], &[&sample]].concat())
}

/// Asks one sample after the other; those whose program was killed wait for their turn again.
fn work(home: &Home, url: &str, shared: &Shared, place: usize) {
    while !shared.over.load(Ordering::Relaxed) {
        let next = shared.waiting.lock().unwrap().pop_front();
        let Some(sample) = next else {
            std::thread::sleep(Duration::from_millis(10));
            continue;
        };
        *shared.running[place].lock().unwrap() = Some(ask(home, url, sample));
        let status = loop {
            let mut slot = shared.running[place].lock().unwrap();
            let ended = slot.as_mut().unwrap().try_wait().unwrap();
            drop(slot);
            match ended {
                Some(status) => break status,
                None => std::thread::sleep(Duration::from_millis(3)),
            }
        };
        let child = shared.running[place].lock().unwrap().take().unwrap();
        let output = child.wait_with_output().unwrap();
        if status.code().is_none() {
            shared.killed.fetch_add(1, Ordering::Relaxed);
            shared.waiting.lock().unwrap().push_back(sample);
            continue;
        }
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(status.success(), "{sample}: {words}");
        let document = serde_json::from_slice(&output.stdout).unwrap();
        let mut done = shared.done.lock().unwrap();
        done.insert(sample, document);
        shared.over.store(done.len() == ANSWERS, Ordering::Relaxed);
    }
}

/// Kills at random moments, one program or all, and looks at what is stored meanwhile.
fn kill(home: &Home, shared: &Shared) -> BTreeMap<String, String> {
    let mut chance = Chance(SEED);
    let mut seen = BTreeMap::new();
    let begun = Instant::now();
    while !shared.over.load(Ordering::Relaxed) {
        assert!(
            begun.elapsed() < Duration::from_secs(240),
            "this does not end"
        );
        std::thread::sleep(Duration::from_millis(20 + chance.below(200)));
        if shared.killed.load(Ordering::Relaxed) < KILLS {
            let all = chance.below(6) == 0;
            let one = chance.below(WORKERS as u64) as usize;
            for (place, slot) in shared.running.iter().enumerate() {
                if let (true, Some(child)) = (all || place == one, slot.lock().unwrap().as_mut()) {
                    child.kill().unwrap();
                }
            }
        }
        seen.extend(answered(home));
    }
    seen
}

/// Whole answers in the store, by the number of their run.
fn answered(home: &Home) -> BTreeMap<String, String> {
    let rows = home.rows("SELECT id, answer FROM runs WHERE state = 'answered'");
    rows.into_iter()
        .map(|mut row| {
            let mut take = |name: &str| row.remove(name).flatten().unwrap();
            (take("id"), take("answer"))
        })
        .collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn no_stored_answer_is_lost_or_asked_for_twice() {
    let home = Home::new();
    let scripts = (0..ANSWERS + 6 * KILLS).map(script).collect();
    let server = Server::start(scripts).await;
    let url = server.base_url();
    let shared = Shared {
        waiting: Mutex::new((0..ANSWERS).collect()),
        running: std::array::from_fn(|_| Mutex::new(None)),
        done: Mutex::default(),
        killed: AtomicUsize::new(0),
        over: AtomicBool::new(false),
    };
    let seen = tokio::task::block_in_place(|| {
        std::thread::scope(|scope| {
            let (home, shared) = (&home, &shared);
            for place in 0..WORKERS {
                scope.spawn(move || work(home, url, shared, place));
            }
            scope.spawn(move || kill(home, shared)).join().unwrap()
        })
    });
    let killed = shared.killed.load(Ordering::Relaxed);
    assert!(killed >= KILLS / 2, "only {killed} were killed");

    let kept = answered(&home);
    for (id, answer) in seen {
        assert_eq!(kept.get(&id), Some(&answer), "run {id} was there before");
    }
    let runs = home.rows("SELECT id, sample, state, answer FROM runs ORDER BY id");
    let column = |row: &BTreeMap<String, Option<String>>, name: &str| row[name].clone().unwrap();
    let mut whole = BTreeMap::new();
    let mut interrupted = 0;
    for run in &runs {
        let (sample, state) = (column(run, "sample"), column(run, "state"));
        assert!(
            !whole.contains_key(&sample),
            "sample {sample} was there and was asked for again"
        );
        match state.as_str() {
            "answered" => drop(whole.insert(sample, column(run, "answer"))),
            "interrupted" => interrupted += 1,
            other => panic!("sample {sample} is {other}"),
        }
    }
    assert_eq!(whole.len(), ANSWERS);
    assert!(interrupted > 0, "the kills came between the requests only");
    let requests = server.requests().len();
    assert!(
        requests <= runs.len(),
        "each request is written down before it is sent"
    );
    let said: Vec<String> = (0..requests).map(text).collect();
    for (sample, answer) in &whole {
        assert!(said.contains(answer), "{sample}: {answer}");
        let shown = &shared.done.lock().unwrap()[&sample.parse().unwrap()];
        assert!(
            answer.contains(shown["verdict"]["justification"].as_str().unwrap()),
            "{shown}"
        );
    }
    for part in runs
        .iter()
        .filter(|r| r["state"].as_deref() == Some("interrupted"))
    {
        let part = column(part, "answer");
        assert!(said.iter().any(|text| text.starts_with(&part)), "{part}");
    }

    let again = tokio::task::block_in_place(|| ask(&home, url, 7).wait_with_output().unwrap());
    assert!(again.status.success());
    assert_eq!(
        server.requests().len(),
        requests,
        "what is there is not asked for"
    );
}
