//! `prompt`: the messages as they would be sent, and the user's own templates.

use super::CUT_IN;
use super::support::program::Home;

#[test]
fn techniques_change_the_text() {
    let home = Home::new();
    for frame in ["ego", "cartesian", "metrics"] {
        for task in ["collision", "safety"] {
            let prompt = |techniques: &str| {
                let arguments = [
                    "prompt",
                    "show",
                    CUT_IN,
                    "--task",
                    task,
                    "--frame",
                    frame,
                    "--techniques",
                    techniques,
                ];
                home.run(&arguments).status(0).stdout
            };
            let mut texts: Vec<_> = ["base", "cp", "cot", "icl", "cp,cot", "all"]
                .map(&prompt)
                .into();
            assert_eq!(prompt("all"), prompt("cp,cot,icl"));
            assert!(texts[0].len() < texts[5].len(), "{task} {frame}");
            for text in &texts {
                assert!(
                    text.contains("[system]\n") && text.contains("\n[user]\n"),
                    "{text}"
                );
                assert!(!text.contains("{{") && !text.contains("{%"), "{text}");
            }
            texts.sort();
            texts.dedup();
            assert_eq!(
                texts.len(),
                6,
                "{task} {frame}: every choice of techniques has its text"
            );
        }
    }
}

#[test]
fn a_pack_and_the_options_of_frames_are_chosen_on_the_command_line() {
    let home = Home::new();
    let run = |arguments: &[&str]| home.run(&[&["prompt", "show", CUT_IN], arguments].concat());
    let paper = run(&["--set=pack=paper"]).status(0).stdout;
    for words in ["TTC", "MDC", "Laterally aligned", "IsCollisionScenario"] {
        assert!(paper.contains(words), "{words}: {paper}");
    }
    assert!(!paper.contains("critical_obstacles"), "{paper}");
    let paper = run(&[
        "--set=pack=paper",
        "--task",
        "safety",
        "--frame",
        "cartesian",
    ])
    .status(0)
    .stdout;
    assert!(paper.contains("HighRiskObstacle") && paper.contains("left border"));
    let none = run(&["--set=pack=paper", "--task", "attacker"]).status(2);
    assert!(none.stderr.contains("of the pack paper"), "{}", none.stderr);
    let chosen = run(&[
        "--frame",
        "metrics",
        "--set=measures=thw,btn",
        "--techniques",
        "cp",
    ])
    .status(0)
    .stdout;
    assert!(
        chosen.contains("- btn: brake-threat number; high values"),
        "{chosen}"
    );
    assert!(
        chosen.contains(",thw [s],btn\n") && !chosen.contains("- time gap:"),
        "{chosen}"
    );
    let lane = run(&["--set=axes=lane"]).status(0).stdout;
    assert!(
        lane.contains("- s and d: ") && lane.contains(",s [m],d [m],"),
        "{lane}"
    );
    // From centre to centre nothing says whether bodies touch: 5.88 m are free between 4.51 m and 4.30 m in one line.
    let centre = run(&[
        "--task",
        "safety",
        "--set=axes=centre",
        "--techniques",
        "base",
    ])
    .status(0)
    .stdout;
    assert!(
        centre.contains("- the place of its centre as seen"),
        "{centre}"
    );
    let (_, told) = centre.split_once("[user]").unwrap();
    assert!(
        !told.contains("distance") && !told.contains("gap"),
        "{told}"
    );
    let near = told.lines().rfind(|line| line.starts_with("0.00,car 301,"));
    let cells: Vec<&str> = near.unwrap().split(',').collect();
    let titles = told
        .lines()
        .find(|line| line.starts_with("t [s],"))
        .unwrap();
    let at = titles
        .split(',')
        .position(|title| title == "centre long [m]")
        .unwrap();
    let long: f64 = cells[at].parse().unwrap();
    assert!((long - (5.88 + (4.51 + 4.30) / 2.0)).abs() < 0.02, "{told}");
    let wrong = run(&["--set=measures=ttc"]).status(2);
    assert!(
        wrong.stderr.contains("option of the metrics frame"),
        "{}",
        wrong.stderr
    );
    let wrong = run(&["--frame", "metrics", "--set=measures=darc"]).status(2);
    assert!(
        wrong.stderr.contains("did you mean `drac`"),
        "{}",
        wrong.stderr
    );
}

