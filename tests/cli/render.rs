//! `render`: figures as files, whole, the same every time, and never over another one.

use super::support::program::Home;

fn bytes(home: &Home, name: &str) -> Vec<u8> {
    std::fs::read(home.files().join(name)).unwrap()
}

#[test]
fn figures_in_three_formats() {
    let home = Home::new();
    let render = |what: &str, name: &str| {
        let file = home.files().join(name);
        let file = file.to_str().unwrap();
        let all = ["render", "ZAM_RedLight-1_1_T-1", "--what", what, "-o", file];
        home.run(&all).status(0);
    };
    render("both", "a.svg");
    let svg = String::from_utf8(bytes(&home, "a.svg")).unwrap();
    assert!(
        svg.starts_with("<?xml") || svg.starts_with("<svg"),
        "{}",
        &svg[..80]
    );
    assert!(svg.contains(">ego<"), "text stays text");
    render("both", "b.svg");
    assert_eq!(
        bytes(&home, "a.svg"),
        bytes(&home, "b.svg"),
        "the same command makes the same bytes"
    );
    render("map", "a.png");
    assert_eq!(&bytes(&home, "a.png")[..8], b"\x89PNG\r\n\x1a\n");
    render("screen", "screen.svg");
    let screen = String::from_utf8(bytes(&home, "screen.svg")).unwrap();
    assert!(screen.contains("scenarios"), "the workbench itself");
}

#[test]
fn every_step_as_a_film() {
    let home = Home::new();
    let file = home.files().join("film.gif");
    let file = file.to_str().unwrap();
    let few = [
        "render",
        "ZAM_RedLight-1_1_T-1",
        "--all",
        "--size",
        "160x120px",
        "-o",
        file,
    ];
    home.run(&few).status(0);
    let gif = bytes(&home, "film.gif");
    assert_eq!(&gif[..6], b"GIF89a");
    let frames = gif.windows(3).filter(|w| w == b"\x21\xf9\x04").count();
    assert!(frames >= 60, "{frames} frames");
}

#[test]
fn nothing_is_replaced_and_mistakes_are_named() {
    let home = Home::new();
    let file = home.files().join("a.svg");
    std::fs::write(&file, "mine").unwrap();
    let file = file.to_str().unwrap().to_string();
    let scenario = "ZAM_RedLight-1_1_T-1";
    let refused = home.run(&["render", scenario, "-o", &file]).status(2);
    assert!(refused.stderr.contains("--overwrite"), "{}", refused.stderr);
    assert_eq!(bytes(&home, "a.svg"), b"mine");
    home.run(&["render", scenario, "-o", &file, "--overwrite"])
        .status(0);
    assert_ne!(bytes(&home, "a.svg"), b"mine");
    for (wrong, said) in [
        (vec!["render", scenario, "-o", "x.bmp"], "bmp"),
        (
            vec!["render", scenario, "--at", "999", "-o", "x.svg"],
            "999",
        ),
        (
            vec!["render", scenario, "--obstacle", "7", "-o", "x.svg"],
            "7",
        ),
        (vec!["render", "nobody.xml", "-o", "x.svg"], "nobody.xml"),
    ] {
        let ended = home.run(&wrong).status(2);
        assert!(ended.stderr.contains(said), "{wrong:?}: {}", ended.stderr);
        assert!(!ended.stderr.contains("panicked"), "{}", ended.stderr);
    }
}

