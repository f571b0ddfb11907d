//! A batch of 1,440 requests of 300 ms each, 64 at once: how near to the ideal time it comes, and what it takes.
//!
//! It runs the program itself against a server in this process and prints the time over the ideal one, the share of a
//! core, the peak of the memory, and the program's own work for each request. `NEARMISS_BENCH_SCENARIOS` may name a
//! folder of scenarios with egos to ask about instead of copies of the bundled ones; `NEARMISS_BENCH_SAMPLES`, how
//! many answers to each of the eight questions about each (3).
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};

const SCENARIOS: usize = 60;
const AT_ONCE: u32 = 64;
const EACH: Duration = Duration::from_millis(300);

fn main() {
    // `cargo test --benches` only wants to know that it starts.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let scenarios = match std::env::var_os("NEARMISS_BENCH_SCENARIOS") {
        Some(given) => PathBuf::from(given),
        None => copies(folder.path()),
    };
    let samples = std::env::var("NEARMISS_BENCH_SAMPLES").unwrap_or_else(|_| "3".into());
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .enable_all()
        .build()
        .unwrap();
    let seen = Arc::new(Seen::default());
    let listener = runtime.block_on(TcpListener::bind("127.0.0.1:0")).unwrap();
    let url = format!("http://{}", listener.local_addr().unwrap());
    runtime.spawn(serve(listener, Arc::clone(&seen)));

    let config = folder.path().join("config");
    std::fs::create_dir(&config).unwrap();
    let provider = format!("[provider.lab]\nbase_url = \"{url}\"\nkey_env = []\n");
    std::fs::write(config.join("config.toml"), provider).unwrap();
    let before = children_cpu();
    let begun = Instant::now();
    let mut child = Command::new(env!("CARGO_BIN_EXE_nearmiss"))
        .arg("evaluate")
        .arg(&scenarios)
        .args([
            "--model",
            "lab/tiny",
            "--task",
            "collision",
            "--frame",
            "ego,cartesian",
        ])
        .args(["--techniques", "base,cp,cot,all", "--samples", &samples])
        .args(["--set", &format!("concurrency={AT_ONCE}"), "--format=json"])
        .env("NEARMISS_CONFIG", &config)
        .env("NEARMISS_DATA", folder.path().join("data"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let (mut memory, mut first) = (0, None);
    let status = loop {
        memory = memory.max(peak_kb(child.id()));
        if first.is_none() && seen.requests.load(Ordering::Relaxed) > 0 {
            first = Some(begun.elapsed());
        }
        match child.try_wait().unwrap() {
            Some(status) => break status,
            None => std::thread::sleep(Duration::from_millis(5)),
        }
    };
    let wall = begun.elapsed().as_secs_f64();
    assert!(status.success(), "{status}");
    let requests = seen.requests.load(Ordering::Relaxed);
    let cpu = children_cpu() - before;
    let ideal = requests.div_ceil(u64::from(AT_ONCE)) as f64 * EACH.as_secs_f64();
    println!(
        "requests          {requests}, of {} ms, {AT_ONCE} at once",
        EACH.as_millis()
    );
    println!("ideal             {ideal:.2} s");
    println!(
        "before the first  {:.2} s",
        first.unwrap_or_default().as_secs_f64()
    );
    println!("whole             {wall:.2} s, {:.2} × ideal", wall / ideal);
    println!("processor         {cpu:.2} s, {:.2} cores", cpu / wall);
    println!(
        "own work          {:.2} ms a request",
        cpu * 1000.0 / requests as f64
    );
    println!("memory            {:.0} MB at most", memory as f64 / 1024.0);
}

/// Copies of the bundled scenarios under names of their own.
fn copies(folder: &Path) -> PathBuf {
    let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let mut names: Vec<String> = std::fs::read_dir(&bundled)
        .unwrap()
        .filter_map(|file| file.unwrap().file_name().into_string().ok())
        .filter_map(|name| name.strip_suffix(".xml").map(String::from))
        .collect();
    names.sort();
    let into = folder.join("scenarios");
    std::fs::create_dir(&into).unwrap();
    for n in 0..SCENARIOS {
        let name = &names[n % names.len()];
        let new = name.replace("-1_1_T-1", &format!("-{n}_1_T-1"));
        for ending in [".xml", ".ego_trajectory.csv"] {
            let text = std::fs::read_to_string(bundled.join(format!("{name}{ending}"))).unwrap();
            // No two are the same, else one answer would do for several.
            let text = match ending {
                ".xml" => text.replace(name.as_str(), &new).replace(
                    "<dynamicObstacle id=\"",
                    &format!("<dynamicObstacle id=\"{}", n + 10),
                ),
                _ => text,
            };
            std::fs::write(into.join(format!("{new}{ending}")), text).unwrap();
        }
    }
    into
}

#[derive(Default)]
struct Seen {
    requests: AtomicU64,
}

async fn serve(listener: TcpListener, seen: Arc<Seen>) {
    loop {
        let (stream, _) = listener.accept().await.unwrap();
        let seen = Arc::clone(&seen);
        tokio::spawn(async move {
            // The client closes the connection when it needs it no more.
            let _ = answer(stream, &seen).await;
        });
    }
}

/// Answers one request after the other on a connection.
async fn answer(mut stream: TcpStream, seen: &Seen) -> std::io::Result<()> {
    stream.set_nodelay(true)?;
    let mut bytes = Vec::new();
    loop {
        let head = loop {
            if let Some(at) = bytes.windows(4).position(|w| w == b"\r\n\r\n") {
                break at + 4;
            }
            if stream.read_buf(&mut bytes).await? == 0 {
                return Ok(());
            }
        };
        let text = String::from_utf8_lossy(&bytes[..head]).to_lowercase();
        let length = text
            .split("content-length:")
            .nth(1)
            .and_then(|rest| rest.lines().next()?.trim().parse().ok());
        let all = head + length.unwrap_or(0_usize);
        while bytes.len() < all {
            if stream.read_buf(&mut bytes).await? == 0 {
                return Ok(());
            }
        }
        bytes.drain(..all);
        let begun = Instant::now();
        seen.requests.fetch_add(1, Ordering::Relaxed);
        let pieces = pieces();
        let pause = EACH / (pieces.len() as u32 + 1);
        stream
            .write_all(b"HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nTransfer-Encoding: chunked\r\n\r\n")
            .await?;
        for (n, piece) in pieces.iter().enumerate() {
            let due = begun + pause * (n as u32 + 1);
            tokio::time::sleep_until(due.into()).await;
            let chunk = format!("{:x}\r\n{piece}\r\n", piece.len());
            stream.write_all(chunk.as_bytes()).await?;
        }
        tokio::time::sleep_until((begun + EACH).into()).await;
        stream.write_all(b"0\r\n\r\n").await?;
    }
}

/// An answer of about 200 tokens, as servers stream it.
fn pieces() -> Vec<String> {
    let words = "The gap to the obstacle ahead shrinks and then grows again. ".repeat(8);
    let answer = serde_json::json!({
        "collision": false, "obstacles": [], "justification": words.trim_end(),
    });
    let text: Vec<char> = answer.to_string().chars().collect();
    let mut pieces: Vec<String> = text
        .chunks(24)
        .map(|part| {
            let part: String = part.iter().collect();
            let delta = serde_json::json!({
                "model": "tiny", "choices": [{ "index": 0, "delta": { "content": part } }],
            });
            format!("data: {delta}\n\n")
        })
        .collect();
    let end = "data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\ndata: [DONE]\n\n";
    pieces.push(end.into());
    pieces
}

/// The most memory that a process has had, kB; 0 where the system does not say.
fn peak_kb(id: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = line.and_then(|line| line.split_whitespace().next()?.parse().ok());
    number.unwrap_or(0)
}

/// Seconds of processor of the processes that were waited for; 0 where the system does not say.
fn children_cpu() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // Behind the name, which is in parentheses: the 14th and 15th are those of the children, in hundredths.
    let fields = stat
        .rsplit(')')
        .next()
        .unwrap_or_default()
        .split_whitespace();
    let ticks: u64 = fields
        .skip(13)
        .take(2)
        .filter_map(|f| f.parse::<u64>().ok())
        .sum();
    ticks as f64 / 100.0
}