#[test]
fn messages_are_printed_as_json() {
    let home = Home::new();
    let document = home
        .run(&["prompt", "show", CUT_IN, "--format=json"])
        .status(0)
        .json();
    let messages = document["messages"].as_array().unwrap();
    let roles: Vec<_> = messages
        .iter()
        .map(|m| m["role"].as_str().unwrap())
        .collect();
    assert_eq!(roles, ["system", "user"]);
    let text = home.run(&["prompt", "show", CUT_IN]).status(0).stdout;
    for message in messages {
        assert!(text.contains(message["content"].as_str().unwrap()));
    }
}

#[test]
fn a_prompt_holds_the_description_and_no_answer() {
    let home = Home::new();
    let text = home
        .run(&["prompt", "show", CUT_IN, "--frame", "ego"])
        .status(0)
        .stdout;
    let description = home
        .run(&["prompt", "describe", CUT_IN, "--frame", "ego"])
        .status(0)
        .stdout;
    assert!(text.contains(description.trim()));
    assert!(
        !text.contains("overlaps the ego's"),
        "the built-in judge's words are not given away"
    );
}

const MINE: &str = "+++\nname = \"mine\"\nversion = \"7\"\ntask = \"collision\"\nframe = \"ego\"\n+++\n\
    {% block system %}Be mine.{% endblock %}{% block user %}In {{ scenario }}: {{ description }}{% endblock %}\n";

#[test]
fn the_users_template_overrides_the_shipped_one() {
    let home = Home::new();
    home.write(home.config().join("prompts/collision-ego.md"), MINE);
    let ended = home
        .run(&["prompt", "show", CUT_IN])
        .status(0)
        .says(&["collision-ego.md"]);
    assert!(
        ended
            .stdout
            .contains("[system]\nBe mine.\n\n[user]\nIn ZAM_CutIn"),
        "{}",
        ended.stdout
    );
    let other = home
        .run(&["prompt", "show", CUT_IN, "--frame", "cartesian"])
        .status(0)
        .stdout;
    assert!(!other.contains("Be mine."));
}

#[test]
fn nothing_is_sent_in_place_of_a_broken_template() {
    let home = Home::new();
    home.write(
        home.config().join("prompts/collision-ego.md"),
        "no front matter",
    );
    let stops = ["collision-ego.md", "line 1", "nothing is sent in its place"];
    for command in [
        &["prompt", "show", CUT_IN][..],
        &[
            "ask",
            CUT_IN,
            "--model",
            "lab/m",
            "--base-url",
            "http://127.0.0.1:9",
        ],
        &["ask", CUT_IN, "--dry-run"],
        &[
            "evaluate",
            CUT_IN,
            "--model",
            "lab/m",
            "--set",
            "base_url=http://127.0.0.1:9",
        ],
    ] {
        let ended = home.run(command).status(2);
        assert_eq!(ended.stdout, "");
        ended.says(&stops);
    }
    assert_eq!(home.runs().len(), 0);
    // It is no part of other questions.
    home.run(&["prompt", "show", CUT_IN, "--frame", "cartesian"])
        .status(0);
    home.run(&["prompt", "describe", CUT_IN]).status(0);
}

#[test]
fn a_template_that_cannot_be_filled_is_named_with_its_line() {
    let home = Home::new();
    let wrong = MINE.replace("{{ scenario }}", "\n{{ nothing_of_this_name }}");
    home.write(home.config().join("prompts/collision-ego.md"), wrong);
    home.run(&["prompt", "show", CUT_IN]).status(2).says(&[
        "prompts/collision-ego.md: line 8: ",
        "nothing is sent in its place",
    ]);
}

