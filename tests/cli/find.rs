//! `find`: a sentence becomes a filter that is shown, and finds windows of an index.

use super::BUNDLED;
use super::support::program::Home;

fn indexed(home: &Home) {
    let names = BUNDLED.iter().map(|(name, _)| *name);
    let run: Vec<&str> = ["corpus", "index", "-o", "index"]
        .into_iter()
        .chain(names)
        .collect();
    home.run(&run).status(0);
}

#[test]
fn a_sentence_finds_what_its_filter_and_the_table_of_the_index_say() {
    let home = Home::new();
    indexed(&home);
    let sentence = "cut-ins or crossing traffic in fog";
    let found = home
        .run(&[
            "corpus",
            "find",
            sentence,
            "--index",
            "index",
            "-n",
            "5",
            "--format=json",
        ])
        .status(0)
        .says(&[
            "not understood, left out: fog",
            "filter: manoeuvre:cut_in,crossing",
        ])
        .json();
    assert_eq!(found["not_understood"][0], "fog");
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
    // The filter that was shown finds the same.
    let filter = found["filter"].as_str().unwrap();
    let again = home.run(&[
        "corpus",
        "find",
        "--filter",
        filter,
        "--index",
        "index",
        "-n",
        "5",
        "--format=json",
    ]);
    assert_eq!(again.status(0).json()["found"], found["found"]);
}

#[test]
fn numbers_are_those_of_the_window_and_terms_about_scenarios_read_them() {
    let home = Home::new();
    indexed(&home);
    let find = |filter: &str| {
        let run = [
            "corpus",
            "find",
            "--filter",
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
        "--filter",
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
fn the_filter_alone_needs_no_index() {
    let home = Home::new();
    let sentence = "cut-ins under 1.5 s TTC on motorways";
    for option in ["--filter-only", "--dry-run"] {
        let run = home.run(&["corpus", "find", sentence, option]).status(0);
        assert_eq!(run.stdout, "manoeuvre:cut_in ttc<1.5 road:highway\n");
    }
}

#[test]
fn what_cannot_be_searched_says_why() {
    let home = Home::new();
    for (arguments, says) in [
        (
            &["corpus", "find", "qwertz"][..],
            "not understood, left out: qwertz",
        ),
        (&["corpus", "find", "qwertz"], "nothing of this is a filter"),
        (&["corpus", "find", "cut-ins"], "--index FOLDER"),
        (
            &["corpus", "find", "cut-ins", "--index", "nowhere"],
            "nowhere",
        ),
        (
            &["corpus", "find", "--filter", "rode:urban"],
            "unknown filter `rode:`",
        ),
        (&["corpus", "find", "--filter", "ttc<"], "no value"),
        (&["corpus", "find"], "--filter FILTER"),
        (&["corpus", "find", ""], "nothing of this is a filter"),
        (
            &["corpus", "find", "show me everything"],
            "nothing of this is a filter",
        ),
        (
            &["corpus", "find", "pedestrain"],
            "did you mean `pedestrian`?",
        ),
        (
            &["corpus", "find", "cut-ins", "--filter", "ttc<1"],
            "cannot be used with",
        ),
    ] {
        home.run(arguments).status(2).says(&[says]);
    }
    indexed(&home);
    home.run(&["corpus", "find", "wttc under 1 s", "--index", "index"])
        .status(2)
        .says(&["no measure wttc", "distance, ttc"]);
    home.run(&["corpus", "find", "cut-ins in China", "--index", "index"])
        .status(1)
        .says(&["none of"]);
}
