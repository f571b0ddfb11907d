//! Several persons each ask a part of an experiment: their bundles, or their stores, become one batch with the report of
//! one run.

use std::collections::BTreeMap;

use super::batches::home as home_with;
use super::reports::half_of_them;
use super::support::program::{Ended, Home};
use super::support::server::Server;
use super::{BUNDLED, bundled_ego, bundled_xml};

const STUDY: &str = "title = \"T\"\nscenarios = [\"rec\"]\nmodels = [\"lab/tiny\", \"reference/geometry\"]\n\
    tasks = [\"collision\", \"safety\"]\ntechniques = [\"base\", \"all\"]\nsamples = 2\nleads = [0.5, 1]\n\
    truth = [\"auto\"]\nsplit = { test = 0.4, seed = 3 }\n";

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

fn person(server: &Server) -> Home {
    let home = home_with(server.base_url());
    for (name, _) in BUNDLED {
        home.write(format!("rec/{name}.xml"), bundled_xml(name));
        home.write(format!("rec/{name}.ego_trajectory.csv"), bundled_ego(name));
    }
    home.write("study.toml", STUDY);
    home
}

/// As if every answer had taken a second.
fn timeless(home: &Home) {
    home.rows("UPDATE runs SET duration_ms = 1000, first_chunk_ms = 10");
}

fn reports(home: &Home) -> BTreeMap<&'static str, String> {
    let report = |format: &'static str| {
        let made = run(home, &["report", "--batch", "last", "--format", format]).status(0);
        (format, made.stdout + &made.stderr)
    };
    ["md", "latex", "csv", "json"].map(report).into()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn parts_of_several_persons_become_the_batch_of_one() {
    let server = half_of_them().await;
    let one = person(&server);
    run(&one, &["evaluate", "study.toml"]).status(0);
    timeless(&one);
    let wanted = reports(&one);
    let asked = server.requests().len();
    let mut persons = Vec::new();
    for part in 1..=3 {
        let home = person(&server);
        run(
            &home,
            &["evaluate", "study.toml", "--shard", &format!("{part}/3")],
        )
        .status(0);
        // A job that is started again shows what it has, and asks nothing.
        let again = ["evaluate", "study.toml", "--shard", &format!("{part}/3")];
        let again = run(&home, &again).status(0);
        let empty = again.stdout.contains("dev split: 0 of 0 answered");
        assert!(
            empty || again.stdout.contains("Precision"),
            "{}",
            again.stdout
        );
        assert!(!again.stderr.contains("no scenarios"), "{}", again.stderr);
        timeless(&home);
        let alone = run(&home, &["report", "--batch", "last"]).status(0);
        alone.says(&["is here; `nearmiss runs import`"]);
        let file = format!("part-{part}.nearmiss");
        run(
            &home,
            &[
                "runs",
                "export",
                "--format=bundle",
                "--batch",
                "study.toml",
                "-o",
                &file,
            ],
        )
        .status(0);
        persons.push(home);
    }
    assert_eq!(
        server.requests().len(),
        2 * asked,
        "no question is in two parts"
    );
    let bundle = |part: usize| {
        let name = format!("part-{part}.nearmiss");
        let path = persons[part - 1].files().join(&name);
        (name, std::fs::read(path).unwrap())
    };
    // In an empty home, in any order, all at once or one by one.
    for order in [[1, 2, 3], [3, 1, 2]] {
        let home = Home::new();
        for part in order {
            let (name, bytes) = bundle(part);
            home.write(name, bytes);
        }
        let names = order.map(|part| format!("part-{part}.nearmiss"));
        let unpack = ["runs", "import", &names[0], &names[1], &names[2]];
        run(&home, &unpack[..3]).status(0).says(&["(part "]);
        run(&home, &unpack).status(0);
        assert_eq!(home.rows("SELECT id FROM batches").len(), 1);
        let of_parts = reports(&home);
        for (format, text) in &wanted {
            // The number of a batch is the one that it has on its machine.
            assert_eq!(&of_parts[format], text, "{format}, {order:?}");
        }
        let before = home.rows("SELECT * FROM items");
        run(&home, &unpack)
            .status(0)
            .says(&["0 runs and 0 ratings new"]);
        assert_eq!(home.rows("SELECT * FROM items"), before);
        assert_eq!(home.rows("SELECT shard FROM batches")[0]["shard"], None);
    }
    // One of them joins the parts of the others to the own one, and can go on with the whole.
    let home = &persons[1];
    for part in [1, 3] {
        let (name, bytes) = bundle(part);
        home.write(name, bytes);
    }
    let into = [
        "runs",
        "import",
        "part-1.nearmiss",
        "part-3.nearmiss",
        "--into",
        "others",
    ];
    run(home, &into).status(0);
    assert!(home.files().join("others/part-3/experiment.toml").is_file());
    assert_eq!(reports(home), wanted);
    let sent = server.requests().len();
    let again = run(home, &["evaluate", "study.toml"]).status(0);
    again.says(&["going on with b1"]);
    assert_eq!(server.requests().len(), sent, "everything is answered");
    for path in home.rows("SELECT DISTINCT path FROM items") {
        let path = path["path"].clone().unwrap();
        assert!(std::path::Path::new(&path).is_file(), "{path} is here");
    }
    // Two parts in one store stay two batches until they are joined.
    let both = person(&server);
    for part in ["1/3", "2/3"] {
        run(&both, &["evaluate", "study.toml", "--shard", part]).status(0);
    }
    run(
        &both,
        &["runs", "export", "--format=bundle", "--batch", "study.toml"],
    )
    .status(2)
    .says(&["several batches ask parts of this: b2 (part 2/3), b1 (part 1/3); name one"]);
}
