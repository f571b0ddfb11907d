//! `mcp`: which files are read for clients, and scenarios as resources.

use serde_json::{Value, json};

use super::mcp::{CUT_IN, Client};
use super::support::program::Home;

fn bundled(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/");
    std::fs::read(format!("{folder}{name}")).unwrap()
}

fn resources(client: &mut Client) -> Vec<Value> {
    let list = client.ask("resources/list", json!({}))["result"]["resources"].clone();
    list.as_array().unwrap().clone()
}

#[cfg(unix)]
#[test]
fn files_that_a_scenario_reads_lie_in_the_folders() {
    let home = Home::new();
    std::fs::create_dir(home.files().join("in")).unwrap();
    home.run(&["convert", CUT_IN, "-o", "in/drive.xosc"])
        .status(0);
    let text = std::fs::read_to_string(home.files().join("in/drive.xosc")).unwrap();
    assert!(text.contains("drive.xodr"));
    let road = std::fs::read(home.files().join("in/drive.xodr")).unwrap();
    home.write("outer.xodr", road);
    std::os::unix::fs::symlink(
        home.files().join("outer.xodr"),
        home.files().join("in/road.xodr"),
    )
    .unwrap();
    home.write("in/link.xosc", text.replace("drive.xodr", "road.xodr"));
    home.write("in/up.xosc", text.replace("drive.xodr", "../outer.xodr"));
    let mut client = Client::start(&home, &["in"]);
    let why = |said: &Value| said["content"][0].to_string();
    for (file, inside) in [
        ("drive.xosc", true),
        ("link.xosc", false),
        ("up.xosc", false),
    ] {
        // Both look at the same files, in this process and in one of their own.
        for tool in ["inspect", "render"] {
            let said = client.call(tool, json!({"scenario": file}));
            assert_eq!(
                said["isError"].as_bool(),
                Some(!inside),
                "{tool} {file} {said}"
            );
            assert_eq!(
                why(&said).contains("outside the folders"),
                !inside,
                "{tool} {file} {said}"
            );
        }
    }
    client.end();
}

#[test]
fn a_changed_ego_is_read_anew() {
    let home = Home::new();
    std::fs::create_dir(home.files().join("in")).unwrap();
    home.write("in/a.xml", bundled("ZAM_CutIn-1_1_T-1.xml"));
    let ego = String::from_utf8(bundled("ZAM_CutIn-1_1_T-1.ego_trajectory.csv")).unwrap();
    home.write("in/a.ego_trajectory.csv", &ego);
    let mut client = Client::start(&home, &["in"]);
    let late = json!({"scenario": "a.xml", "at": 30});
    let said = client.call("describe", late.clone());
    assert_eq!(said["isError"], false, "{said}");
    let half: Vec<&str> = ego.lines().take(20).collect();
    home.write("in/a.ego_trajectory.csv", half.join("\n") + "\n");
    let said = client.call("describe", late);
    assert!(
        said.to_string().contains("the recording has steps"),
        "{said}"
    );
    client.end();
}

#[test]
fn resources_of_two_folders_are_told_apart_and_measured_before_they_are_read() {
    let home = Home::new();
    for (folder, name) in [("one", "ZAM_CutIn-1_1_T-1"), ("two", "ZAM_JamTail-1_1_T-1")] {
        std::fs::create_dir(home.files().join(folder)).unwrap();
        home.write(format!("{folder}/a.xml"), bundled(&format!("{name}.xml")));
    }
    let large = home.write("two/large.xml", bundled("ZAM_CutIn-1_1_T-1.xml"));
    // Sparse, so that it costs no room.
    let file = std::fs::File::options().write(true).open(large).unwrap();
    file.set_len(9 << 20).unwrap();
    let mut client = Client::start(&home, &["one", "two"]);
    let all = resources(&mut client);
    let uris: std::collections::BTreeSet<&str> =
        all.iter().map(|r| r["uri"].as_str().unwrap()).collect();
    assert_eq!((all.len(), uris.len()), (3, 3), "{all:?}");
    assert!(all.iter().all(|r| r["mimeType"] == "application/xml"));
    for resource in &all {
        let name = resource["name"].as_str().unwrap();
        let read = client.ask("resources/read", json!({"uri": resource["uri"]}));
        if name.contains("large") {
            let why = read["error"]["message"].as_str().unwrap();
            assert!(why.contains("9437184 bytes"), "{why}");
            continue;
        }
        let text = read["result"]["contents"][0]["text"].as_str().unwrap();
        let expected = if name.starts_with("2:") {
            "ZAM_JamTail"
        } else {
            "ZAM_CutIn"
        };
        assert!(text.contains(expected), "{name}");
        // Tools take the same name.
        let said = client.call("render", json!({"scenario": name, "at": 0}));
        assert_eq!(said["isError"], false, "{said}");
    }
    client.end();
}

