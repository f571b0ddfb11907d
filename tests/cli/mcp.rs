//! `mcp`: JSON-RPC over standard input and output, and what is refused.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdout, Stdio};
use std::time::Instant;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
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

    /// The same while jobs run, which may have said how far they are, and end.
    pub fn end_amid_jobs(self) {
        let rest = self.rest();
        let is_said = |line: &str| {
            line.contains("notifications/progress") || line.contains("the server ends")
        };
        assert!(rest.lines().all(is_said), "{rest}");
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

/// The bytes of the picture in a result.
pub fn picture(said: &Value) -> Vec<u8> {
    let image = &said["content"][0];
    assert_eq!(
        (&image["type"], &image["mimeType"]),
        (&json!("image"), &json!("image/png"))
    );
    BASE64_STANDARD
        .decode(image["data"].as_str().unwrap())
        .unwrap()
}

/// As many tokens as a model reads in JSON, about.
fn tokens(value: &Value) -> usize {
    value.to_string().len() / 4
}

#[test]
fn the_list_of_tools_is_short() {
    let home = Home::new();
    for (arguments, wanted) in [(&[][..], 7), (&["--allow-models", "--budget", "1"][..], 8)] {
        let mut client = Client::start(&home, arguments);
        let list = client.ask("tools/list", json!({}))["result"].clone();
        let tools = list["tools"].as_array().unwrap();
        assert_eq!(tools.len(), wanted, "{list}");
        assert!(tokens(&list) <= 3000, "{} tokens", tokens(&list));
        for tool in tools {
            let name = tool["name"].as_str().unwrap();
            assert_eq!(
                name == "ask_model",
                tool["annotations"]["openWorldHint"] == true
            );
            // Every one opens the program's own scenarios by what its schema asks for.
            assert!(
                jsonschema::validator_for(&tool["inputSchema"]).is_ok(),
                "{name}"
            );
        }
        client.end();
    }
}

#[test]
fn an_agent_finds_the_worst_scenario_and_explains_it_in_six_calls() {
    let home = Home::new();
    let mut client = Client::start(&home, &[]);
    let list = client.call("list_scenarios", json!({}))["structuredContent"].clone();
    let all = list["scenarios"].as_array().unwrap();
    let severities: Vec<u64> = all
        .iter()
        .map(|one| one["severity"].as_u64().unwrap())
        .collect();
    assert!(severities.is_sorted() && all.len() == list["all"], "{list}");
    let worst = &all[0];
    let (name, at, obstacle) = (&worst["scenario"], &worst["at"], &worst["obstacle"]);
    assert!(
        worst["ego"].is_null() && worst["why"].is_string(),
        "{worst}"
    );
    let inspected = client.call("inspect", json!({"scenario": name}))["structuredContent"].clone();
    let moment = &inspected["moments"][0];
    assert_eq!((&moment["at"], &moment["obstacle"]), (at, obstacle));
    assert!(inspected["steps"][1].as_i64() >= at.as_i64(), "{inspected}");
    assert!(
        inspected["ego"].as_str().unwrap().contains("recorded"),
        "{inspected}"
    );
    let text = |said: &Value| {
        assert_eq!(said["isError"], false, "{said}");
        said["content"][0]["text"].as_str().unwrap().to_string()
    };
    let table = text(&client.call("describe", json!({"scenario": name})));
    assert!(
        table.contains(&format!(" {obstacle},")) && table.contains("t [s],who"),
        "{table}"
    );
    let arguments = json!({"scenario": name, "at": at, "frame": "metrics", "history": 3, "measures": "ttc,pet",
        "obstacle": obstacle});
    let table = text(&client.call("describe", arguments));
    assert!(
        table.contains("ttc [s]") && table.contains("pet [s]"),
        "{table}"
    );
    let png = picture(&client.call("render", json!({"scenario": name})));
    let mut reader = png::Decoder::new(std::io::Cursor::new(png))
        .read_info()
        .unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut pixels).unwrap();
    assert!(frame.width > 500 && frame.height > 300);
    let query = json!({"filter": "manoeuvre:cut_in ttc<1", "number": 1});
    let found = client.call("find", query)["structuredContent"].clone();
    assert_eq!(found["filter"], "manoeuvre:cut_in ttc<1");
    let [window] = found["found"].as_array().unwrap().as_slice() else {
        panic!("{found}");
    };
    assert_eq!(window["scenario"], CUT_IN);
    assert!(found["windows"].as_u64() >= Some(1), "{found}");
    for (filter, says) in [
        ("rain on the moon", "reads as a sentence"),
        ("manoeuvre:cutting", "available: cut_in"),
    ] {
        let again = client.call("find", json!({"filter": filter}));
        assert!(
            again.to_string().contains(says) && again["isError"] == true,
            "{again}"
        );
    }
    client.end();
}

