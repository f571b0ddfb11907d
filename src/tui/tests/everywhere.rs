//! Every screen at every size, frames, and extreme scenarios.

use nearmiss_drive::planner::Cancel;
use nearmiss_formats::{EgoSelection, Entry, bundled};
use nearmiss_store::RunId;
use nearmiss_study::evaluation::Answer;
use nearmiss_study::evaluation::batch::Estimate;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::style::{Color, Modifier};

use crate::features::answers::LoadStored;
use crate::features::batch::request::EstimateBatch;
use crate::features::planner::request::Plan;
use crate::features::scenarios::request::{Find, Found};
use crate::loaded::Opened;
use crate::message::{Msg, Reloaded};
use crate::model::{Counts, Pane, Update};
use crate::tests::answers::stored_of;
use crate::tests::bench::{self, Bench, answer, coarse, request};
use crate::tests::history::three;
use crate::theme::{ColorDepth, Theme};
use crate::views;
use crate::widgets::highlight;

const SIZES: [(u16, u16); 4] = [(80, 24), (100, 30), (120, 40), (200, 60)];

/// Every view with the keys that lead to it, and whether a line in its middle is selected.
pub(super) const VIEWS: [(&str, &str, bool); 38] = [
    ("scenarios", "", false),
    ("scenarios alone", "z", false),
    ("grouped", "space l g", false),
    ("filtered", "/ m e r", false),
    ("map", "tab", false),
    (
        "map alone with tape and paths",
        "tab space m t space m p z",
        false,
    ),
    ("two moments alone", "tab home z space m s", false),
    ("timeline", "tab z space p h", false),
    ("prompt", "tab tab", false),
    ("template alone", "tab tab space a v z", false),
    ("verdict alone", "tab tab tab z", false),
    ("reasoning alone", "tab tab tab tab z", false),
    ("plot alone", "tab tab tab tab tab z", false),
    ("safety task", "space a t", false),
    ("help", "?", false),
    ("about", "space o i", false),
    ("values", "space o v", false),
    ("palette", ":", true),
    ("models", "m", true),
    ("models to compare", "c", true),
    ("themes", "ctrl-t", false),
    ("measures", "space p m", true),
    ("orders", "space l s", true),
    ("pictures", "space o p", true),
    ("templates", ": t e m p l a t e s enter", true),
    ("tags", "space l t", false),
    ("layers", "space m l", false),
    ("details", "space o d", false),
    ("drivers", "space e d", false),
    ("source", "space o s", false),
    ("tasks", "space o j", false),
    ("batch", "space a a", false),
    ("index", "space l i", false),
    ("coverage without an index", "space l c", false),
    ("side by side", "space o c", false),
    ("a reason", "space o c w", false),
    ("blind", "space o b", false),
    ("editor", "e ctrl-f y o u", false),
];

fn said(model: &str, dangerous: bool, run: i64) -> Answer {
    Answer {
        run: Some(RunId(run)),
        text:
            "### Obstacle 301\n\nObstacle 301 is at a distance of 999 m at step 20. It is **fast**."
                .into(),
        ..answer(model, dangerous, 301)
    }
}

/// Two answers beside the built-in judge, at the contact; then these keys.
fn bench(keys: &str, size: (u16, u16)) -> Bench {
    highlight::load();
    let mut bench = Bench::bundled();
    bench.send(Msg::Reloaded(Reloaded::Themes(Theme::all(
        std::path::Path::new("/nonexistent"),
    ))));
    bench.send(Msg::Resize(size.0, size.1));
    bench.model.model = "lab/small".into();
    let of = stored_of(&bench);
    bench.send(Msg::reply::<LoadStored>((
        of,
        vec![said("lab/small", false, 7), said("lab/large", true, 8)],
    )));
    bench.press("x");
    bench.model.toasts.clear();
    bench.frame(size.0, size.1);
    bench.press(keys);
    let count = bench
        .effects
        .iter()
        .find_map(|effect| match effect.request() {
            Some(EstimateBatch { id, .. }) => Some(*id),
            _ => None,
        });
    if let Some(id) = count {
        let counts = Counts {
            looked: 8,
            estimate: Estimate {
                requests: 7,
                stored: 1,
                tokens: 12_345,
                usd: 0.1234,
                ..Estimate::default()
            },
            at_once: 4,
            ..Counts::default()
        };
        bench.send(Msg::reply::<EstimateBatch>((id, Update::Progress(counts))));
    }
    bench
}

