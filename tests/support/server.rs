//! A web server on loopback that answers each request with exactly the bytes, pieces and pauses of a script.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinHandle;

/// What the server does with one request, in order; afterwards it closes the connection.
#[derive(Clone, Debug, Default)]
pub struct Script(Vec<Step>);

#[derive(Clone, Debug)]
enum Step {
    Send(Vec<u8>),
    Pause(Duration),
    Endless(Vec<u8>, Duration),
    AwaitClose,
    Whole,
}

impl Script {
    /// Closes the connection without a word.
    pub fn silent() -> Self {
        Self::default()
    }

    /// An answer with a content length.
    pub fn answer(status: u16, headers: &[(&str, &str)], body: &str) -> Self {
        let mut head = format!(
            "HTTP/1.1 {status} X\r\nContent-Length: {}\r\nConnection: close\r\n",
            body.len()
        );
        for (name, value) in headers {
            head.push_str(&format!("{name}: {value}\r\n"));
        }
        Self::silent().send(head + "\r\n" + body)
    }

    /// An answer with a JSON body.
    pub fn json(status: u16, body: &str) -> Self {
        Self::answer(status, &[("Content-Type", "application/json")], body)
    }

    /// The head of an event stream that lasts until the connection closes.
    pub fn events() -> Self {
        Self::silent().send("HTTP/1.1 200 OK\r\nContent-Type: text/event-stream; charset=utf-8\r\nConnection: close\r\n\r\n")
    }

    /// The head of a stream of JSON lines that lasts until the connection closes.
    pub fn lines() -> Self {
        Self::silent().send(
            "HTTP/1.1 200 OK\r\nContent-Type: application/x-ndjson\r\nConnection: close\r\n\r\n",
        )
    }

    /// The head of an event stream in HTTP chunks, which tells a cut connection from a finished one.
    pub fn chunked_events() -> Self {
        Self::silent().send(
            "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nTransfer-Encoding: chunked\r\nConnection: close\r\n\r\n",
        )
    }

    /// These bytes.
    pub fn send(mut self, bytes: impl AsRef<[u8]>) -> Self {
        self.0.push(Step::Send(bytes.as_ref().to_vec()));
        self
    }

    /// These bytes as one HTTP chunk, which clients see as one piece.
    pub fn chunk(self, bytes: impl AsRef<[u8]>) -> Self {
        let bytes = bytes.as_ref();
        self.send([format!("{:x}\r\n", bytes.len()).as_bytes(), bytes, b"\r\n"].concat())
    }

    /// The last HTTP chunk.
    pub fn end_of_chunks(self) -> Self {
        self.send("0\r\n\r\n")
    }

    /// Nothing for a while.
    pub fn pause(mut self, wait: Duration) -> Self {
        self.0.push(Step::Pause(wait));
        self
    }

    /// These bytes again and again, with a pause after each time, until the client closes the connection.
    pub fn endless(mut self, bytes: impl AsRef<[u8]>, wait: Duration) -> Self {
        self.0.push(Step::Endless(bytes.as_ref().to_vec(), wait));
        self
    }

    /// Everything of another script behind this one; of its head, if it begins with one, there may only be one.
    pub fn append(mut self, other: Self) -> Self {
        let head =
            |step: &Step| matches!(step, Step::Send(bytes) if bytes.starts_with(b"HTTP/1.1"));
        let begun = self.0.iter().any(head);
        self.0
            .extend(other.0.into_iter().filter(|step| !begun || !head(step)));
        self
    }

    /// Counts the request among those of [`Server::whole`].
    pub fn whole(mut self) -> Self {
        self.0.push(Step::Whole);
        self
    }

    /// Waits until the client closes the connection; [`Server::seen_close`] counts it.
    pub fn await_close(mut self) -> Self {
        self.0.push(Step::AwaitClose);
        self
    }
}

/// A request as it came in.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    pub method: String,
    pub path: String,
    /// Names in lower case.
    pub headers: Vec<(String, String)>,
    pub body: Vec<u8>,
}

impl Recorded {
    /// The value of a header, by its lower-case name.
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers
            .iter()
            .find(|(n, _)| n == name)
            .map(|(_, v)| v.as_str())
    }

    /// The body as JSON.
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_slice(&self.body).unwrap()
    }
}

#[derive(Default)]
struct Seen {
    requests: Vec<Recorded>,
    whole: Vec<usize>,
    closed: usize,
}

/// What is answered to the n-th request, from 0.
type Answering = Arc<dyn Fn(usize, &Recorded) -> Option<Script> + Send + Sync>;