#[test]
fn a_session_lists_calls_reads_and_prompts() {
    let home = Home::new();
    let mut client = Client::start(&home, &[]);
    let seen = client.call("inspect", json!({"scenario": CUT_IN}));
    let id = seen["structuredContent"]["moments"][0]["obstacle"]
        .as_i64()
        .unwrap();
    let begun = Instant::now();
    for _ in 0..50 {
        assert_eq!(client.call("inspect", json!({"scenario": CUT_IN})), seen);
    }
    println!("{:.0} calls a second", 50.0 / begun.elapsed().as_secs_f64());
    let other = json!({"scenario": CUT_IN, "ego": id});
    let of_other = client.call("inspect", other.clone());
    let moments = &of_other["structuredContent"]["moments"];
    let ids: Vec<i64> = { moments.as_array().unwrap().iter() }
        .map(|one| one["obstacle"].as_i64().unwrap())
        .collect();
    assert!(!ids.is_empty() && !ids.contains(&id), "{of_other}");
    let again = client.call("inspect", json!({"scenario": CUT_IN}));
    assert_eq!(again, seen, "one ego does not stand for another");
    for wrong in [json!(987_654), json!("../ego.csv")] {
        let mut other = other.clone();
        other["ego"] = wrong;
        for tool in ["inspect", "describe"] {
            assert_eq!(client.call(tool, other.clone())["isError"], true);
        }
    }
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
    let drawn = client.call("render", json!({"scenario": CUT_IN, "at": 10, "ego": id}));
    assert!(picture(&drawn).starts_with(b"\x89PNG"));
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
    let long = "x".repeat(3 << 20);
    let arguments = json!({"scenario": long});
    let named = json!({"method": "tools/call", "params": {"name": "inspect", "arguments": arguments}, "jsonrpc": "2.0", "id": "z"});
    for (line, id) in [
        (long.clone(), Value::Null),
        (named.to_string(), json!("z")),
        (format!("{{\"id\":9,\"method\":\"{long}\"}}"), json!(9)),
    ] {
        client.send(&line);
        let refused = client.next();
        let why = refused["error"]["message"].as_str().unwrap();
        assert!(
            why.contains("more than") && refused["id"] == id,
            "{refused}"
        );
    }
    // No JSON for all that cannot be told in UTF-8.
    client.send(r#"{"method":"ping","params":{"x":"\ud800"},"jsonrpc":"2.0","id":3}"#);
    let refused = client.next();
    assert_eq!(
        (&refused["id"], &refused["error"]["code"]),
        (&json!(3), &json!(-32700))
    );
    let unknown = client.ask("no/such", json!({}));
    assert_eq!(unknown["error"]["code"], -32601);
    let good = client.call("inspect", json!({"scenario": "a.xml"}));
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
        for tool in ["inspect", "describe", "plan", "render"] {
            let refused = client.call(tool, json!({"scenario": outside}));
            // Of a scenario whose ego alone lies outside the rest is told.
            if tool == "inspect" && outside == "b.xml" {
                let why = &refused["structuredContent"]["no_ego"];
                assert!(
                    why.as_str().unwrap().contains("outside the folders"),
                    "{refused}"
                );
                continue;
            }
            assert_eq!(refused["isError"], true, "{tool} {outside} {refused}");
            assert!(!refused.to_string().contains("lanelet"), "{refused}");
        }
    }
    // None of its cars is taken for the ego.
    let listed = client.call("list_scenarios", json!({}));
    let all = listed["structuredContent"]["scenarios"].as_array().unwrap();
    let row = all.iter().find(|row| row["scenario"] == "b.xml").unwrap();
    let why = row["error"].as_str().unwrap();
    assert!(why.contains("outside the folders"), "{row}");
    for arguments in [
        json!(null),
        json!({"scenario": 7}),
        json!({"scenario": "a.xml", "at": "x"}),
        json!({"scenario": "a.xml", "at": 1e9 as i64}),
        json!({"scenario": "a.xml", "rad": 1}),
    ] {
        let refused = client.call("describe", arguments.clone());
        assert_eq!(refused["isError"], true, "{arguments}");
    }
    let refused = client.ask("tools/call", json!({"name": "describe", "arguments": []}));
    assert_eq!(refused["error"]["code"], -32602, "{refused}");
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