fn drawn(bench: &mut Bench, theme: Theme, (columns, rows): (u16, u16)) -> Buffer {
    bench.model.theme = theme;
    let mut terminal = Terminal::new(TestBackend::new(columns, rows)).unwrap();
    let drawn = terminal.draw(|frame| views::draw(frame, &bench.model));
    drawn.unwrap().buffer.clone()
}

fn text(buffer: &Buffer) -> String {
    let columns = usize::from(buffer.area.width);
    let line = |cells: &[ratatui::buffer::Cell]| {
        let line: String = cells.iter().map(|cell| cell.symbol()).collect();
        line.trim_end().to_string()
    };
    let lines: Vec<String> = buffer.content.chunks(columns).map(line).collect();
    lines.join("\n")
}

const SIGNS: [Modifier; 3] = [Modifier::BOLD, Modifier::REVERSED, Modifier::UNDERLINED];

/// Holds the view in every theme against the dark one; gives its text.
pub(super) fn seen_in_every_theme(
    what: &str,
    bench: &mut Bench,
    size: (u16, u16),
    selects: bool,
) -> String {
    // As cells, the map divides by colours; without them it is drawn like this.
    bench.model.look.map = crate::model::MapChoice::Braille;
    let dark = drawn(bench, Theme::default_for(true), size);
    let plain = drawn(
        bench,
        Theme::default_for(true).at_depth(ColorDepth::None),
        size,
    );
    let light = drawn(bench, Theme::default_for(false), size);
    let sixteen = drawn(
        bench,
        Theme::default_for(true).at_depth(ColorDepth::Sixteen),
        size,
    );
    let words = text(&dark);
    // Without colours, bodies on the map are told apart by how they are filled.
    let map = bench.model.drawn.area(crate::model::Pane::Map);
    // Above the map of a driver, or left of it, stands that of the ego.
    let map = map.map(|map| match what {
        "drivers" => ratatui::layout::Rect::new(0, 1, map.right(), map.bottom() - 1),
        _ => map,
    });
    let beside_map = |buffer: &Buffer| {
        let mut buffer = buffer.clone();
        let inside = map.map(|map| map.intersection(buffer.area));
        for at in inside.into_iter().flat_map(|map| map.positions()) {
            buffer[at].reset();
        }
        text(&buffer)
    };
    for (name, other) in [
        ("light", &light),
        ("no colour", &plain),
        ("sixteen", &sixteen),
    ] {
        match name {
            "no colour" => {
                let (other, dark) = (beside_map(other), beside_map(&dark));
                assert_eq!(other, dark, "{what} at {size:?}, {name}");
            }
            _ => assert_eq!(text(other), words, "{what} at {size:?}, {name}"),
        }
    }
    for (i, cell) in plain.content.iter().enumerate() {
        assert!(
            cell.fg == Color::Reset && cell.bg == Color::Reset,
            "{what} at {size:?}: {cell:?}"
        );
        let at = ratatui::layout::Position::from(plain.pos_of(i));
        for sign in SIGNS
            .into_iter()
            .filter(|_| !map.is_some_and(|map| map.contains(at)))
        {
            let (had, has) = (
                dark.content[i].modifier.contains(sign),
                cell.modifier.contains(sign),
            );
            assert_eq!(had, has, "{what} at {size:?}: {sign:?} of {cell:?}");
        }
    }
    for buffer in [&dark, &light, &sixteen] {
        let hidden = buffer
            .content
            .iter()
            .find(|cell| cell.fg == cell.bg && cell.fg != Color::Reset);
        assert!(
            hidden.is_none(),
            "{what} at {size:?}: {hidden:?} cannot be seen"
        );
    }
    let reversed = |y| plain[(size.0 / 2, y)].modifier.contains(Modifier::REVERSED);
    assert!(
        !selects || (0..size.1).any(reversed),
        "{what} at {size:?}: no line is selected\n{words}"
    );
    words
}

