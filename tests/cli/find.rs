//! `find`: terms find windows of an index; a model writes those of a sentence.

use super::BUNDLED;
use super::batches::telling;
use super::support::program::{Ended, Home};
use super::support::server::{Script, Server};

fn indexed(home: &Home) {
    let names = BUNDLED.iter().map(|(name, _)| *name);
    let run: Vec<&str> = ["corpus", "index", "-o", "index"]
        .into_iter()
        .chain(names)
        .collect();
    home.run(&run).status(0);
}

#[test]
fn terms_find_what_the_table_of_the_index_says() {
    let home = Home::new();
    indexed(&home);
    let find = |terms: &[&str]| {
        let run = [
            &["corpus", "find"],
            terms,
            &["--index", "index", "-n", "5", "--format=json"],
        ]
        .concat();
        home.run(&run).status(0)
    };
    let found = find(&["manoeuvre:cut_in,crossing", "severity<=5"])
        .says(&["filter: manoeuvre:cut_in,crossing severity<=5"])
        .json();
    assert!(
        found["sentence"].is_null() && found["model"].is_null(),
        "{found}"
    );
    let show = home
        .run(&["corpus", "show", "index", "--format=json"])
        .status(0)
        .json();
    let rows = show["coverage"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|row| row["manoeuvre"] == "cut_in" || row["manoeuvre"] == "crossing");
    let counts = rows.flat_map(|row| row["counts"].as_array().unwrap());
    let count: u64 = counts.map(|n| n.as_u64().unwrap()).sum();
    assert!(count > 0);
    assert_eq!(
        (&found["windows"], &found["searched"]),
        (&count.into(), &show["windows"])
    );
    let windows = found["found"].as_array().unwrap();
    assert_eq!(windows.len(), 5);
    let severities: Vec<i64> = windows
        .iter()
        .map(|w| w["severity"].as_i64().unwrap())
        .collect();
    assert!(severities.is_sorted());
    // In one argument they are the same.
    let again = find(&[found["filter"].as_str().unwrap()]).json();
    assert_eq!(again["found"], found["found"]);
}

#[test]
fn numbers_are_those_of_the_window_and_terms_about_scenarios_read_them() {
    let home = Home::new();
    indexed(&home);
    let find = |filter: &str| {
        let run = [
            "corpus",
            "find",
            filter,
            "--index",
            "index",
            "-n",
            "100000",
            "--format=json",
        ];
        home.run(&run).json()
    };
    let tailgating = [
        "corpus",
        "find",
        "manoeuvre:followed time_gap<9",
        "--index",
        "index",
    ];
    home.run(&tailgating)
        .status(1)
        .says(&["no window of this kind has the measure time_gap", "none of"]);
    let close = find("ttc<1.5");
    for window in close["found"].as_array().unwrap() {
        assert!(window["values"]["ttc"].as_f64().unwrap() < 1.5, "{window}");
    }
    assert!(close["windows"].as_u64().unwrap() > 0);
    let all = find("severity<=5");
    assert_eq!(all["windows"], all["searched"]);
    let (with, without) = (
        find("has:ego")["windows"].clone(),
        find("no:ego")["windows"].clone(),
    );
    let sum = with.as_u64().unwrap() + without.as_u64().unwrap();
    assert_eq!(sum, all["windows"].as_u64().unwrap());
    let (cars, others) = (find("actor:car"), find("!actor:car"));
    let sum = cars["windows"].as_u64().unwrap() + others["windows"].as_u64().unwrap();
    assert_eq!(sum, all["windows"].as_u64().unwrap());
    let one = find("CutIn");
    let windows = one["found"].as_array().unwrap();
    assert!(!windows.is_empty());
    assert!(windows.iter().all(|w| w["scenario"] == "ZAM_CutIn-1_1_T-1"));
    assert_eq!(find("country:DEU")["windows"], 0);
}

#[test]
fn the_terms_alone_need_no_index() {
    let home = Home::new();
    let run = [
        "corpus",
        "find",
        "manoeuvre:cut_in",
        "ttc<1.5",
        "--filter-only",
    ];
    let run = home.run(&run).status(0);
    assert_eq!(run.stdout, "manoeuvre:cut_in ttc<1.5\n");
}