/// A running server; it stops when dropped. The n-th request gets the n-th script, further ones a closed connection.
pub struct Server {
    base_url: String,
    seen: Arc<Mutex<Seen>>,
    task: JoinHandle<()>,
}

impl Server {
    /// Starts on a free port of 127.0.0.1.
    pub async fn start(scripts: Vec<Script>) -> Self {
        Self::answering(move |number, _| scripts.get(number).cloned()).await
    }

    /// The same with a script for the n-th request, from 0, by what it asks.
    pub async fn answering(
        script: impl Fn(usize, &Recorded) -> Option<Script> + Send + Sync + 'static,
    ) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let base_url = format!("http://{}", listener.local_addr().unwrap());
        let seen = Arc::new(Mutex::new(Seen::default()));
        let task = tokio::spawn(serve(listener, Arc::new(script), Arc::clone(&seen)));
        Self {
            base_url,
            seen,
            task,
        }
    }

    /// `http://127.0.0.1:port`.
    pub fn base_url(&self) -> &str {
        &self.base_url
    }

    /// All requests so far.
    pub fn requests(&self) -> Vec<Recorded> {
        self.seen.lock().unwrap().requests.clone()
    }

    /// Bodies of the requests whose script came to [`Script::whole`].
    pub fn whole(&self) -> Vec<Vec<u8>> {
        let seen = self.seen.lock().unwrap();
        let bodies = seen.whole.iter().map(|n| seen.requests[*n].body.clone());
        bodies.collect()
    }

    /// Waits at most five seconds for a client to close its connection during [`Script::await_close`].
    pub async fn seen_close(&self) -> bool {
        for _ in 0..500 {
            if self.seen.lock().unwrap().closed > 0 {
                return true;
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        false
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.task.abort();
    }
}

async fn serve(listener: TcpListener, answering: Answering, seen: Arc<Mutex<Seen>>) {
    let mut connections = tokio::task::JoinSet::new();
    loop {
        let (mut stream, _) = listener.accept().await.unwrap();
        let (answering, seen) = (Arc::clone(&answering), Arc::clone(&seen));
        connections.spawn(async move {
            stream.set_nodelay(true).unwrap();
            let Some(request) = read_request(&mut stream).await else {
                return;
            };
            let number = {
                let mut seen = seen.lock().unwrap();
                seen.requests.push(request.clone());
                seen.requests.len() - 1
            };
            let Some(script) = answering(number, &request) else {
                return;
            };
            for step in &script.0 {
                match step {
                    // The client may have gone, which is what some tests are about.
                    Step::Send(bytes) => drop(stream.write_all(bytes).await),
                    Step::Whole => seen.lock().unwrap().whole.push(number),
                    Step::Endless(bytes, wait) => {
                        while stream.write_all(bytes).await.is_ok() {
                            tokio::time::sleep(*wait).await;
                        }
                    }
                    Step::Pause(wait) => tokio::time::sleep(*wait).await,
                    Step::AwaitClose => {
                        let mut rest = [0; 64];
                        while stream.read(&mut rest).await.is_ok_and(|n| n > 0) {}
                        seen.lock().unwrap().closed += 1;
                    }
                }
            }
        });
    }
}

/// One request off a connection; nothing if it ends before.
pub async fn read_request(stream: &mut TcpStream) -> Option<Recorded> {
    let mut bytes = Vec::new();
    let head_end = loop {
        if let Some(at) = bytes.windows(4).position(|w| w == b"\r\n\r\n") {
            break at;
        }
        if stream.read_buf(&mut bytes).await.ok()? == 0 {
            return None;
        }
    };
    let head = String::from_utf8(bytes[..head_end].to_vec()).unwrap();
    let mut lines = head.split("\r\n");
    let mut first = lines.next()?.split(' ');
    let (method, path) = (first.next()?.to_owned(), first.next()?.to_owned());
    let headers: Vec<_> = lines
        .filter_map(|line| line.split_once(':'))
        .map(|(name, value)| (name.to_lowercase(), value.trim().to_owned()))
        .collect();
    let length = headers
        .iter()
        .find(|(name, _)| name == "content-length")
        .map_or(0, |(_, v)| v.parse().unwrap());
    let mut body = bytes.split_off(head_end + 4);
    while body.len() < length {
        if stream.read_buf(&mut body).await.ok()? == 0 {
            return None;
        }
    }
    Some(Recorded {
        method,
        path,
        headers,
        body,
    })
}