/// Every view at a size, with its name.
fn everything_at(size: (u16, u16)) -> impl Iterator<Item = (&'static str, String)> {
    VIEWS.into_iter().map(move |(what, keys, selects)| {
        let mut bench = bench(keys, size);
        (what, seen_in_every_theme(what, &mut bench, size, selects))
    })
}

#[test]
fn everything_at_80_by_24() {
    for (what, words) in everything_at(SIZES[0]) {
        insta::assert_snapshot!(format!("view_{}", what.replace(' ', "_")), words);
    }
}

#[test]
fn every_theme_shows_everything_at_larger_sizes() {
    for size in &SIZES[1..] {
        for (what, words) in everything_at(*size) {
            assert!(!words.trim().is_empty(), "{what} at {size:?}");
        }
    }
}

/// What has the time of day in it is held against the themes alone.
#[test]
fn the_history_and_the_keys_after_a_prefix_in_every_theme() {
    for size in SIZES {
        let mut kept = three();
        kept.bench.model.size = size;
        seen_in_every_theme("history", &mut kept.bench, size, false);
        let mut bench = Bench::bundled();
        bench.press("g");
        let words = seen_in_every_theme("prefix", &mut bench, size, false);
        assert!(
            words.contains(" g · go to ") && words.contains(" g top"),
            "{words}"
        );
    }
    seen_in_every_theme("too small", &mut Bench::bundled(), (40, 10), false);
}

/// The text of a bundled scenario without the elements of these names.
fn without(xml: &str, names: &[&str]) -> String {
    let mut xml = xml.to_owned();
    for name in names {
        let (open, close) = (format!("<{name} id="), format!("</{name}>"));
        while let Some(from) = xml.find(&open) {
            let to = xml[from..].find(&close).unwrap() + from + close.len();
            xml.replace_range(from..to, "");
        }
    }
    xml
}

/// The same with only the first of the elements of a name.
fn first_alone(xml: &str, name: &str) -> String {
    let close = format!("</{name}>");
    let end = xml.find(&close).unwrap() + close.len();
    xml[..end].to_owned() + &without(&xml[end..], &[name])
}

/// Coordinates and lengths that are `by` times as large.
fn grown(xml: &str, by: f64) -> String {
    let mut out = String::new();
    for (i, part) in xml.split("<x>").enumerate() {
        match (i, part.split_once('<')) {
            (1.., Some((x, rest))) => {
                let x: f64 = x.trim().parse().unwrap();
                out.push_str(&format!("<x>{}<{rest}", x * by));
            }
            _ => out.push_str(part),
        }
    }
    out
}

/// Names and texts.
fn bare() -> Vec<(&'static str, String)> {
    let entries = bundled();
    let mut entries = entries.iter();
    let entry = entries.find(|e| e.name == "ZAM_RightTurn-1_1_T-1").unwrap();
    let xml = entry.source().unwrap();
    let obstacles = ["dynamicObstacle", "staticObstacle"];
    let roads = ["lanelet", "trafficSign", "trafficLight", "intersection"];
    let empty = without(&xml, &obstacles);
    let rest = [&obstacles[..], &roads, &["planningProblem"]].concat();
    vec![
        ("no obstacles", empty.clone()),
        ("one", first_alone(&xml, "dynamicObstacle")),
        ("no road", without(&xml, &roads)),
        ("no problem", without(&xml, &["planningProblem"])),
        (
            "no obstacles and no problem",
            without(&empty, &["planningProblem"]),
        ),
        ("nothing", without(&xml, &rest)),
        (
            "long steps",
            xml.replace("timeStepSize=\"0.1\"", "timeStepSize=\"10\""),
        ),
        (
            "short steps",
            xml.replace("timeStepSize=\"0.1\"", "timeStepSize=\"0.001\""),
        ),
        // The farthest that are read.
        ("far", grown(&xml, 1e3)),
        ("farther", grown(&xml, 5e4)),
    ]
}