#[test]
fn every_frame_is_described_in_both_forms_and_traced() {
    let home = Home::new();
    for frame in ["ego", "cartesian", "metrics", "trajectory"] {
        let mut lengths = Vec::new();
        for form in ["prose", "compact"] {
            let form = format!("--set=form={form}");
            let mut arguments = vec![
                "prompt",
                "describe",
                CUT_IN,
                "--frame",
                frame,
                &form,
                "--set=stride=3",
            ];
            arguments.extend(["--set=precision=3", "--history", "20", "--obstacle", "301"]);
            let ended = home.run(&arguments).status(0).says(&["tokens (estimated)"]);
            lengths.push(ended.stdout.len());
            arguments.push("--format=json");
            let traced = home.run(&arguments).status(0).json();
            let text = traced["text"].as_str().unwrap();
            assert_eq!(text, ended.stdout);
            let spans = traced["spans"].as_array().unwrap();
            let mut distances = 0;
            for span in spans {
                let at = |key: &str| span[key].as_u64().unwrap() as usize;
                let written: f64 = text[at("start")..at("end")].parse().unwrap();
                let value = span["value"].as_f64().unwrap();
                let degrees = span["quantity"] == "heading_rel";
                let half = if degrees { 0.051 } else { 0.0051 };
                assert!((written - value).abs() <= half, "{span}");
                if span["of"] == "obstacle" {
                    assert_eq!(span["id"], 301);
                    distances += usize::from(span["step"].is_i64());
                }
            }
            assert!(distances > 20, "{frame} {form}");
        }
        assert!(lengths[1] < lengths[0], "{frame}: {lengths:?}");
    }
}

#[test]
fn what_cannot_be_described_is_said_with_advice() {
    let home = Home::new();
    home.run(&["prompt", "describe", CUT_IN, "--frame", "trajectory"])
        .status(2)
        .says(&["--obstacle ID"]);
    home.run(&["prompt", "describe", CUT_IN, "--obstacle", "77"])
        .status(2)
        .says(&["77", "301"]);
    home.run(&["prompt", "describe", CUT_IN, "--frame", "polar"])
        .status(2)
        .says(&["cartesian, metrics, trajectory"]);
    home.run(&["prompt", "describe", CUT_IN, "--set=stride=0"])
        .status(2);
    home.run(&["prompt", "describe", CUT_IN, "--set=precision=10"])
        .status(2);
    home.run(&["prompt", "describe", CUT_IN, "--set=form=verse"])
        .status(2)
        .says(&["unknown form `verse`; available: prose, compact"]);
}

#[test]
fn a_templates_defaults_hold_until_the_user_says_otherwise() {
    let home = Home::new();
    let with = MINE.replace(
        "frame = \"ego\"\n",
        "frame = \"ego\"\n[defaults]\nhistory = 4\nstride = 2\nprecision = 1\ntechniques = \"cp\"\n",
    ).replace(
        "Be mine.",
        "Be mine.{% if cp %} CP{% endif %}{% if cot %} COT{% endif %}",
    );
    home.write(home.config().join("prompts/collision-ego.md"), with);
    let prompt = |more: &[&str]| {
        let arguments = [&["prompt", "show", CUT_IN][..], more].concat();
        home.run(&arguments).status(0).stdout
    };
    let steps = |text: &str| text.matches(",ego,").count();
    let text = prompt(&[]);
    assert!(
        text.contains("Be mine. CP\n") && steps(&text) == 2,
        "{text}"
    );
    assert!(text.contains("4.5 m long"), "{text}");
    let text = prompt(&["--history", "6", "--set=stride=1", "--techniques", "cot"]);
    assert!(
        text.contains("Be mine. COT\n") && steps(&text) == 6,
        "{text}"
    );
    home.write(home.config().join("config.toml"), "history = 8\n");
    assert_eq!(
        steps(&prompt(&[])),
        4,
        "the configuration is the user's word"
    );
}

#[test]
fn front_matter_with_an_unknown_key_is_named_with_its_line() {
    let home = Home::new();
    let wrong = MINE.replace("frame = \"ego\"\n", "frame = \"ego\"\nfrmae = \"ego\"\n");
    home.write(home.config().join("prompts/collision-ego.md"), wrong);
    home.run(&["prompt", "show", CUT_IN]).status(2).says(&[
        "collision-ego.md: line 6",
        "frmae",
        "nothing is sent in its place",
    ]);
}