#[test]
fn without_an_ego_it_says_so() {
    let home = Home::new();
    let whole = super::bundled_xml("ZAM_RedLight-1_1_T-1");
    // With a planning problem somebody drives, which is said.
    home.write("driven.xml", &whole);
    let map = home
        .run(&["render", "driven.xml", "--what", "map"])
        .status(0)
        .says(&["the built-in planner drives the planning problem", "--ego"]);
    assert!(map.stdout.contains(">ego<"), "{}", map.stdout);
    // With nobody there, there is none.
    let mut text = whole;
    for element in ["dynamicObstacle", "planningProblem"] {
        while let Some(start) = text.find(&format!("<{element} ")) {
            let end = format!("</{element}>");
            let after = text.find(&end).unwrap() + end.len();
            text.replace_range(start..after, "");
        }
    }
    home.write("alone.xml", text);
    let map = home
        .run(&["render", "alone.xml", "--what", "map"])
        .status(0)
        .says(&["alone.xml: drawn without an ego", "--ego ID|FILE"]);
    assert!(!map.stdout.contains(">ego<"), "no ego is planned unasked");
    home.run(&["render", "alone.xml", "--what", "screen"])
        .status(0)
        .says(&["drawn without an ego"]);
    for what in ["plot", "both"] {
        let refused = home.run(&["render", "alone.xml", "--what", what]).status(2);
        refused.says(&["measures need an ego", "--ego ID|FILE", "--what map"]);
    }
    // With one, nothing is said.
    let usual = home.run(&["render", "ZAM_RedLight-1_1_T-1"]).status(0);
    assert_eq!(usual.stderr, "");
}

#[test]
fn several_pictures_make_the_folder_that_is_named() {
    let home = Home::new();
    let scenario = "ZAM_RedLight-1_1_T-1";
    let many = ["render", scenario, "--at", "10,20", "-o"];
    home.run(&[&many[..], &["new/ones", "--format", "png"]].concat())
        .status(0);
    for step in ["0010", "0020"] {
        let name = format!("new/ones/{scenario}_{step}.png");
        assert_eq!(&bytes(&home, &name)[1..4], b"PNG", "{name}");
    }
    assert!(!home.files().join("new/ones_0010.png").exists());
    // A name with an ending stays a name, and so does that of one picture.
    home.run(&[&many[..], &["a.svg"]].concat()).status(0);
    assert!(home.files().join("a_0020.svg").is_file());
    home.run(&["render", scenario, "-o", "one", "--format", "svg"])
        .status(0);
    assert!(home.files().join("one").is_file());
    // Where nothing is drawn, no folder is left.
    let wrong = ["render", scenario, "--at", "10,999", "-o", "none"];
    home.run(&[&wrong[..], &["--format", "png"]].concat())
        .status(2);
    assert!(!home.files().join("none").exists());
    home.run(&[&many[..], &["none"]].concat())
        .status(2)
        .says(&["--format works with any name, and makes this a folder"]);
    let ended = home
        .run(&["render", scenario, "-o", "f.jpg"])
        .status(2)
        .says(&["f.jpg", ".png"]);
    assert!(!ended.stderr.contains("folder"), "{}", ended.stderr);
}

#[test]
fn a_variant_is_drawn_with_the_motion_before_the_change() {
    let home = Home::new();
    let name = "ZAM_RedLight-1_1_T-1";
    let all = nearmiss::formats::bundled();
    let entry = all.iter().find(|entry| entry.name == name).unwrap();
    let original = entry.read().unwrap();
    let attacker = original.obstacles[0].id;
    let text = std::fs::read(format!("scenarios/{name}.xml")).unwrap();
    let file = home.write("variant.xml", text);
    let papers = |sha256: &str, id: &str| {
        let papers = serde_json::json!({
            "variant": "variant.xml",
            "attacker": attacker,
            "attackers": [{ "id": attacker, "from_step": 0 }],
            "change": { "from_step": 0 },
            "original": { "benchmark_id": id, "sha256": sha256 },
        });
        home.write("variant.json", papers.to_string());
    };
    let render = || {
        let to = home.files().join("variant.svg");
        let (file, to) = (file.to_str().unwrap(), to.to_str().unwrap());
        let view = ["--view", "all"];
        let arguments = ["render", file, "--at", "20", "--overwrite", "-o", to];
        home.run(&[&arguments[..], &view].concat()).status(0)
    };
    let recorded = format!("{attacker} recorded");
    let hash = original.hash.to_string();
    papers(&hash, name);
    render();
    let svg = String::from_utf8(bytes(&home, "variant.svg")).unwrap();
    assert!(svg.contains(&recorded), "{svg}");
    // Another file of this name is not the original, and an id leads nowhere else.
    for (sha256, id) in [("0000", name), (&hash, "../../nowhere")] {
        papers(sha256, id);
        render().says(&["drawn without the original motion", id, sha256]);
        let svg = String::from_utf8(bytes(&home, "variant.svg")).unwrap();
        assert!(!svg.contains(&recorded), "{svg}");
    }
}

