//! `mcp`: JSON-RPC over standard input and output, and what is refused.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdout, Stdio};
use std::time::Instant;

use serde_json::{Value, json};

use super::support::program::Home;

/// A client.
pub struct Client {
    pub child: Child,
    out: BufReader<ChildStdout>,
    number: u64,
}

impl Client {
    pub fn start(home: &Home, arguments: &[&str]) -> Self {
        let mut command = home.command();
        command.arg("mcp").args(arguments);
        command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        let out = BufReader::new(child.stdout.take().unwrap());
        let mut client = Self {
            child,
            out,
            number: 0,
        };
        let hello = json!({"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": {"name": "t", "version": "0"}});
        let hello = client.ask("initialize", hello);
        assert_eq!(hello["result"]["protocolVersion"], "2025-06-18");
        client.send("{\"jsonrpc\":\"2.0\",\"method\":\"notifications/initialized\"}");
        client
    }

    pub fn send(&mut self, line: &str) {
        let input = self.child.stdin.as_mut().unwrap();
        input.write_all(format!("{line}\n").as_bytes()).unwrap();
        input.flush().unwrap();
    }

    pub fn next(&mut self) -> Value {
        let mut line = String::new();
        self.out.read_line(&mut line).unwrap();
        let message: Value = serde_json::from_str(&line).unwrap_or_else(|_| panic!("{line}"));
        assert_eq!(message["jsonrpc"], "2.0");
        message
    }

    pub fn ask(&mut self, method: &str, parameters: Value) -> Value {
        self.number += 1;
        let id = self.number;
        self.send(
            &json!({"jsonrpc": "2.0", "id": id, "method": method, "params": parameters})
                .to_string(),
        );
        let answer = self.next();
        assert_eq!(answer["id"], id, "{answer}");
        answer
    }

    pub fn call(&mut self, tool: &str, arguments: Value) -> Value {
        self.ask("tools/call", json!({"name": tool, "arguments": arguments}))["result"].clone()
    }

    pub fn end(self) {
        assert_eq!(self.rest(), "");
    }

    /// The same while jobs run, which may have said how far they are.
    pub fn end_amid_jobs(self) {
        let rest = self.rest();
        let mut lines = rest.lines();
        assert!(
            lines.all(|line| line.contains("notifications/progress")),
            "{rest}"
        );
    }

    /// What the server still says when its input ends.
    fn rest(mut self) -> String {
        drop(self.child.stdin.take());
        assert!(self.child.wait().unwrap().success());
        let mut rest = String::new();
        std::io::Read::read_to_string(&mut self.out, &mut rest).unwrap();
        rest
    }
}

pub const CUT_IN: &str = "ZAM_CutIn-1_1_T-1";

#[test]
fn a_session_lists_calls_reads_and_prompts() {
    let home = Home::new();
    let mut client = Client::start(&home, &[]);
    let tools = client.ask("tools/list", json!({}))["result"]["tools"].clone();
    let names: Vec<&str> = tools
        .as_array()
        .unwrap()
        .iter()
        .map(|t| t["name"].as_str().unwrap())
        .collect();
    assert!(
        names.contains(&"distance") && names.contains(&"plan"),
        "{names:?}"
    );
    assert!(
        !names.contains(&"judge") && !names.contains(&"ask_model"),
        "{names:?}"
    );
    let near = client.call("list_obstacles", json!({"scenario": CUT_IN, "at": 20}));
    let id = near["structuredContent"]["obstacles"][0]["id"]
        .as_i64()
        .unwrap();
    let begun = Instant::now();
    for _ in 0..200 {
        let said = client.call(
            "distance",
            json!({"scenario": CUT_IN, "at": 20, "obstacle": id}),
        );
        assert_eq!(
            said["structuredContent"]["distance"],
            near["structuredContent"]["obstacles"][0]["distance"]
        );
    }
    println!(
        "{:.0} calls a second",
        200.0 / begun.elapsed().as_secs_f64()
    );
    let other = json!({"scenario": CUT_IN, "at": 20, "ego": id});
    let of_other = client.call("list_obstacles", other.clone());
    let obstacles = &of_other["structuredContent"]["obstacles"];
    let ids: Vec<i64> = { obstacles.as_array().unwrap().iter() }
        .map(|one| one["id"].as_i64().unwrap())
        .collect();
    assert!(!ids.is_empty() && !ids.contains(&id), "{of_other}");
    let again = client.call("list_obstacles", json!({"scenario": CUT_IN, "at": 20}));
    assert_eq!(again, near, "one ego does not stand for another");
    for wrong in [json!(987_654), json!("../ego.csv")] {
        let mut other = other.clone();
        other["ego"] = wrong;
        assert_eq!(client.call("list_obstacles", other)["isError"], true);
    }
    let late = client.call(
        "distance",
        json!({"scenario": CUT_IN, "at": 20, "obstacle": id, "t": 1}),
    );
    assert_eq!(late["isError"], true);
    let resources = client.ask("resources/list", json!({}))["result"]["resources"].clone();
    let uri = resources[0]["uri"].clone();
    let read = client.ask("resources/read", json!({"uri": uri}))["result"].clone();
    assert!(
        read["contents"][0]["text"]
            .as_str()
            .unwrap()
            .contains("commonRoad")
    );
    let prompts = client.ask("prompts/list", json!({}))["result"]["prompts"].clone();
    let name = prompts[0]["name"].clone();
    let prompt = client.ask(
        "prompts/get",
        json!({"name": name, "arguments": {"scenario": CUT_IN}}),
    )["result"]
        .clone();
    assert!(
        prompt["messages"]
            .as_array()
            .is_some_and(|all| all.len() >= 2),
        "{prompt}"
    );
    let svg = client.call("render", json!({"scenario": CUT_IN, "at": 10, "ego": id}));
    assert!(
        svg["content"][0]["text"].as_str().unwrap().contains("<svg"),
        "{svg}"
    );
    client.end();
    let mut client = Client::start(&home, &["--oracles"]);
    let judged = client.call("judge", json!({"scenario": CUT_IN}));
    assert_eq!(judged["structuredContent"]["judge"], "reference/geometry");
    client.end();
}

