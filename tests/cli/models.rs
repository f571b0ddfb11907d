//! `models`, and what `ask` makes of keys in files, budgets, notes and models that are gone.

use serde_json::{Value, json};

use super::CUT_IN;
use super::remote::{KEY, streamed};
use super::support::program::Home;
use super::support::server::{Script, Server};

fn row<'a>(rows: &'a [Value], model: &str) -> &'a Value {
    rows.iter()
        .find(|row| row["model"] == model)
        .unwrap_or_else(|| panic!("{model} is not in {rows:?}"))
}

#[test]
fn the_table_tells_keys_and_ends() {
    let home = Home::new();
    let config = "[provider.lab]\nbase_url = \"https://lab.example\"\nkey_command = \"pass lab\"\nmodels = [\"mine\"]\n\
                  [[provider.lab.prices]]\nmodel = \"mine\"\ninput = 1.5\noutput = 6\n";
    home.write(home.config().join("config.toml"), config);
    home.write(".env", format!("DEEPSEEK_API_KEY={KEY}\n"));
    let keys = [("OPENAI_API_KEY", KEY)];
    let ended = home.run_with(&["models", "--offline"], &keys).status(0);
    for words in [
        "reference/geometry",
        "openai/gpt-4o ",
        "missing: ANTHROPIC_API_KEY",
        "1.5, 6",
        "from `pass` ",
        "config.toml",
        "2025-07-04 [",
        "\n[1] https://",
    ] {
        assert!(ended.stdout.contains(words), "{words}: {}", ended.stdout);
    }
    assert!(!ended.stdout.contains(KEY) && !ended.stderr.contains(KEY));
    let ended = home
        .run_with(&["models", "--offline", "--format=json"], &keys)
        .status(0);
    assert!(!ended.stdout.contains(KEY));
    let document = ended.json_lines();
    let router = row(&document, "openrouter/z-ai/glm-5.3");
    assert_eq!(
        router["usd_per_million_tokens"],
        Value::Null,
        "not known is not nothing"
    );
    let gpt = row(&document, "openai/gpt-4o-mini");
    assert_eq!(
        gpt["key"],
        json!({"state": "present", "source": "OPENAI_API_KEY"})
    );
    let price = &gpt["usd_per_million_tokens"];
    assert_eq!(
        (&price["input"], &price["as_of"]),
        (&json!(0.15), &json!("2025-07-04"))
    );
    assert!(
        price["source"].as_str().unwrap().starts_with("https://"),
        "{price}"
    );
    assert_eq!(gpt["end"]["day"], "2027-01-14");
    assert_eq!(gpt["dialect"], "openai_chat");
    let key = &row(&document, "deepseek/deepseek-flash")["key"];
    let source = key["source"].as_str().unwrap();
    assert!(
        source.starts_with("DEEPSEEK_API_KEY in ") && source.ends_with(".env"),
        "{key}"
    );
    let mine = row(&document, "lab/mine");
    assert_eq!(mine["usd_per_million_tokens"]["output"], 6.0);
    assert_eq!(mine["usd_per_million_tokens"]["source"], Value::Null);
    assert_eq!(row(&document, "lmstudio/…")["key"]["state"], "not needed");
    let haiku = &row(&document, "anthropic/claude-haiku-5-5")["usd_per_million_tokens"];
    assert_eq!(haiku["up_to_input_tokens"], 100_000);
    assert_eq!(haiku["longer"]["output"], 2.5);
}