#[test]
fn the_original_of_a_variant_is_found_where_it_was_or_where_it_is_said_to_be() {
    let home = Home::new();
    let name = "ZAM_RedLight-1_1_T-1";
    // Not byte for byte the bundled one: that would be found in any case.
    let text = format!("{}\n", super::bundled_xml(name));
    let original = nearmiss::formats::commonroad::read(text.as_bytes(), name).unwrap();
    let attacker = original.obstacles[0].id;
    std::fs::create_dir(home.files().join("elsewhere")).unwrap();
    home.write("in/own.xml", &text);
    home.write("out/variant.xml", &text);
    let ego = std::fs::read(format!("scenarios/{name}.ego_trajectory.csv")).unwrap();
    home.write("out/variant.ego_trajectory.csv", ego);
    let papers = serde_json::json!({
        "variant": "variant.xml",
        "attacker": attacker,
        "attackers": [{ "id": attacker, "from_step": 0 }],
        "change": { "from_step": 0 },
        "original": { "benchmark_id": name, "sha256": original.hash.to_string(), "file": "in/own.xml" },
        "made": { "line": { "file": "in/own.xml" } },
    });
    home.write("out/variant.json", papers.to_string());
    let recorded = format!("{attacker} recorded");
    let render = |more: &[&str], status: i32| {
        let all = ["render", "out/variant.xml", "--at"];
        let view = ["--view", "all"];
        let view = if more.contains(&"plot") {
            &[][..]
        } else {
            &view
        };
        home.run(&[&all[..], more, view].concat()).status(status)
    };
    let found = render(&["20"], 0);
    assert!(found.stdout.contains(&recorded), "{}", found.stdout);
    assert_eq!(found.stderr, "");

    let (there, gone) = ("in/own.xml", "elsewhere/other.xml");
    std::fs::rename(home.files().join(there), home.files().join(gone)).unwrap();
    let without = render(&["20"], 0);
    assert!(!without.stdout.contains(&recorded), "{}", without.stdout);
    let note = "drawn without the original motion";
    assert_eq!(without.stderr.matches(note).count(), 1);
    let without = without.says(&["in/own.xml", "--original FILE"]);
    assert_eq!(without.stderr.lines().count(), 1, "{}", without.stderr);
    let nothing = render(&["9999"], 2).says(&["--at 9999"]);
    assert!(!nothing.stderr.contains(note), "{}", nothing.stderr);

    let named = render(&["20", "--original", gone], 0);
    assert!(named.stdout.contains(&recorded), "{}", named.stdout);
    assert_eq!(named.stderr, "");
    let hash = original.hash.to_string();
    render(&["20", "--original", name], 2).says(&["--original", "SHA-256", &hash]);
    render(&["20", "--original", "nobody.xml"], 2).says(&["nobody.xml"]);
    render(&["20", "--original", gone, "--what", "plot"], 2).says(&["--original needs a map"]);
    let alone = ["render", name, "--original", gone];
    home.run(&alone)
        .status(2)
        .says(&["has no manifest", "NAME.json"]);
}