#[test]
fn without_a_recorded_ego_clients_choose_one() {
    let home = Home::new();
    std::fs::create_dir(home.files().join("in")).unwrap();
    home.write("in/a.xml", bundled("ZAM_CutIn-1_1_T-1.xml"));
    let mut client = Client::start(&home, &["in"]);
    let prompt = |client: &mut Client, ego: Value| {
        let arguments = json!({"scenario": "a.xml", "at": "20", "ego": ego});
        let asked = json!({"name": "collision-ego", "arguments": arguments});
        client.ask("prompts/get", asked)
    };
    let prompted = prompt(&mut client, Value::Null)["error"]["message"].clone();
    let said = client.call("describe", json!({"scenario": "a.xml"}));
    let wanted = "the scenario has no recorded ego; give `ego`, the id of an obstacle: 301";
    for why in [prompted, said["content"][0]["text"].clone()] {
        let why = why.as_str().unwrap();
        assert!(why.starts_with(wanted) && !why.contains("--"), "{why}");
    }
    let of = |ego: &str, client: &mut Client| {
        let said = prompt(client, json!(ego));
        assert!(said["result"]["messages"].is_array(), "{said}");
        said["result"]["messages"].to_string()
    };
    assert_ne!(of("301", &mut client), of("302", &mut client));
    // Lists tell who might be it, the most endangered first.
    let list = client.call("list_scenarios", json!({}))["structuredContent"].clone();
    let worst = &list["scenarios"][0];
    let seen = client.call("inspect", json!({"scenario": "a.xml"}))["structuredContent"].clone();
    assert_eq!(seen["moments"][0]["ego"], worst["ego"]);
    assert!(
        seen["no_ego"].as_str().unwrap().starts_with(wanted),
        "{seen}"
    );
    let told = json!({"scenario": "a.xml", "ego": worst["ego"], "at": worst["at"]});
    assert_eq!(client.call("describe", told)["isError"], false);
    assert_eq!(prompt(&mut client, json!("near"))["error"]["code"], -32602);
    // What is wrong with a file beside it is said, with the same way out.
    home.write("in/a.ego_trajectory.csv", "no,table\n");
    let said = client.call("describe", json!({"scenario": "a.xml"}));
    let why = said["content"][0]["text"].as_str().unwrap();
    assert!(
        why.contains("a.ego_trajectory.csv") && why.contains("give `ego`"),
        "{why}"
    );
    client.end();
}

#[test]
fn wrong_arguments_are_told_in_words_of_the_protocol() {
    let home = Home::new();
    std::fs::create_dir(home.files().join("in")).unwrap();
    let mut client = Client::start(&home, &["in"]);
    let mut why = |tool: &str, arguments: Value| {
        let said = client.call(tool, arguments);
        assert_eq!(said["isError"], true, "{said}");
        said["content"][0]["text"].as_str().unwrap().to_string()
    };
    for tool in ["inspect", "plan"] {
        let said = why(tool, json!({"scenario": 5}));
        assert!(
            said.starts_with("argument `scenario` is 5; expected text"),
            "{said}"
        );
    }
    let said = why("describe", json!({"scenario": CUT_IN, "zzz": 1}));
    for name in ["scenario", "at", "frame", "history", "ego", "obstacle"] {
        assert!(said.contains(name), "{name}: {said}");
    }
    for (tool, arguments, wanted) in [
        (
            "generate",
            json!({"candidates": -1}),
            "`candidates` is -1; expected a whole number from 1 to 100000",
        ),
        (
            "generate",
            json!({"seed": -1}),
            "`seed` is -1; expected a whole number, 0 or more",
        ),
        (
            "generate",
            json!({"zzz": 1}),
            "available: scenario, candidates, seed",
        ),
        (
            "render",
            json!({"at": 9999}),
            "`at` 9999: the recording has steps",
        ),
    ] {
        let mut arguments = arguments;
        arguments["scenario"] = json!(CUT_IN);
        let said = why(tool, arguments);
        assert!(said.contains(wanted) && !said.contains("--"), "{said}");
    }
    // Bundled scenarios open beside folders, and no text says that only files of folders do.
    let said = client.call("inspect", json!({"scenario": CUT_IN}));
    assert_eq!(said["isError"], false, "{said}");
    let said = client
        .call("inspect", json!({"scenario": "zzz.xml"}))
        .to_string();
    assert!(!said.contains("can be opened"), "{said}");
    client.end();
}

