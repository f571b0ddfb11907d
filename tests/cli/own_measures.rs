//! Measures of the user's own: columns, terms, plots, thresholds and messages.

use super::support::program::Home;
use super::{BUNDLED, CUT_IN};

const OWN: &str = "[measure.my_risk]\nformula = \"ttc < 2 ? 1 : distance / speed\"\ndanger = \"low\"\nthreshold = 0.5\n\
    [measure.closeness]\nformula = \"exp(-my_risk / 1 s)\"\nunit = \"\"\ndanger = \"high\"\n";

fn home(config: &str) -> Home {
    let home = Home::new();
    home.write(home.config().join("config.toml"), config);
    home
}

#[test]
fn an_own_measure_is_a_column_a_term_and_a_plot() {
    let home = home(OWN);
    let table = home.run(&["metrics", CUT_IN, "--reasons"]).status(0).stdout;
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let heads = reader.headers().unwrap().clone();
    let place = |name: &str| heads.iter().position(|head| head == name).unwrap();
    let (mut compared, mut lowest) = (0, f64::INFINITY);
    for row in reader.records().map(Result::unwrap) {
        let value = |name: &str| row[place(name)].parse::<f64>().ok();
        let (Some(found), Some(distance)) = (value("my_risk"), value("distance")) else {
            assert!(!row[place("my_risk_reason")].is_empty());
            continue;
        };
        if value("ttc").is_some_and(|ttc| ttc < 2.0) {
            assert_eq!(found, 1.0);
        } else {
            assert_eq!(found == 0.0, distance == 0.0);
        }
        assert!((value("closeness").unwrap() - (-found).exp()).abs() < 1e-5);
        (compared, lowest) = (compared + 1, found.min(lowest));
    }
    assert!(compared > 10);
    let list = home.run(&["metrics", "--list"]).status(0).stdout;
    assert!(
        list.contains("my risk; config.toml: ttc < 2 ? 1 : distance / speed"),
        "{list}"
    );
    assert!(list.contains("≤ 0.5 s: critical (config.toml)"), "{list}");
    let json = home.run(&["metrics", CUT_IN, "--format", "json"]).status(0);
    let said = "\"my_risk = ttc < 2 ? 1 : distance / speed\"";
    assert!(json.stdout.contains("\"my_risk\":") && json.stdout.contains(said));
    let kept = |terms: String| {
        let arguments = [
            "inspect",
            CUT_IN,
            BUNDLED[1].0,
            "--format",
            "csv",
            "--where",
            &terms,
        ];
        home.run(&arguments).status(0).stdout.contains(CUT_IN)
    };
    assert!(kept(format!("my_risk<={}", lowest + 1e-3)));
    assert!(!kept(format!("my_risk<{}", lowest - 1e-3)));
    let picture = home.files().join("plot.svg");
    let plot = [
        "render",
        CUT_IN,
        "--what",
        "plot",
        "--plot",
        "my_risk",
        "-o",
        picture.to_str().unwrap(),
    ];
    home.run(&plot).status(0);
    assert!(
        std::fs::read_to_string(&picture)
            .unwrap()
            .contains("my risk")
    );
    // The workbench plots it like any other.
    let picture = home.files().join("screen.svg");
    let screen = [
        "render",
        CUT_IN,
        "--what",
        "screen",
        "--plot",
        "my_risk",
        "-o",
        picture.to_str().unwrap(),
    ];
    home.run(&screen).status(0);
    assert!(
        std::fs::read_to_string(&picture)
            .unwrap()
            .contains("my_risk")
    );
    let folder = home.files().join("index");
    let index = [
        "corpus",
        "index",
        CUT_IN,
        "--measure",
        "my_risk",
        "-o",
        folder.to_str().unwrap(),
    ];
    home.run(&index).status(0);
    let find = [
        "corpus",
        "find",
        "my_risk<100",
        "--index",
        folder.to_str().unwrap(),
    ];
    assert!(home.run(&find).status(0).stdout.contains(CUT_IN));
}

#[test]
fn a_wrong_formula_is_said_with_line_key_and_column() {
    let home = home("mouse = true\n[measure.my_risk]\nformula = \"ttc + distance\"\n");
    let said = "config.toml:3: measure.my_risk.formula: column 1, `[ttc + distance]`: a sum needs one unit, but `ttc` has s \
        and `distance` m; multiply or divide to bring them to one";
    home.run(&["metrics", CUT_IN]).status(2).says(&[said]);
    home.run(&["render", CUT_IN, "--plot", "my_risk", "-o", "plot.svg"])
        .status(2)
        .says(&[said]);
    assert!(home.run(&["doctor"]).status(1).stdout.contains(said));
    home.run(&["help", "measures"]).status(0);
}