#[test]
fn templates_are_listed_with_where_they_come_from() {
    let home = Home::new();
    let listed = home.run(&["prompt", "list"]).status(0).stdout;
    for file in [
        "collision-ego.md",
        "safety-metrics.md",
        "attacker-metrics.md",
        "trajectory.md",
        "_risk.md",
    ] {
        let line = listed.lines().find(|l| l.starts_with(file)).unwrap();
        assert!(line.ends_with("shipped"), "{line}");
    }
    let row = |name: &str| {
        let rows = home.run(&["prompt", "list", "--format=json"]).json_lines();
        rows.into_iter().find(|r| r["template"] == name).unwrap()
    };
    let before = row("collision-ego.md");
    assert_eq!(
        (&before["task"], &before["frame"]),
        (&"collision".into(), &"ego".into())
    );
    let hash = before["template_hash"].as_str().unwrap().to_string();
    assert_eq!(hash.len(), 64);
    // The same hash is told and kept with a prompt.
    home.run(&["prompt", "show", CUT_IN])
        .status(0)
        .says(&[&hash[..12]]);
    // A fragment of one's own changes the hash of what includes it.
    home.write(
        home.config().join("prompts/_risk.md"),
        "My own view of risk.",
    );
    assert_ne!(
        row("collision-ego.md")["template_hash"],
        before["template_hash"]
    );
    let listed = home.run(&["prompt", "list"]).status(0).stdout;
    let line = listed.lines().find(|l| l.starts_with("_risk.md")).unwrap();
    assert!(line.ends_with("prompts/_risk.md"), "{line}");
}

#[test]
fn templates_are_shown_copied_and_compared() {
    let home = Home::new();
    let folder = home.config().join("prompts").display().to_string();
    home.run(&["prompt", "list"]).status(0).says(&[&folder]);
    let shown = home
        .run(&["prompt", "text", "collision-ego"])
        .status(0)
        .stdout;
    assert!(shown.starts_with("+++\nname = \"collision-ego\""));
    home.run(&["prompt", "diff", "collision-ego"])
        .status(0)
        .says(&["the shipped collision-ego.md is in use"]);
    let copied = home
        .run(&["prompt", "copy", "collision-ego"])
        .status(0)
        .stdout;
    let path = home.config().join("prompts/collision-ego.md");
    assert_eq!(std::path::Path::new(copied.trim()), path);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), shown);
    std::fs::write(&path, shown.replace("You are an expert", "You are a poet")).unwrap();
    home.run(&["prompt", "copy", "collision-ego"])
        .status(2)
        .says(&["exists; nothing was written"]);
    assert!(std::fs::read_to_string(&path).unwrap().contains("a poet"));
    let diff = home
        .run(&["prompt", "diff", "collision-ego.md"])
        .status(0)
        .stdout;
    assert!(
        diff.contains("--- shipped/collision-ego.md\n+++ "),
        "{diff}"
    );
    assert!(
        diff.contains("\n-You are an expert") && diff.contains("\n+You are a poet"),
        "{diff}"
    );
    home.run(&["prompt", "text", "nothing"])
        .status(2)
        .says(&["unknown template `nothing`", "collision-ego.md"]);
}

#[test]
fn what_is_wrong_with_a_users_template_is_listed() {
    let home = Home::new();
    let prompts = home.config().join("prompts");
    let wrong = MINE.replace("{{ scenario }}", "\n{{ nothing_of_this_name }}");
    home.write(prompts.join("collision-ego.md"), wrong);
    home.write(prompts.join("safety-ego.md"), "no front matter");
    home.write(
        prompts.join("mine.md"),
        MINE.replace("\"collision\"", "\"colision\""),
    );
    home.run(&["prompt", "list"]).status(1).says(&[
        "collision-ego.md: line 8: undefined value: `nothing_of_this_name` is undefined",
        "nothing is sent in its place",
        "safety-ego.md: line 1",
        "unknown task `colision`",
        "3 of your templates",
    ]);
    let table = home.run(&["prompt", "list"]).status(1).stdout;
    let rows = |file: &str, used: &str| {
        let words = |l: &str| l.split_whitespace().map(String::from).collect::<Vec<_>>();
        let rows = table.lines().map(words);
        rows.filter(|r| r[0] == file && r[3] == used).count()
    };
    for file in ["collision-ego.md", "safety-ego.md"] {
        assert_eq!((rows(file, "yes"), rows(file, "broken")), (1, 1), "{table}");
    }
    assert_eq!(rows("mine.md", "broken"), 1, "{table}");
    home.run(&["prompt", "show", CUT_IN])
        .status(2)
        .says(&["prompts/collision-ego.md: line 8"]);
    home.run(&["prompt", "use", "mine"]).status(2).says(&[
        "mine.md",
        "unknown task `colision`",
        "the file is not used",
    ]);
    // What differs in a broken file can be seen too.
    let diff = home.run(&["prompt", "diff", "safety-ego"]).status(0).stdout;
    assert!(diff.contains("+no front matter"), "{diff}");
}