#[test]
fn what_is_malformed_oversized_or_outside_is_refused() {
    let home = Home::new();
    let inside = home.files().join("in");
    std::fs::create_dir(&inside).unwrap();
    let xml = std::fs::read(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/scenarios/ZAM_CutIn-1_1_T-1.xml"
    ))
    .unwrap();
    let ego = std::fs::read(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/scenarios/ZAM_CutIn-1_1_T-1.ego_trajectory.csv"
    ))
    .unwrap();
    home.write("in/a.xml", &xml);
    home.write("in/a.ego_trajectory.csv", &ego);
    let secret = home.write("secret.xml", &xml);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&secret, inside.join("link.xml")).unwrap();
        // What leads nowhere is not read.
        std::os::unix::fs::symlink("nowhere", inside.join("a.old")).unwrap();
        home.write("in/b.xml", &xml);
        home.write("outer.csv", &ego);
        std::os::unix::fs::symlink(
            home.files().join("outer.csv"),
            inside.join("b.ego_trajectory.csv"),
        )
        .unwrap();
    }
    let mut client = Client::start(&home, &["in"]);
    for line in [
        "{",
        "[]",
        "7",
        "\"x\"",
        "{\"id\":1}",
        "{\"jsonrpc\":\"1.0\",\"id\":1,\"method\":\"ping\"}",
    ] {
        client.send(line);
        assert!(
            client.next()["error"]["code"]
                .as_i64()
                .is_some_and(|code| code < -32000),
            "{line}"
        );
    }
    client.send(&"x".repeat(3 << 20));
    assert!(
        client.next()["error"]["message"]
            .as_str()
            .unwrap()
            .contains("more than")
    );
    let unknown = client.ask("no/such", json!({}));
    assert_eq!(unknown["error"]["code"], -32601);
    let good = client.call("list_obstacles", json!({"scenario": "a.xml"}));
    assert_eq!(good["isError"], false, "{good}");
    let absolute = secret.display().to_string();
    for outside in [
        "../secret.xml",
        absolute.as_str(),
        "link.xml",
        "b.xml",
        "/etc/passwd",
        "",
        "in/../../secret.xml",
    ] {
        for tool in ["list_obstacles", "plan", "render"] {
            let refused = client.call(tool, json!({"scenario": outside}));
            assert_eq!(refused["isError"], true, "{tool} {outside} {refused}");
            assert!(!refused.to_string().contains("lanelet"), "{refused}");
        }
    }
    for arguments in [
        json!(null),
        json!([]),
        json!({"scenario": 7}),
        json!({"scenario": "a.xml", "at": "x"}),
        json!({"scenario": "a.xml", "at": 1e9 as i64}),
        json!({"scenario": "a.xml", "rad": 1}),
    ] {
        let refused = client.call("list_obstacles", arguments.clone());
        assert_eq!(refused["isError"], true, "{arguments}");
    }
    let option = client.call(
        "generate",
        json!({"scenario": "a.xml", "seed": "--model=lab/x"}),
    );
    assert_eq!(option["isError"], true);
    let resources = client.ask("resources/list", json!({}))["result"].to_string();
    assert!(
        !resources.contains("link") && !resources.contains("secret"),
        "{resources}"
    );
    client.end();
    home.run(&["mcp", "missing"]).status(2).says(&["missing"]);
}
