//! `doctor` and `config print`: what is in order, what is not, and never a key.

use serde_json::Value;

use super::support::program::Home;

fn findings(stdout: &str) -> Vec<(String, String, String)> {
    let document: Value = serde_json::from_str(stdout).unwrap();
    let text = |finding: &Value, key: &str| finding[key].as_str().unwrap().to_string();
    let all = document["findings"].as_array().unwrap().iter();
    all.map(|f| (text(f, "area"), text(f, "state"), text(f, "what")))
        .collect()
}

#[test]
fn a_fresh_home_has_no_problems_and_nothing_is_made() {
    let home = Home::new();
    let ended = home.run(&["doctor"]).status(0);
    for words in [
        "nearmiss 0.",
        "comes from a build and is not installed",
        "reference/geometry",
        "runs.sqlite yet",
        "the default keys",
        "OSC 52",
    ] {
        assert!(ended.stdout.contains(words), "{words}: {}", ended.stdout);
    }
    for line in ended.stdout.lines() {
        let word = line.split_whitespace().next();
        assert!(matches!(word, Some("ok" | "warning")), "{line}");
    }
    assert_eq!(std::fs::read_dir(home.data()).unwrap().count(), 0);
    let json = home.run(&["doctor", "--format=json"]).status(0);
    assert!(findings(&json.stdout).len() > 10);
    assert!(json.stdout.contains("\"installed\":\"build\""));
}

#[test]
fn planners_whose_program_is_missing_are_problems() {
    let home = Home::new();
    home.write(
        home.config().join("config.toml"),
        "[planner.lab]\ncommand = \"cargo --version\"\n[planner.gone]\ncommand = \"no-such-planner --fast\"\n",
    );
    let found = findings(&home.run(&["doctor", "--format=json"]).status(1).stdout);
    let of = |name: &str| {
        let mut all = found.iter().filter(|(area, ..)| area == "planners");
        all.find(|(.., what)| what.starts_with(name))
            .map(|(_, state, what)| (state.as_str(), what.as_str()))
    };
    let ok = "lab: cargo --version; `nearmiss plan SCENARIO --planner lab` starts it";
    assert_eq!(of("lab"), Some(("ok", ok)));
    let missing = "gone: no program no-such-planner";
    assert_eq!(of("gone"), Some(("problem", missing)));
}

#[test]
fn every_broken_file_is_a_problem_and_is_named() {
    let home = Home::new();
    let config = home.config();
    home.write(
        config.join("keymap.toml"),
        "[global]\nplay = \"hyper\"\nfly = \"x\"\n",
    );
    home.write(config.join("config.toml"), "mouse = 3\n");
    home.write(config.join("thresholds.toml"), "[nothing]\nx = 1\n");
    home.write(
        config.join("themes/mine.toml"),
        "dark = true\n[roles]\ntext = \"blurple\"\n",
    );
    home.write(config.join("prompts/mine.md"), "no front matter");
    home.write(config.join(".env"), "this is sk-not-shown no line\n");
    home.write(
        home.data().join("runs.sqlite"),
        "this is no database at all, only some words in a file",
    );
    home.write(home.data().join("tags.toml"), "a = 3\n");
    let ended = home.run(&["doctor"]).status(1);
    for words in [
        "keymap.toml:2: global.play",
        "keymap.toml:3: unknown action `global.fly`",
        "config.toml:1",
        "thresholds.toml",
        "mine.toml:3: roles.text",
        "mine.md",
        "line 1 is not NAME=value",
        "runs.sqlite",
        "tags.toml",
    ] {
        let named = ended
            .stdout
            .lines()
            .any(|l| l.starts_with("problem ") && l.contains(words));
        assert!(named, "{words}: {}", ended.stdout);
    }
    assert!(!ended.stdout.contains("sk-not-shown"));
    assert!(ended.stderr.contains("problems"), "{}", ended.stderr);
    let json = home.run(&["doctor", "--format=json"]).status(1);
    let problems = findings(&json.stdout);
    assert!(
        problems
            .iter()
            .filter(|(_, state, _)| state == "problem")
            .count()
            >= 9
    );
}