#[test]
fn several_moments_in_one_picture() {
    let home = Home::new();
    let scenario = "ZAM_RedLight-1_1_T-1";
    let grid = |at: &str, shape: &str, status: i32| {
        let all = ["render", scenario, "--at", at, "--grid", shape];
        home.run(&all).status(status)
    };
    let svg = grid("10,2s,30,40,50,worst", "2x3", 0).stdout;
    // 170 mm.
    assert!(svg.contains(r#"width="481.89pt""#), "{}", &svg[..300]);
    assert_eq!(svg.matches(r#"<g class="map""#).count(), 6);
    for time in ["t = 1.0 s", "t = 2.0 s", "t = 5.0 s"] {
        assert!(svg.contains(time), "{time}");
    }
    assert_eq!(svg.matches(" m</text>").count(), 1, "one scale bar");
    assert_eq!(svg, grid("10,2s,30,40,50,worst", "2x3", 0).stdout);

    grid("10,20", "2x3", 2).says(&["6 panels", "6 moments", "there are 2"]);
    grid("10,20,30", "1x2", 2).says(&["2 panels", "there are 3"]);
    grid("10,999", "1x2", 2).says(&["--at 999"]);
    grid("10,20", "2", 2).says(&["ROWSxCOLUMNS", "2x3"]);
    let with = |more: &[&str]| {
        let all = ["render", scenario, "--at", "10,20", "--grid", "2x2"];
        home.run(&[&all[..], more].concat()).status(2)
    };
    with(&["--with-original"]).says(&["no original", "NAME.json"]);
    with(&["--what", "both"]).says(&["need --what map"]);
    with(&["-o", "film.gif"]).says(&["one picture", ".svg"]);
    let case = home.run(&["render", scenario, "--case-study"]).status(2);
    case.says(&["no original", "NAME.json"]);
}

#[test]
fn a_case_study_has_the_original_above_the_variant() {
    let home = Home::new();
    let name = "ZAM_RedLight-1_1_T-1";
    let text = super::bundled_xml(name);
    let original = nearmiss::formats::commonroad::read(text.as_bytes(), name).unwrap();
    home.write("v.xml", &text);
    home.write("v.ego_trajectory.csv", super::bundled_ego(name));
    let papers = |sha256: &str| {
        let papers = serde_json::json!({
            "variant": "v.xml",
            "attacker": 301,
            "attackers": [{ "id": 301, "from_step": 19 }],
            "change": { "from_step": 19 },
            "original": { "benchmark_id": name, "sha256": sha256 },
        });
        home.write("v.json", papers.to_string());
    };
    papers(&original.hash.to_string());
    let render = |more: &[&str], status: i32| {
        let all = ["render", "v.xml"];
        home.run(&[&all[..], more].concat()).status(status)
    };
    let svg = render(&["--case-study"], 0).stdout;
    for row in [">original", ">variant"] {
        assert!(svg.contains(row), "{row}");
    }
    // From the first changed step to the contact, the last at the contact.
    let steps = svg
        .split("steps=\"")
        .nth(1)
        .unwrap()
        .split('"')
        .next()
        .unwrap();
    let (above, below) = steps.split_once("; ").unwrap();
    assert_eq!(above, below);
    assert!(above.starts_with("20, "), "{above}");
    assert_eq!(above.split(", ").count(), 4);
    assert_eq!(
        svg.matches(">contact<").count() / 2,
        2,
        "one a row, with its halo"
    );

    let both = render(&["--at", "10,20", "--grid", "2x2", "--with-original"], 0);
    assert!(both.stdout.contains(r#"steps="10, 20; 10, 20""#));
    both.says(&["rows: original, ", "; variant, planned ego"]);
    let rows = ["--at", "10", "--grid", "1x2", "--with-original"];
    render(&rows, 2).says(&["even number of rows"]);
    render(&["--case-study", "--grid", "3x2"], 2).says(&["two rows"]);
    let many = ["--at", "10,20,30", "--grid", "2x2", "--with-original"];
    render(&many, 2).says(&["4 panels", "half of them", "2 moments", "there are 3"]);
    papers("0000");
    render(&["--case-study"], 2).says(&["the original", "0000", "--original FILE"]);
}