/// A small table in the form of models.dev.
fn price_table(input: f64) -> String {
    let luna = json!({"cost": {"input": input, "output": 40, "cache_read": 0.5}});
    json!({
        "openai": {"models": {"gpt-6-luna": luna, "tiny": luna, "trial": {"cost": {"input": 0, "output": 0}}}},
        "elsewhere": {"models": {"m": {"cost": {"input": 1, "output": 1}}}},
    })
    .to_string()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_price_table_overlays_the_shipped_prices_until_its_file_is_deleted() {
    let home = Home::new();
    let run = |arguments: &[&str]| tokio::task::block_in_place(|| home.run(arguments));
    let kept = home.config().join("prices.toml");
    std::fs::remove_dir_all(home.config()).unwrap();
    let today = jiff::Zoned::now().date().to_string();
    let shown = |model: &str| {
        let rows = run(&["models", "--offline", "--format=json"])
            .status(0)
            .json_lines();
        row(&rows, model)["usd_per_million_tokens"].clone()
    };
    let shipped = shown("openai/gpt-6-luna");
    home.write("api.json", price_table(10.0));
    let ended = run(&["models", "--update", "api.json"]).status(0);
    for words in [
        "api.json (models.dev)",
        "openai 2, openai-responses 2",
        "1 left out",
        "prices.toml",
        "delete the file",
    ] {
        assert!(ended.stdout.contains(words), "{words}: {}", ended.stdout);
    }
    let price = shown("openai/gpt-6-luna");
    assert_eq!(
        (&price["input"], &price["as_of"]),
        (&json!(10.0), &json!(today))
    );
    assert_eq!(price["source"], "api.json (models.dev)");
    assert_eq!(
        shown("openai/gpt-4o-mini")["as_of"],
        "2025-07-04",
        "not in the table"
    );
    let listed = run(&["models", "--offline"]).status(0).stdout;
    assert!(listed.contains("] api.json (models.dev)\n"), "{listed}");

    // A cost names the table.
    let server = Server::start(vec![streamed(&verdict())]).await;
    let ask = [
        "ask",
        CUT_IN,
        "--model",
        "openai/tiny",
        "--base-url",
        server.base_url(),
        "--format=json",
    ];
    let keys = [("OPENAI_API_KEY", KEY)];
    let document = tokio::task::block_in_place(|| home.run_with(&ask, &keys))
        .status(0)
        .json();
    let source = document["price_source"].as_str().unwrap();
    assert!(
        source.ends_with(&format!("as of {today}, api.json (models.dev)")),
        "{source}"
    );

    // What is no table changes nothing.
    let before = std::fs::read(&kept).unwrap();
    home.write("broken.json", "{\"openai\": ");
    home.write("other.json", "{\"a\": {\"b\": 1}}");
    for (file, words) in [
        ("broken.json", "not JSON"),
        ("other.json", "neither a table of models.dev"),
        ("gone.json", "gone.json"),
    ] {
        let ended = run(&["models", "--update", file]).status(2);
        ended.says(&[file, words, "no price is changed"]);
    }
    let table = price_table(20.0);
    let moved = Script::answer(302, &[("Location", "https://elsewhere.example/t.json")], "");
    let server = Server::start(vec![
        Script::json(500, "{}"),
        moved,
        Script::json(200, &table),
    ])
    .await;
    let address = format!("{}/api.json?key=geheim", server.base_url());
    let update = ["models", "--update", &address];
    run(&update)
        .status(2)
        .says(&["answered with status 500", "no price is changed"]);
    run(&update)
        .status(2)
        .says(&["moved to https://elsewhere.example/t.json"]);
    let plain = ["models", "--update", "http://prices.example/api.json"];
    run(&plain).status(2).says(&["write https://"]);
    assert_eq!(std::fs::read(&kept).unwrap(), before);
    let ended = run(&update).status(0);
    let place = format!("{}/api.json", server.base_url());
    assert!(ended.stdout.contains(&place) && !ended.stdout.contains("geheim"));
    let price = shown("openai/gpt-6-luna");
    assert_eq!(
        (&price["input"], &price["source"]),
        (&json!(20.0), &json!(place))
    );

    // A file that cannot be used is named, and so is the way back.
    std::fs::write(&kept, "as_of = 3\n").unwrap();
    let said = ["prices.toml: line 1", "--update", "delete it"];
    run(&["models", "--offline"]).status(0).says(&said);
    let doctor = run(&["doctor"]);
    assert!(
        doctor.stdout.contains("prices.toml: line 1"),
        "{}",
        doctor.stdout
    );
    let batch = [
        "evaluate",
        CUT_IN,
        "--model",
        "reference/geometry",
        "--dry-run",
    ];
    run(&batch).says(&said);
    std::fs::remove_file(&kept).unwrap();
    assert_eq!(shown("openai/gpt-6-luna"), shipped);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn servers_of_this_machine_are_listed() {
    let home = Home::new();
    let tags = json!({"models": [{"name": "qwen3:8b"}]}).to_string();
    let server = Server::start(vec![Script::json(200, &tags); 2]).await;
    let nowhere = "http://127.0.0.1:1";
    let config: String = ["local", "lmstudio", "vllm"]
        .map(|name| format!("[provider.{name}]\nbase_url = \"{nowhere}\"\n"))
        .concat();
    home.write(home.config().join("config.toml"), config);
    let host = [(
        "OLLAMA_HOST",
        server.base_url().trim_start_matches("http://"),
    )];
    let run = |arguments: &[&str]| {
        tokio::task::block_in_place(|| home.run_with(arguments, &host).status(0))
    };
    let document = run(&["models", "--format=json"]).json_lines();
    let found = row(&document, "ollama/qwen3:8b");
    assert_eq!(
        (&found["dialect"], &found["running"]),
        (&json!("ollama"), &json!(true))
    );
    assert_eq!(row(&document, "local/default")["running"], false);
    assert!(run(&["models"]).stdout.contains("running here"));
    assert_eq!(server.requests().len(), 2);
    run(&["models", "--offline"]);
    assert_eq!(server.requests().len(), 2, "no server is asked");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn names_that_are_none_are_left_out_and_told() {
    let home = Home::new();
    let names = ["x".repeat(70_000), "y".repeat(257), "z".repeat(256)];
    let models = names.clone().map(|id| json!({ "id": id }));
    let list = json!({ "data": models }).to_string();
    let server = Server::start(vec![Script::json(200, &list)]).await;
    let config = format!("[provider.lab]\nbase_url = \"{}\"\n", server.base_url());
    home.write(home.config().join("config.toml"), config);
    let ended = tokio::task::block_in_place(|| home.run(&["models"]))
        .status(0)
        .says(&["lab: 2 names of its list are left out", "256 characters"]);
    assert!(ended.stdout.contains(&format!("lab/{} ", names[2])));
    assert!(!ended.stdout.contains("yyy") && !ended.stdout.contains("xxx"));
}

#[test]
fn a_wrong_entry_or_file_is_named() {
    let home = Home::new();
    home.write(
        home.config().join(".env"),
        "OPENAI_API_KEY=x\nsk-geheim allein\n",
    );
    let ended = home
        .run(&["models", "--offline"])
        .status(0)
        .says(&[".env: line 2 is not NAME=value"]);
    assert!(!ended.stderr.contains("geheim") && ended.stdout.contains("OPENAI_API_KEY in "));
    let wrong = "[provider.lab]\nkey = \"sk-geheim\"\n";
    home.write(home.config().join("config.toml"), wrong);
    let ended = home.run(&["models", "--offline"]).status(0).says(&[
        "config.toml:2: [provider.lab]",
        "key",
        "disabled",
    ]);
    assert!(!ended.stderr.contains("geheim"), "{}", ended.stderr);
}

fn verdict() -> String {
    json!({
        "collision": false,
        "obstacles": [{"id": 301, "risk_score": 3, "reason": "far"}],
        "justification": "It stays away.",
    })
    .to_string()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_server_of_another_dialect_is_asked_in_it() {
    let home = Home::new();
    let lines = [
        json!({"model": "tiny", "message": {"thinking": "far away", "content": ""}, "done": false}),
        json!({"model": "tiny", "message": {"content": verdict()}, "done": false}),
        json!({"done": true, "done_reason": "stop", "prompt_eval_count": 9000, "eval_count": 30}),
    ];
    let text: String = lines.iter().map(|line| format!("{line}\n")).collect();
    let server = Server::start(vec![Script::lines().send(text)]).await;
    let url = server.base_url();
    let arguments = [
        "ask",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--base-url",
        url,
        "--set=dialect=ollama",
        "--format=json",
    ];
    let document = tokio::task::block_in_place(|| home.run(&arguments))
        .status(0)
        .json();
    assert_eq!(document["verdict"]["collision"], false);
    assert_eq!(server.requests()[0].path, "/api/chat");
    let run = &home.runs()[0];
    assert_eq!(run["reasoning"].as_deref(), Some("far away"));
    assert_eq!(run["input_tokens"].as_deref(), Some("9000"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_key_in_a_file_is_used_and_shows_nowhere() {
    let home = Home::new();
    let server = Server::start(vec![streamed(&verdict())]).await;
    let config = format!(
        "[provider.house]\nbase_url = \"{}\"\nkey_env = [\"OTHER\", \"HOUSE_KEY\"]\n",
        server.base_url()
    );
    home.write(home.config().join("config.toml"), config);
    let file = home.write(".env", format!("HOUSE_KEY='{KEY}'\n"));
    let arguments = ["ask", CUT_IN, "--model", "house/big", "--format=json"];
    let ended = tokio::task::block_in_place(|| home.run(&arguments)).status(0);
    assert!(!ended.stdout.contains(KEY) && !ended.stderr.contains(KEY));
    // A file that came with downloaded scenarios would lead questions to a stranger's account.
    let told = "nearmiss: house: asked with the key HOUSE_KEY in ./.env";
    let ended = ended.says(&[told]);
    assert_eq!(ended.stderr.matches(told).count(), 1);
    assert_eq!(
        home.files_with(KEY),
        [file],
        "the key is where the user put it, and nowhere else"
    );
    let bearer = format!("Bearer {KEY}");
    assert_eq!(
        server.requests()[0].header("authorization"),
        Some(bearer.as_str())
    );
    let batch = [
        "evaluate",
        CUT_IN,
        "--model",
        "house/big,house/small",
        "--dry-run",
    ];
    let ended = tokio::task::block_in_place(|| home.run(&batch)).says(&[told]);
    assert_eq!(ended.stderr.matches(told).count(), 1, "{}", ended.stderr);
    std::fs::rename(home.files().join(".env"), home.config().join(".env")).unwrap();
    let ended = tokio::task::block_in_place(|| home.run(&arguments)).status(0);
    assert!(
        !ended.stderr.contains("asked with the key"),
        "{}",
        ended.stderr
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_address_in_a_file_is_not_believed() {
    let home = Home::new();
    let server = Server::start(vec![streamed(&verdict())]).await;
    // As it may come with a folder of scenarios.
    home.write(
        ".env",
        format!("NEARMISS_LOCAL_URL={}\n", server.base_url()),
    );
    let config = "[provider.local]\nbase_url = \"http://127.0.0.1:1\"\nbase_url_env = \"NEARMISS_LOCAL_URL\"\n";
    home.write(home.config().join("config.toml"), config);
    let arguments = ["ask", CUT_IN, "--model", "local/default"];
    tokio::task::block_in_place(|| home.run(&arguments)).status(1);
    assert!(server.requests().is_empty());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_budget_needs_a_price_and_a_limit_and_is_kept() {
    let home = Home::new();
    let server = Server::start(vec![streamed(&verdict())]).await;
    let prices = "[[provider.lab.prices]]\nmodel = \"tiny\"\ninput = 100\noutput = 1000\n";
    let entry = format!("[provider.lab]\nbase_url = \"{}\"\n", server.base_url());
    let ask = |config: &str, more: &[&str]| {
        home.write(home.config().join("config.toml"), config);
        let arguments = [&["ask", CUT_IN, "--model", "lab/tiny"], more].concat();
        tokio::task::block_in_place(|| home.run(&arguments))
    };
    let limit = ["--budget", "0.5", "--set=max_tokens=100"];
    // A server here that wants a key may forward to one that is paid.
    let forwarding = format!("{entry}key_command = \"echo key\"\n");
    ask(&forwarding, &limit)
        .status(2)
        .says(&["none is known for tiny", "config.toml"]);
    let entry = entry + prices;
    ask(&entry, &["--budget", "0.5"])
        .status(2)
        .says(&["set max_tokens"]);
    ask(&entry, &["--budget", "-1"])
        .status(2)
        .says(&["positive"]);
    let ended = ask(&entry, &["--budget", "0.05", "--set=max_tokens=100"]).status(2);
    ended.says(&["was not asked", "budget"]);
    // Nothing was sent, and a dry run says so beforehand.
    let dry = ask(
        &entry,
        &["--budget", "0.05", "--set=max_tokens=100", "--dry-run"],
    )
    .status(2);
    dry.says(&[
        "would not be asked: it may cost $",
        "more than the budget of $0.0500",
    ]);
    ask(&entry, &["--budget", "5", "--dry-run"])
        .status(2)
        .says(&["would not be asked: a budget needs a limit"]);
    assert!(server.requests().is_empty(), "nothing was sent");
    let ended = ask(&entry, &["--budget", "5", "--set=max_tokens=100"]).status(0);
    assert!(
        ended.stdout.contains("cost          0.954000 USD"),
        "{}",
        ended.stdout
    );
    let runs = home.runs();
    let costs: Vec<_> = runs.iter().map(|run| run["cost_usd"].as_deref()).collect();
    assert_eq!(costs, [Some("0.954")], "what was refused is no run");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_budget_of_the_configuration_holds_unless_the_option_says_another() {
    let home = Home::new();
    let server = Server::start(vec![streamed(&verdict())]).await;
    let lab = format!("[provider.lab]\nbase_url = \"{}\"\n", server.base_url());
    let prices = "[[provider.lab.prices]]\nmodel = \"tiny\"\ninput = 100\noutput = 1000\n";
    let ask = |config: &str, more: &[&str]| {
        home.write(home.config().join("config.toml"), config);
        let arguments = [&["ask", CUT_IN, "--model", "lab/tiny"], more].concat();
        tokio::task::block_in_place(|| home.run(&arguments))
    };
    let said = "config.toml:2: budget = 0.05; --budget USD";
    let little = format!("mouse = true\nbudget = 0.05\n{lab}");
    let forwarding = format!("{little}key_command = \"echo key\"\n");
    ask(&forwarding, &["--set=max_tokens=100"])
        .status(2)
        .says(&["none is known for tiny", said]);
    let little = little + prices;
    ask(&little, &[])
        .status(2)
        .says(&["set max_tokens", said, "--set max_tokens=N"]);
    ask(&little, &["--set=max_tokens=100"])
        .status(2)
        .says(&["raise the budget", said]);
    let ended = ask(&little, &["--set=max_tokens=100", "--budget", "0.04"])
        .status(2)
        .says(&["budget of $0.0400"]);
    assert!(!ended.stderr.contains("config.toml:2"), "{}", ended.stderr);
    assert!(server.requests().is_empty(), "nothing was sent");
    ask(&little, &["--set=max_tokens=100", "--budget", "5"]).status(0);
    assert_eq!((server.requests().len(), home.runs().len()), (1, 1));
    // The built-in judge costs nothing.
    let built_in = ["ask", CUT_IN, "--model", "reference/geometry"];
    tokio::task::block_in_place(|| home.run(&built_in)).status(0);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_a_model_does_not_take_is_said() {
    let home = Home::new();
    let server = Server::start(vec![streamed(&verdict())]).await;
    let config = format!(
        "effort = \"high\"\n[provider.openai]\nbase_url = \"{}\"\nmodels = [{{name = \"old\", shutdown = 2020-01-01}}]\nquirks = {{seed = false, efforts = \"untaken\"}}\n",
        server.base_url()
    );
    home.write(home.config().join("config.toml"), config);
    let arguments = [
        "ask",
        CUT_IN,
        "--model",
        "openai/old",
        "--set=seed=4",
        "--format=json",
    ];
    let ended = tokio::task::block_in_place(|| home.run(&arguments)).status(0);
    ended.says(&[
        "seed is not sent",
        "effort is not sent",
        "shut down since 2020-01-01",
    ]);
    let body = server.requests()[0].json();
    assert_eq!(
        (body.get("seed"), body.get("reasoning_effort")),
        (None, None)
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_schema_is_asked_for_with_and_without_a_chain_of_thought() {
    let home = Home::new();
    let server = Server::start(vec![streamed(&verdict()), streamed(&verdict())]).await;
    let config = format!(
        "[provider.lab]\nbase_url = \"{}\"\nresponse_format = \"json_schema\"\n",
        server.base_url()
    );
    home.write(home.config().join("config.toml"), config);
    for techniques in ["cp", "cot"] {
        let arguments = [
            "ask",
            CUT_IN,
            "--model",
            "lab/tiny",
            "--techniques",
            techniques,
        ];
        tokio::task::block_in_place(|| home.run(&arguments)).status(0);
    }
    let formats: Vec<_> = server
        .requests()
        .iter()
        .map(|sent| sent.json().pointer("/response_format/type").cloned())
        .collect();
    assert_eq!(
        formats,
        [Some(json!("json_schema")), Some(json!("json_schema"))]
    );
}

#[test]
fn the_configuration_in_the_manual_is_right() {
    let home = Home::new();
    let manual = nearmiss::docs::topic("configuration").unwrap().text;
    let (_, block) = manual.split_once("```toml\n").unwrap();
    let (block, _) = block.split_once("```").unwrap();
    home.write(home.config().join("config.toml"), block);
    let document = home
        .run(&["models", "--offline", "--format=json"])
        .status(0)
        .json_lines();
    let mine = row(&document, "lab/my-model");
    assert_eq!(mine["usd_per_million_tokens"]["cached"], 0.05);
}