#[test]
fn what_cannot_be_searched_says_why() {
    let home = Home::new();
    let sentence = "cut-ins under 1.5 s TTC on motorways";
    for (arguments, says) in [
        (
            &["corpus", "find", sentence][..],
            &[
                "reads as a sentence",
                "such as manoeuvre:cut_in",
                "--model MODEL writes",
            ][..],
        ),
        (
            &["corpus", "find", "manoeuvre:cut_in", "in", "town"],
            &["reads as a sentence"],
        ),
        (&["corpus", "find", "manoeuvre:cut_in"], &["--index FOLDER"]),
        (
            &["corpus", "find", "manoeuvre:cut_in", "--index", "nowhere"],
            &["nowhere"],
        ),
        (
            &["corpus", "find", "rode:urban"],
            &["unknown filter `rode:`; available: tag:", "help corpora"],
        ),
        (
            &["corpus", "find", "tcc<1"],
            &["unknown number `tcc`; available: risk"],
        ),
        (
            &["corpus", "find", "actor:pedestrain"],
            &["available: unknown, car"],
        ),
        (&["corpus", "find", "ttc<"], &["no value"]),
        (&["corpus", "find", "ttc<1 x\u{1b}[2J y"], &["x␛[2J"]),
        (&["corpus", "find", ""], &["expected terms"]),
        (&["corpus", "find"], &["required", "<TERMS>"]),
        (
            &["corpus", "find", "cut-ins", "--model", "lab/tiny"],
            &["--index FOLDER"],
        ),
    ] {
        home.run(arguments).status(2).says(says);
    }
    indexed(&home);
    home.run(&["corpus", "find", "wttc<1", "--index", "index"])
        .status(2)
        .says(&["no measure wttc", "distance, ttc"]);
    home.run(&[
        "corpus",
        "find",
        "manoeuvre:cut_in country:china",
        "--index",
        "index",
    ])
    .status(1)
    .says(&["none of"]);
    home.run(&["corpus", "find", "pedestrian's", "--index", "index"])
        .status(1)
        .says(&["words are parts of names", "none of"]);
    for (model, says) in [
        ("reference/geometry", "not a language model"),
        ("nobody/tiny", "nobody"),
    ] {
        home.run(&[
            "corpus", "find", sentence, "--index", "index", "--model", model,
        ])
        .status(2)
        .says(&[says]);
    }
}

/// A model at this address, with a price.
fn configure(home: &Home, url: &str, more: &str) {
    let config = format!(
        "{more}[provider.lab]\nbase_url = \"{url}\"\nkey_env = []\n\
         [[provider.lab.prices]]\nmodel = \"tiny\"\ninput = 1\noutput = 10\n"
    );
    home.write(home.config().join("config.toml"), config);
}

fn ask(home: &Home, sentence: &str, more: &[&str]) -> Ended {
    let run = [
        "corpus", "find", sentence, "--index", "index", "--model", "lab/tiny",
    ];
    tokio::task::block_in_place(|| home.run(&[&run, more].concat()))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_model_writes_the_terms_of_a_sentence_once() {
    let server =
        Server::answering(|_, _| Some(telling("manoeuvre:cut_in ttc<5\nleft out: in fog"))).await;
    let home = Home::new();
    tokio::task::block_in_place(|| indexed(&home));
    configure(&home, server.base_url(), "");
    let sentence = "cut-ins under 5 s TTC in fog";
    let found = ask(&home, sentence, &["--format=json"])
        .status(0)
        .says(&[
            "lab/tiny has no term for: in fog",
            "filter: manoeuvre:cut_in ttc<5",
        ])
        .json();
    assert_eq!(found["sentence"], sentence);
    assert_eq!(found["model"], "lab/tiny");
    assert_eq!(found["filter"], "manoeuvre:cut_in ttc<5");
    assert_eq!(found["left_out"], "in fog");
    assert!(found["windows"].as_u64() > Some(0), "{found}");
    // The model sees the terms, their values, the measures of this index alone, and the sentence.
    let body = server.requests()[0].json();
    let told = body["messages"][0]["content"].as_str().unwrap();
    for words in ["turning_across", "priority_vehicle", "- ttc: ", "country:"] {
        assert!(told.contains(words), "{words}\n{told}");
    }
    assert!(!told.contains("- wttc: "), "{told}");
    assert_eq!(body["messages"][1]["content"], sentence);
    assert!(
        body.to_string().contains("4096"),
        "a limit of tokens: {body}"
    );
    // The answer is kept.
    let again = ask(&home, sentence, &["--filter-only"]).status(0);
    assert_eq!(again.stdout, "manoeuvre:cut_in ttc<5\n");
    assert_eq!(server.requests().len(), 1);
    let rows = home.rows("SELECT model, answer, cost_usd FROM reflections");
    assert_eq!(rows.len(), 1);
    assert_eq!(rows[0]["model"].as_deref(), Some("lab/tiny"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_no_filter_is_shown_and_not_searched() {
    let server =
        Server::answering(|_, _| Some(telling("Sorry, \u{1b}[31mI cannot do this."))).await;
    let home = Home::new();
    tokio::task::block_in_place(|| indexed(&home));
    configure(&home, server.base_url(), "");
    ask(&home, "cut-ins", &[]).status(2).says(&[
        "lab/tiny wrote no filter",
        "reads as a sentence",
        "its answer: Sorry, ␛[31mI cannot do this.",
    ]);
    // It is not kept to.
    ask(&home, "cut-ins", &[]).status(2);
    assert_eq!(server.requests().len(), 2);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_budget_and_a_server_that_fails_end_it() {
    let server = Server::answering(|_, _| Some(Script::json(400, "{\"error\": \"no\"}"))).await;
    let home = Home::new();
    tokio::task::block_in_place(|| indexed(&home));
    configure(&home, server.base_url(), "budget = 0.000001\n");
    ask(&home, "cut-ins", &[])
        .status(2)
        .says(&["lab", "budget"]);
    assert!(server.requests().is_empty());
    configure(&home, server.base_url(), "");
    ask(&home, "cut-ins", &[])
        .status(2)
        .says(&["lab/tiny", "400"]);
}