#[test]
fn a_list_goes_on_from_cursors_that_were_given_alone() {
    let home = Home::new();
    for i in 0..230 {
        let root = "<commonRoad timeStepSize=\"0.1\" commonRoadVersion=\"2020a\"/>";
        home.write(format!("all/{i}.xml"), root);
    }
    let mut client = Client::start(&home, &["all"]);
    let first = client.ask("resources/list", json!({"cursor": null}))["result"].clone();
    assert_eq!(first["resources"].as_array().unwrap().len(), 200);
    let next = client.ask("resources/list", json!({"cursor": first["nextCursor"]}));
    assert_eq!(next["result"]["resources"].as_array().unwrap().len(), 30);
    assert!(next["result"]["nextCursor"].is_null());
    for (method, cursor) in [
        ("resources/list", json!("next")),
        ("resources/list", json!("")),
        ("resources/list", json!("0")),
        ("resources/list", json!("7")),
        ("resources/list", json!("400")),
        ("resources/list", json!("-200")),
        ("tools/list", json!("200")),
        ("prompts/list", json!("")),
        ("resources/templates/list", json!("1")),
    ] {
        let answer = client.ask(method, json!({ "cursor": cursor }));
        assert_eq!(
            answer["error"]["code"], -32602,
            "{method} {cursor}: {answer}"
        );
    }
    let mut page = |cursor: Value| client.call("list_scenarios", json!({ "cursor": cursor }));
    let first = page(Value::Null)["structuredContent"].clone();
    let next = page(first["cursor"].clone())["structuredContent"].clone();
    assert_eq!(next["scenarios"].as_array().unwrap().len(), 25);
    assert_ne!(first["scenarios"][0], next["scenarios"][0]);
    for wrong in [json!("7"), json!("250"), json!(25)] {
        assert_eq!(page(wrong)["isError"], true);
    }
    client.end();
}

/// A scenario that takes a while to read.
#[cfg(unix)]
#[test]
fn while_a_scenario_is_read_a_ping_is_answered_and_a_request_taken_back() {
    let home = Home::new();
    for name in ["in/a.xml", "in/b.xml"] {
        home.write(name, super::interrupted::crowded(300));
    }
    let mut client = Client::start(&home, &["in"]);
    let send = |client: &mut Client, id: i64, method: &str, parameters: Value| {
        let message = json!({"jsonrpc": "2.0", "id": id, "method": method, "params": parameters});
        client.send(&message.to_string());
    };
    let call = |name: &str| {
        let arguments = json!({"scenario": name, "ego": 1000301});
        json!({"name": "inspect", "arguments": arguments})
    };
    send(&mut client, 100, "tools/call", call("a.xml"));
    send(&mut client, 101, "ping", json!({}));
    assert_eq!(client.next()["id"], 101);
    assert_eq!(client.next()["id"], 100);
    send(&mut client, 102, "tools/call", call("b.xml"));
    let taken_back = json!({"jsonrpc": "2.0", "method": "notifications/cancelled", "params": {"requestId": 102}});
    client.send(&taken_back.to_string());
    send(&mut client, 103, "ping", json!({}));
    send(&mut client, 104, "tools/call", call("a.xml"));
    assert_eq!(client.next()["id"], 103);
    assert_eq!(client.next()["id"], 104);
    client.end();
}