/// What the workbench asked the planner for is done at once.
fn planned(bench: &mut Bench) {
    let mut asks = bench
        .effects
        .iter()
        .rev()
        .filter_map(|effect| match effect.request() {
            Some(Plan {
                id,
                entry,
                change,
                forecast,
                planner: 0,
            }) => Some((*id, entry.clone(), *change, *forecast)),
            _ => None,
        });
    let Some((id, entry, change, forecast)) = asks.next() else {
        return;
    };
    let settings = coarse(forecast);
    let thresholds = bench.model.thresholds.clone();
    // A few cycles will do.
    let cancel = Cancel::default();
    let mut cycles = 0;
    let mut on_step = |_, _| {
        cycles += 1;
        if cycles == 400 {
            cancel.ask();
        }
    };
    let mut request = request(&entry, &settings);
    request.open.transform = change;
    let opened = Opened::planned(&request, &thresholds, &cancel, &mut on_step);
    if let Some(opened) = opened.transpose() {
        bench.send(Msg::reply::<Plan>((
            id,
            Update::Ended(opened.map(Box::new)),
        )));
    }
}

#[test]
fn every_view_of_bare_scenarios_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    for (place, (what, xml)) in bare().into_iter().enumerate() {
        let path = folder.path().join(format!("ZAM_Bare-{place}_1_T-1.xml"));
        std::fs::write(&path, xml).unwrap();
        let entry = Entry::of_argument(&path);
        let id = nearmiss_formats::commonroad::read_file(&path)
            .unwrap_or_else(|error| panic!("{what}: {error}"))
            .obstacles
            .first()
            .map(|obstacle| obstacle.id);
        for ego in [EgoSelection::Beside]
            .into_iter()
            .chain(id.map(EgoSelection::Obstacle))
        {
            let mut bench = Bench::empty();
            bench.ego = ego.clone();
            bench.send(Msg::reply::<Find>(Found::All(Ok(
                vec![entry.clone()].into()
            ))));
            // Where nothing is the ego, the workbench plans by itself.
            for plans in [false, true] {
                bench.frame(120, 40);
                if plans {
                    planned(&mut bench);
                }
                for (view, keys, _) in VIEWS.iter().filter(|view| view.0 != "editor") {
                    bench.press(keys);
                    for step in [i64::MIN, 20, i64::MAX] {
                        bench.model.clock.go(step);
                        let lines = bench.frame(160, 45).lines().count();
                        assert_eq!(lines, 45, "{what}: {view}");
                    }
                    bench.press("esc esc esc");
                }
            }
        }
    }
}

/// The first scenario at its contact, with two answers to compare.
fn compared() -> Bench {
    let mut bench = Bench::bundled();
    bench.press("x");
    for (model, dangerous, who) in [("lab/small", false, 302), ("lab/large", true, 301)] {
        bench.model.model = model.into();
        bench.press("r");
        let (id, _) = bench.asked();
        bench.send(bench::answered(
            id,
            Ok(Box::new(answer(model, dangerous, who))),
        ));
    }
    bench.model.toasts.clear();
    bench
}

#[test]
fn at_80_by_24() {
    insta::assert_snapshot!(compared().frame(80, 24));
}

#[test]
fn at_80_by_24_with_the_map() {
    let mut bench = compared();
    bench.model.focus = Pane::Map;
    insta::assert_snapshot!(bench.frame(80, 24));
}

#[test]
fn at_120_by_40() {
    insta::assert_snapshot!(compared().frame(120, 40));
}

#[test]
fn at_200_by_60() {
    insta::assert_snapshot!(compared().frame(200, 60));
}

#[test]
fn models_to_choose_from() {
    let mut bench = Bench::bundled();
    bench.press("m");
    insta::assert_snapshot!(bench.frame(100, 30));
}

#[test]
fn too_small_is_said() {
    for (columns, rows) in [(59, 24), (60, 17), (30, 8)] {
        assert!(
            compared().frame(columns, rows).contains("too small"),
            "{columns}×{rows}"
        );
    }
}

#[test]
fn no_size_is_too_much_or_too_little() {
    let mut bench = compared();
    let overlays = ["", "?", "i", "shift-v", "m", ":", "e"];
    for keys in overlays {
        bench.press(keys);
        for columns in [1, 2, 10, 59, 60, 79, 80, 109, 110, 160, 300] {
            for rows in [1, 2, 5, 17, 18, 24, 31, 32, 90] {
                bench.frame(columns, rows);
            }
        }
        bench.press("esc");
    }
    for pane in Pane::ALL {
        bench.model.focus = pane;
        bench.model.zoomed = true;
        for size in [(80, 24), (120, 40), (200, 60)] {
            bench.frame(size.0, size.1);
        }
    }
}