#[test]
fn keys_are_named_by_their_variables_alone() {
    let home = Home::new();
    let text = "model = \"lab/small\"\n\n[provider.lab]\nbase_url = \"http://me:hunter22@127.0.0.1:9/v1?key=topsecret\"\n\
                key_env = \"LAB_KEY\"\nattempts = 1\n[provider.other]\nbase_url = \"https://other.example\"\n\
                key_command = [\"pass\", \"arg-secret\"]\n";
    home.write(home.config().join("config.toml"), text);
    let run = |arguments: &[&str]| {
        let mut command = home.command();
        command.args(arguments).env("LAB_KEY", "sk-verysecret");
        let output = command.output().unwrap();
        String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap()
    };
    for arguments in [
        &["doctor"][..],
        &["doctor", "--format=json"],
        &["config", "print"],
    ] {
        let said = run(arguments);
        assert!(said.contains("LAB_KEY"), "{said}");
        for secret in ["verysecret", "hunter22", "topsecret", "arg-secret"] {
            assert!(!said.contains(secret), "{secret}: {said}");
        }
    }
    assert!(
        run(&["doctor"]).contains("nothing runs there"),
        "port 9 is closed"
    );
}

#[test]
fn the_printed_configuration_is_one_and_says_where_it_is_from() {
    let home = Home::new();
    let text = "# mine\nmouse = false\n[provider.lab]\nbase_url = \"http://127.0.0.1:9\"\nattempts = 2\n\
                header_env = { X-Team = \"LAB_TEAM\" }\n";
    let path = home.write(home.config().join("config.toml"), text);
    let mut command = home.command();
    command
        .args(["config", "print"])
        .env("OPENAI_BASE_URL", "http://127.0.0.1:7/v1");
    let output = command.output().unwrap();
    assert!(output.status.success());
    let said = String::from_utf8(output.stdout).unwrap();
    let shown = path.display();
    for line in [
        format!("mouse = false  # {shown}:2"),
        "session = true  # default".into(),
        format!("attempts = 2  # {shown}:5"),
        "# NEARMISS_CONFIG".into(),
    ] {
        assert!(said.contains(&line), "{line}: {said}");
    }
    let from_variable =
        |line: &str| line.contains("127.0.0.1:7") && line.ends_with("# OPENAI_BASE_URL");
    assert!(said.lines().any(from_variable), "{said}");
    // What is printed can be used, and says the same.
    let parsed: toml::Table = said.parse().unwrap();
    assert_eq!(parsed["mouse"].as_bool(), Some(false));
    home.write(home.config().join("config.toml"), &said);
    let again = home.run(&["config", "print"]).status(0);
    assert!(again.stdout.contains("mouse = false"), "{}", again.stdout);
}

#[test]
fn every_mistake_of_the_configuration_is_named() {
    let home = Home::new();
    let text = "radius = \"lots\"\nmouse = true\nbudgett = 3\nhistory = 0\n";
    home.write(home.config().join("config.toml"), text);
    let said = [
        "config.toml:1: radius = \"lots\": expected a number",
        "config.toml:3: unknown key `budgett`; did you mean `budget`?",
        "config.toml:4: history = 0: expected a whole number from 1 to 100000",
    ];
    home.run(&["config", "print"]).status(2).says(&said);
    let ended = home
        .run(&["prompt", "describe", "ZAM_CutIn-1_1_T-1"])
        .status(2);
    assert!(!ended.says(&said).stderr.contains("using the defaults"));
    let doctor = home.run(&["doctor"]).status(1);
    for words in said {
        assert!(doctor.stdout.contains(words), "{words}: {}", doctor.stdout);
    }
}

#[cfg(unix)]
#[test]
fn files_that_others_can_change_or_read_are_told() {
    use std::os::unix::fs::PermissionsExt;
    let home = Home::new();
    let config = home.write(home.config().join("config.toml"), "mouse = false\n");
    let here = home.write(".env", "LAB_KEY=x\n");
    let open = |path: &std::path::Path, mode: u32| {
        let mode = std::fs::Permissions::from_mode(mode);
        std::fs::set_permissions(path, mode).unwrap();
    };
    let root = home.config().parent().unwrap().to_path_buf();
    for (path, mode) in [
        (&root, 0o755),
        (&home.config(), 0o777),
        (&home.files(), 0o755),
        (&config, 0o666),
        (&here, 0o644),
    ] {
        open(path, mode);
    }
    let said = home.run(&["doctor"]).status(0).stdout;
    let warned = |words: &str| {
        let line = said.lines().find(|line| line.contains(words));
        assert!(
            line.is_some_and(|l| l.starts_with("warning")),
            "{words}: {said}"
        );
    };
    warned("config.toml: other users can change it");
    warned("`chmod go-w ");
    warned(".env: other users can read the keys in it; close it with `chmod 600 .env`");
    let told = [
        "config.toml: other users can change it",
        ".env: other users can read",
    ];
    home.run(&["config", "print"]).status(0).says(&told);
    open(&home.config(), 0o700);
    open(&here, 0o600);
    let quiet = home.run(&["doctor"]).status(0).stdout;
    assert!(!quiet.contains("other users"), "{quiet}");
    assert_eq!(home.run(&["config", "print"]).status(0).stderr, "");
}
