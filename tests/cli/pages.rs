//! `render -o page.html`, `film.mp4` and `--overlay`: what is in the files, and how a page plays in a real browser.

use serde_json::{Value, json};

use super::support::browser::Browser;
use super::support::program::{Home, skipped};
use super::{CUT_IN, bundled_xml};

/// Names and attributes that break out of a careless page.
const HOSTILE: &str = "</script><img src=x onerror=window.broken=1>";

fn text(home: &Home, name: &str) -> String {
    std::fs::read_to_string(home.files().join(name)).unwrap()
}

fn data(page: &str) -> Value {
    let (_, rest) = page.split_once("id=\"data-scene\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn a_page_is_one_small_file_that_asks_for_nothing() {
    let home = Home::new();
    let evil = HOSTILE.replace('<', "&lt;").replace('>', "&gt;");
    let xml = bundled_xml(CUT_IN).replacen("author=\"", &format!("author=\"{evil}"), 1);
    home.write("evil.xml", xml);
    home.run(&["render", "evil.xml", "-o", "evil.html"])
        .status(0);
    let page = text(&home, "evil.html");
    assert!(page.contains("&lt;img src=x") && !page.contains("<img"));
    home.run(&["render", CUT_IN, "-o", "page.html"]).status(0);
    let page = text(&home, "page.html");
    assert!(page.len() < 300_000, "{} bytes", page.len());
    for outside in ["src=", "href=", "@import", "url(", "https:", "fetch("] {
        assert!(!page.contains(outside), "{outside}");
    }
    home.run(&["render", CUT_IN, "-o", "again.html"]).status(0);
    assert_eq!(
        text(&home, "again.html"),
        page,
        "the same command, the same bytes"
    );
    let opened = |more: &[&str]| {
        let file = ["-o", "at.html", "--overwrite"];
        home.run(&[&["render", CUT_IN], &file[..], more].concat())
            .status(0);
        data(&text(&home, "at.html"))
    };
    let data = opened(&["--at", "7", "--plot", "thw", "--view", "all"]);
    assert_eq!(
        (&data["view"]["step"], &data["view"]["follows"]),
        (&json!(7), &json!(false))
    );
    assert_eq!(data["measures"][0]["id"], "thw");
    for (more, words) in [
        (&["--what", "plot"][..], "--what"),
        (&["--size", "800x600px"], "--size"),
        (&["--dpi", "100"], "--dpi"),
        (&["--at", "1,2"], "--at"),
    ] {
        let all = [&["render", CUT_IN, "-o", "x.html"], more].concat();
        home.run(&all).status(2).says(&[words]);
    }
    home.run(&[
        "render",
        CUT_IN,
        "ZAM_RedLight-1_1_T-1",
        "--format",
        "html",
        "-o",
        "pages",
    ])
    .status(0);
    assert!(
        home.files()
            .join("pages/ZAM_RedLight-1_1_T-1.html")
            .is_file()
    );
}

#[test]
fn a_page_plays_steps_and_picks_in_a_browser() {
    let Some(mut browser) = Browser::start(1300, 900) else {
        return;
    };
    let home = Home::new();
    home.run(&["render", CUT_IN, "-o", "page.html"]).status(0);
    let file = home.files().join("page.html");
    let data = data(&text(&home, "page.html"));
    let step = |browser: &mut Browser| {
        let later =
            "new Promise((done) => setTimeout(() => done(Number(document.body.dataset.step)), 60))";
        browser.value(later).as_i64().unwrap()
    };
    browser.open(&file, "");
    let first = step(&mut browser);
    assert_eq!(
        first, data["view"]["step"],
        "it opens at the moment that matters"
    );
    browser.key("ArrowLeft");
    assert_eq!(step(&mut browser), first - 1);
    browser.key("Home");
    assert_eq!(step(&mut browser), data["steps"][0]);
    browser.click("#play");
    browser.value("new Promise((done) => setTimeout(done, 600))");
    browser.click("#play");
    let played = step(&mut browser);
    assert!(played > data["steps"][0].as_i64().unwrap(), "{played}");
    browser.key("m");
    assert_eq!(step(&mut browser), first);
    // The row of another obstacle picks it, in the panel and in the plots.
    let last = "#everybody tbody tr:last-child";
    browser.click(&format!("{last} td:nth-child(2)"));
    let picked = browser.value(&format!("document.querySelector('{last}').dataset.id"));
    let heading = browser.value("document.querySelector('#picked h2').textContent");
    let id = picked.as_str().unwrap();
    assert!(heading.as_str().unwrap().starts_with(&format!("{id}, ")));
    // So does a click on the map: the bodies are drawn, not one colour.
    let drawn = "(() => { const c = document.querySelector('#map'); const all = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; \
                 return new Set(Array.from({ length: all.length / 4 }, (_, i) => all[4 * i] * 65536 + all[4 * i + 1] * 256 + all[4 * i + 2])).size; })()";
    assert!(browser.value(drawn).as_i64().unwrap() > 20);
    let steps = browser.value("document.querySelectorAll('#plots svg').length");
    assert_eq!(steps, 3);
    assert_eq!(browser.complaints(&file), Vec::<Value>::new());
    browser.open(&file, "#3");
    assert_eq!(step(&mut browser), 3);
}

#[test]
fn predictions_are_lines_in_figures_and_pages() {
    let home = Home::new();
    home.write(
        "tracks.csv",
        "time,id,x,y,mode,probability\n0,301,0,0,a,0.8\n1,301,5,1,a,0.8\n0,301,0,0,b,0.2\n1,301,5,-1,b,0.2\n0,9999,0,3,a,1\n1,9999,5,3,a,1\n",
    );
    let scenario = "ZAM_RedLight-1_1_T-1";
    let overlay = ["--overlay", "tracks.csv"];
    home.run(&[&["render", scenario, "-o", "page.html"], &overlay[..]].concat())
        .status(0);
    let data = data(&text(&home, "page.html"));
    let lines = data["lines"].as_array().unwrap();
    assert_eq!(lines.len(), 3);
    let opacities: Vec<f64> = lines
        .iter()
        .map(|l| l["opacity"].as_f64().unwrap())
        .collect();
    assert!(
        opacities[0] > opacities[1] && opacities[2] == 1.0,
        "{opacities:?}"
    );
    assert_eq!(lines[0]["owner"], json!({ "obstacle": "301" }));
    let svg = home.run(&["render", scenario]).status(0).stdout;
    let with = home
        .run(&[&["render", scenario], &overlay[..]].concat())
        .status(0)
        .stdout;
    assert!(with.len() > svg.len());
    // Columns by other names; ids of nobody are told.
    home.write("other.csv", "t,who,px,py,p\n0,77,0,0,1\n1,77,1,0,1\n");
    home.run(&[
        "render",
        scenario,
        "--overlay",
        "other.csv",
        "--columns",
        "id=who,x=px,y=py",
    ])
    .status(0)
    .says(&["no id of --overlay"]);
    for (table, words) in [
        ("time,id,x,y\n0,1,0,0\n1,1,x,0\n", &["3", "column x"][..]),
        ("time,id,x\n0,1,0\n", &["columns time, id, x and y"]),
        (
            "time,id,x,y,probability\n0,1,0,0,7\n1,1,0,0,7\n",
            &["0 to 1"],
        ),
    ] {
        home.write("wrong.csv", table);
        home.run(&["render", scenario, "--overlay", "wrong.csv"])
            .status(2)
            .says(words);
    }
}

#[test]
fn a_film_is_made_by_ffmpeg_or_it_is_said_what_to_install() {
    let home = Home::new();
    let film = ["render", CUT_IN, "--size", "161x121px", "-o", "film.mp4"];
    home.run_with(&film, &[("PATH", "")])
        .status(2)
        .says(&["ffmpeg", "install"]);
    assert!(!home.files().join("film.mp4").exists());
    home.run(&[&film[..], &["--at", "3"]].concat())
        .status(2)
        .says(&["--at"]);
    if !nearmiss::system::is_program("ffmpeg") {
        return skipped("no ffmpeg on PATH");
    }
    home.run(&film).status(0);
    let bytes = std::fs::read(home.files().join("film.mp4")).unwrap();
    assert_eq!(&bytes[4..8], b"ftyp");
}