#[test]
fn several_templates_for_the_same_live_side_by_side() {
    let home = Home::new();
    let used = |file: &str| {
        let rows = home.run(&["prompt", "list", "--format=json"]).json_lines();
        let row = rows.into_iter().find(|r| r["template"] == file).unwrap();
        row["in_use"].as_bool().unwrap()
    };
    let copied = home
        .run(&["prompt", "copy", "collision-ego", "--as", "short"])
        .status(0)
        .stdout;
    let path = home.config().join("prompts/short.md");
    assert_eq!(std::path::Path::new(copied.trim()), path);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("name = \"short\""));
    std::fs::write(&path, text.replace("You are an expert", "You are brief")).unwrap();
    home.run(&["prompt", "use", "collision-ego"])
        .status(0)
        .says(&["collision-ego.md is now used for task collision"]);
    assert!(used("collision-ego.md") && !used("short.md"));
    home.run(&["prompt", "use", "short"]).status(0);
    assert!(used("short.md"));
    let prompt = home.run(&["prompt", "show", CUT_IN]).status(0).stdout;
    assert!(prompt.contains("You are brief"));
    for (arguments, said) in [
        (&["prompt", "use", "_risk"][..], "fragment"),
        (&["prompt", "use", "gone"], "unknown template"),
        (
            &["prompt", "copy", "safety-ego", "--as", "../x"],
            "invalid template name",
        ),
        (
            &["prompt", "copy", "safety-ego", "--as", "collision-ego"],
            "is the name of a shipped template",
        ),
        (
            &["prompt", "copy", "safety-ego", "--as", "short"],
            "exists; nothing was written",
        ),
    ] {
        home.run(arguments).status(2).says(&[said]);
    }
    std::fs::remove_file(&path).unwrap();
    let listed = home.run(&["prompt", "list"]).status(1);
    listed.says(&[
        "chosen.toml",
        "no template short.md",
        "nothing is sent in its place",
    ]);
    home.run(&["prompt", "show", CUT_IN]).status(2);
    home.run(&["prompt", "use", "collision-ego"]).status(0);
    let prompt = home.run(&["prompt", "show", CUT_IN]).status(0).stdout;
    assert!(prompt.contains("You are an expert"));
}

#[test]
fn the_difference_of_texts_with_nothing_in_common_comes_soon() {
    let home = Home::new();
    let shipped = home.run(&["prompt", "text", "collision-ego"]).status(0);
    let mut theirs = shipped.stdout.clone();
    for i in 0..100_000_u64 {
        theirs.push_str(&format!("{}\n", i.wrapping_mul(2_654_435_761) % 9_973));
    }
    // Larger than a template may be: what is broken can be compared too, up to the limit for texts.
    theirs.truncate(1_000_000);
    home.write(home.config().join("prompts/collision-ego.md"), &theirs);
    let begun = std::time::Instant::now();
    let diff = home.run(&["prompt", "diff", "collision-ego"]).status(0);
    assert!(begun.elapsed().as_secs() < 10, "{:?}", begun.elapsed());
    // Valid: the lines that stay and those that come are the user's text, in order.
    let lines = diff.stdout.lines().skip(2);
    let new: Vec<&str> = lines
        .filter(|line| line.starts_with('+'))
        .map(|line| &line[1..])
        .collect();
    let last = theirs.lines().last().unwrap();
    assert_eq!(new.last(), Some(&last));
    let added = theirs.lines().count() - shipped.stdout.lines().count();
    assert!(new.len() >= added, "{} of {added}", new.len());
}
