//! How often it draws, and that it rests.

use super::support::server::{Script, Server};
use super::*;

const CHUNKS: usize = 10_000;

/// Frames are synchronized updates.
fn frames(session: &Session) -> usize {
    let begins = b"\x1b[?2026h";
    session
        .raw
        .windows(begins.len())
        .filter(|w| w == begins)
        .count()
}

#[test]
fn a_burst_of_ten_thousand_chunks_is_drawn_sixty_times_a_second() {
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let event = |text: &str| {
        let chunk =
            serde_json::json!({ "choices": [{ "index": 0, "delta": { "content": text } }] });
        format!("data: {chunk}\n\n")
    };
    let mut burst: String = (0..CHUNKS).map(|n| event(&format!("gap {n}\n"))).collect();
    burst += &event("that was all of it");
    burst += "data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\ndata: [DONE]\n\n";
    let script = Script::events().send(burst);
    let server = runtime.block_on(Server::start(vec![Script::json(404, "{}"), script]));
    let folder = tempfile::tempdir().unwrap();
    let config = format!(
        "model = \"lab/m\"\n[provider.lab]\ndialect = \"openai_chat\"\nbase_url = \"{}\"\nmodels = [\"m\"]\n",
        server.base_url()
    );
    std::fs::write(folder.path().join("config.toml"), config).unwrap();
    let folder = folder.path().to_str().unwrap();
    let mut session = Session::start(160, 45, &[("NEARMISS_CONFIG", folder)]);
    session.see("The body of car 301 overlaps");
    let (begun, before) = (Instant::now(), frames(&session));
    session.press("r");
    session.see("reasoning · lab/m · ");
    // An answer that has arrived is shown from its beginning; G goes to its end.
    session.see("no verdict: no JSON object in the answer");
    let (passed, drawn) = (begun.elapsed(), frames(&session) - before);
    let most = passed.as_millis() / 16 + 2;
    assert!(drawn as u128 <= most, "{drawn} frames in {passed:?}");
    assert!(drawn < CHUNKS / 4, "{drawn} frames of {CHUNKS} chunks");
    session.press("\x03");
    session.press("q");
    session.end();
}

#[test]
#[cfg(target_os = "linux")]
fn at_rest_it_takes_no_time_of_the_processor() {
    let mut session = Session::start(120, 40, &[]);
    session.see("The body of car 301 overlaps");
    let id = session.child.process_id().unwrap();
    // User and system time in hundredths of a second, of all threads.
    let spent = || {
        let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap();
        let (_, after) = stat.rsplit_once(')').unwrap();
        let fields: Vec<&str> = after.split_whitespace().collect();
        [fields[11], fields[12]]
            .iter()
            .map(|f| f.parse::<u64>().unwrap())
            .sum::<u64>()
    };
    let end = Instant::now() + PATIENCE;
    // It rests once it has neither worked nor drawn for two seconds: on a busy machine its start takes long.
    let mut before = (spent(), frames(&session));
    loop {
        let later = Instant::now() + Duration::from_secs(2);
        while Instant::now() < later {
            session.receive(Duration::from_millis(100));
        }
        let now = (spent(), frames(&session));
        if now == before {
            break;
        }
        assert!(Instant::now() < end, "it does not come to rest");
        before = now;
    }
    let (before, drawn) = before;
    std::thread::sleep(Duration::from_secs(4));
    session.receive(Duration::from_millis(10));
    let spent = spent() - before;
    assert!(spent <= 1, "{spent} hundredths of a second in four seconds");
    assert_eq!(frames(&session), drawn, "nothing is drawn");
    session.press("q");
    assert_eq!(session.end(), 0);
}
