//! Panes resized by keys and by the mouse.

use std::collections::HashSet;

use ratatui::layout::{Position, Rect};

use crate::features::details::DetailsScreen;
use crate::layout::{SMALLEST, split};
use crate::message::{Mouse, Msg};
use crate::model::{Model, Pane, Sizes};
use crate::tests::bench::Bench;

/// Terminals of every arrangement.
const SIZES: [(u16, u16); 9] = [
    (60, 18),
    (60, 22),
    (79, 36),
    (79, 60),
    (80, 24),
    (100, 50),
    (110, 32),
    (140, 40),
    (220, 70),
];

fn area(model: &Model, size: (u16, u16), pane: Pane) -> Rect {
    let parts = split(Rect::new(0, 0, size.0, size.1), model).unwrap();
    let found = parts.panes.iter().find(|(p, _)| *p == pane);
    found.unwrap().1
}

/// Presses `ctrl-w` and a key; what is where is known before, as after a frame.
fn chord(bench: &mut Bench, size: (u16, u16), key: &str) {
    let parts = split(Rect::new(0, 0, size.0, size.1), &bench.model).unwrap();
    let drawn = &bench.model.drawn;
    drawn.clear();
    drawn.set_borders(&parts.borders);
    for (pane, area) in parts.panes {
        drawn.pane(pane, area);
    }
    bench.press(&format!("ctrl-w {key}"));
}

#[test]
fn the_pane_with_the_keys_grows_and_shrinks() {
    let size = (200, 60);
    let mut bench = Bench::bundled();
    for (pane, wider, taller) in [
        (Pane::Scenarios, true, true),
        (Pane::Map, true, true),
        (Pane::Prompt, true, true),
        (Pane::Verdict, true, true),
        (Pane::Reasoning, true, true),
        (Pane::Plot, true, true),
    ] {
        bench.model.focus = pane;
        let whole = |model: &Model| {
            let all = area(model, size, pane);
            (all.width, all.height)
        };
        let before = whole(&bench.model);
        chord(&mut bench, size, ">");
        chord(&mut bench, size, "+");
        let after = whole(&bench.model);
        assert_eq!(
            (after.0 == before.0 + 4, after.1 == before.1 + 2),
            (wider, taller),
            "{pane:?}"
        );
        chord(&mut bench, size, "<");
        chord(&mut bench, size, "-");
        assert_eq!(whole(&bench.model), before, "{pane:?}");
    }
    chord(&mut bench, size, ">");
    assert_ne!(bench.model.look.sizes, Sizes::default());
    chord(&mut bench, size, "=");
    assert_eq!(bench.model.look.sizes, Sizes::default());
}

#[test]
fn nothing_vanishes_whatever_is_pressed_and_in_whatever_terminal() {
    for pane in Pane::ALL {
        for keys in ["> +", "< -", "> -", "< +"] {
            let mut bench = Bench::bundled();
            for big in [(70, 36), (80, 24), (200, 60)] {
                bench.model.focus = pane;
                for _ in 0..40 {
                    for key in keys.split(' ') {
                        chord(&mut bench, big, key);
                    }
                }
            }
            for focus in Pane::ALL {
                bench.model.focus = focus;
                for (columns, rows) in SIZES {
                    let screen = Rect::new(0, 0, columns, rows);
                    let parts = split(screen, &bench.model).unwrap();
                    let cells: u32 = parts.panes.iter().map(|(_, a)| a.area()).sum();
                    assert_eq!(cells, u32::from(columns) * u32::from(rows - 2));
                    for (shown, area) in &parts.panes {
                        let small = area.width < 18 || area.height < 4;
                        assert!(!small, "{pane:?} {keys}: {shown:?} {area} of {screen}");
                    }
                }
            }
            bench.frame(80, 24);
        }
    }
}

#[test]
fn beside_a_panel_the_panes_fill_what_is_left_and_the_map_stays() {
    for keys in ["", "> +", "< -"] {
        let mut bench = Bench::bundled();
        for pane in Pane::ALL {
            bench.model.focus = pane;
            for _ in 0..40 {
                for key in keys.split(' ').filter(|key| !key.is_empty()) {
                    chord(&mut bench, (200, 60), key);
                }
            }
        }
        for focus in Pane::ALL {
            bench.model.focus = focus;
            for (columns, rows) in SIZES {
                let screen = Rect::new(0, 0, columns, rows);
                let shows = |model: &Model| split(screen, model).unwrap().panes;
                let shown = |panes: &[(Pane, Rect)]| panes.iter().any(|(p, _)| *p == Pane::Map);
                let map = shown(&shows(&bench.model));
                bench.model.screens.open(DetailsScreen::default());
                let top = bench.model.screens.top().unwrap();
                let panel = top.columns_at_right(screen).unwrap();
                let panes = shows(&bench.model);
                bench.model.screens.pop();
                let cells: u32 = panes.iter().map(|(_, a)| a.area()).sum();
                let left = u32::from(columns - panel) * u32::from(rows - 2);
                assert_eq!(cells, left, "{screen} {focus:?} {panes:?}");
                assert!(panes.iter().all(|(_, a)| a.right() <= columns - panel));
                assert_eq!(shown(&panes), map, "{screen} {focus:?}");
            }
        }
    }
}

#[test]
fn borders_are_dragged_within_limits_and_clicks_on_them_focus() {
    let size = (160, 50);
    let mut bench = Bench::bundled();
    bench.frame(size.0, size.1);
    let before = area(&bench.model, size, Pane::Scenarios);
    let at = |x, y| Position::new(x, y);
    let step = bench.model.clock.step();
    bench.send(Msg::Mouse(Mouse::Press(at(before.right() - 1, 10))));
    for x in [before.right() + 3, before.right() + 9] {
        bench.send(Msg::Mouse(Mouse::Drag(at(x, 12))));
        bench.frame(size.0, size.1);
    }
    bench.send(Msg::Mouse(Mouse::Release(at(before.right() + 9, 12))));
    let after = area(&bench.model, size, Pane::Scenarios);
    assert_eq!(after.width, before.width + 10);
    bench.send(Msg::Mouse(Mouse::Drag(at(40, 12))));
    assert_eq!(area(&bench.model, size, Pane::Scenarios), after, "let go");

    let map = area(&bench.model, size, Pane::Map);
    bench.frame(size.0, size.1);
    bench.send(Msg::Mouse(Mouse::Press(at(map.x + 30, map.bottom()))));
    bench.send(Msg::Mouse(Mouse::Drag(at(map.x + 30, 1))));
    bench.send(Msg::Mouse(Mouse::Release(at(map.x + 30, 1))));
    assert_eq!(area(&bench.model, size, Pane::Map).height, 6, "no smaller");
    assert_eq!(bench.model.clock.step(), step, "no seeking meanwhile");

    let reasoning = area(&bench.model, size, Pane::Reasoning);
    bench.frame(size.0, size.1);
    bench.send(Msg::Mouse(Mouse::Press(at(reasoning.x + 5, reasoning.y))));
    bench.send(Msg::Mouse(Mouse::Release(at(reasoning.x + 5, reasoning.y))));
    assert_eq!(bench.model.focus, Pane::Reasoning);
    assert_eq!(area(&bench.model, size, Pane::Reasoning), reasoning);
}

#[test]
fn in_one_column_every_border_can_be_dragged_and_keeps_its_place() {
    let size = (70, 50);
    let at = |y| Position::new(30, y);
    for focus in Pane::ALL {
        let mut bench = Bench::bundled();
        bench.model.focus = focus;
        bench.frame(size.0, size.1);
        let borders = bench.model.drawn.borders();
        let panes = split(Rect::new(0, 0, size.0, size.1), &bench.model).unwrap();
        assert_eq!(borders.len(), panes.panes.len() - 1, "{focus:?}");
        for place in 0..borders.len() {
            let before = bench.model.drawn.borders()[place];
            // Towards where there is more room.
            let up = before.size < (before.limits.0 + before.limits.1) / 2;
            let to = if up {
                before.strip.y - 1
            } else {
                before.strip.y + 1
            };
            bench.send(Msg::Mouse(Mouse::Press(at(before.strip.y))));
            bench.send(Msg::Mouse(Mouse::Drag(at(to))));
            bench.send(Msg::Mouse(Mouse::Release(at(to))));
            bench.frame(size.0, size.1);
            let after = bench.model.drawn.borders()[place];
            assert_eq!(after.strip.y, to, "{focus:?}: {before:?}");
        }
        let sizes = bench.model.look.sizes;
        assert_ne!(sizes.narrow, Sizes::default().narrow);
        assert_eq!((sizes.wide, sizes.compact), Default::default());
        let saved = toml::to_string(&sizes).unwrap();
        assert_eq!(toml::from_str::<Sizes>(&saved).unwrap(), sizes);
    }
}

#[test]
fn the_keys_move_by_direction() {
    let mut bench = Bench::bundled();
    let walk = [
        ("l", Pane::Map),
        ("l", Pane::Verdict),
        ("l", Pane::Verdict),
        ("j", Pane::Reasoning),
        ("down", Pane::Plot),
        ("h", Pane::Prompt),
        ("k", Pane::Map),
        ("left", Pane::Scenarios),
        ("j", Pane::Prompt),
        ("l", Pane::Plot),
        ("k", Pane::Reasoning),
    ];
    for (key, pane) in walk {
        bench.press(&format!("ctrl-w {key}"));
        assert_eq!(bench.model.focus, pane);
    }
}

#[test]
fn alone_there_is_nothing_to_move() {
    let mut bench = Bench::bundled();
    bench.model.focus = Pane::Plot;
    bench.press("z");
    chord(&mut bench, (120, 40), ">");
    assert_eq!(bench.model.look.sizes, Sizes::default());
    assert!(bench.model.toasts[0].text.contains("take room"));
}

const COLUMNS: [u16; 11] = [60, 61, 79, 80, 100, 109, 110, 120, 160, 200, 300];
const ROWS: [u16; 10] = [18, 19, 20, 22, 24, 31, 32, 45, 60, 100];

/// Fewest columns and rows of a pane: what its frame and a line or two need.
const LEAST: (u16, u16) = (18, 4);

fn shown(model: &Model, (columns, rows): (u16, u16)) -> Vec<(Pane, Rect)> {
    split(Rect::new(0, 0, columns, rows), model).unwrap().panes
}

#[test]
fn panes_tile_the_screen_and_the_focused_one_is_there() {
    let mut bench = Bench::bundled();
    for zoomed in [false, true] {
        bench.model.zoomed = zoomed;
        for focus in Pane::ALL {
            bench.model.focus = focus;
            for size in COLUMNS.into_iter().flat_map(|c| ROWS.map(|r| (c, r))) {
                let panes = shown(&bench.model, size);
                let what = format!("{focus:?} at {size:?}: {panes:?}");
                assert!(panes.iter().any(|(pane, _)| *pane == focus), "{what}");
                let names: HashSet<Pane> = panes.iter().map(|(pane, _)| *pane).collect();
                assert_eq!(names.len(), panes.len(), "{what}");
                let cells: u32 = panes.iter().map(|(_, area)| area.area()).sum();
                assert_eq!(cells, u32::from(size.0) * u32::from(size.1 - 2), "{what}");
                for (i, (_, area)) in panes.iter().enumerate() {
                    let others = panes.iter().skip(i + 1);
                    assert!(others.clone().all(|(_, o)| !o.intersects(*area)), "{what}");
                    assert!(area.width >= LEAST.0 && area.height >= LEAST.1, "{what}");
                }
            }
        }
    }
}

#[test]
fn more_room_shows_more_panes() {
    let mut bench = Bench::bundled();
    bench.model.focus = Pane::Map;
    let count = |size| shown(&bench.model, size).len();
    assert_eq!(count(SMALLEST), 2, "map and verdicts");
    assert_eq!(count((60, 24)), 3, "and the timeline");
    assert_eq!(count((100, 20)), 4, "and the reasoning");
    assert_eq!(count((80, 24)), 5, "and the plot");
    assert_eq!(count((100, 30)), 6, "and what of the list is open");
    assert_eq!(count((160, 24)), 6, "and the list");
    assert_eq!(count((160, 40)), 7, "and the prompt");
    // The list is no wider than what it can say, the map has the rest.
    let panes = shown(&bench.model, (160, 24));
    let width = |wanted: Pane| {
        panes
            .iter()
            .find(|(pane, _)| *pane == wanted)
            .unwrap()
            .1
            .width
    };
    assert!(width(Pane::Scenarios) <= 48 && width(Pane::Map) > width(Pane::Scenarios));
}

#[test]
fn what_is_drawn_stays_inside_its_pane() {
    for size in [
        SMALLEST,
        (60, 40),
        (79, 23),
        (80, 18),
        (100, 20),
        (110, 18),
        (160, 24),
        (300, 100),
    ] {
        let mut bench = Bench::bundled();
        bench.press("x");
        for focus in Pane::ALL {
            bench.model.focus = focus;
            bench.model.toasts.clear();
            let frame = bench.frame(size.0, size.1);
            let lines: Vec<Vec<char>> = frame.lines().map(|line| line.chars().collect()).collect();
            for (pane, area) in shown(&bench.model, size) {
                let (left, right) = (area.x, area.right() - 1);
                let (top, bottom) = (area.y, area.bottom() - 1);
                for (x, y) in [(left, top), (right, top), (left, bottom), (right, bottom)] {
                    let corner = lines[usize::from(y)].get(usize::from(x));
                    let is_corner = corner.is_some_and(|c| "┌┐└┘┏┓┗┛".contains(*c));
                    assert!(is_corner, "{pane:?} with {focus:?} at {size:?}\n{frame}");
                }
                for y in top + 1..bottom {
                    let side = lines[usize::from(y)].get(usize::from(right));
                    let is_side = side.is_some_and(|c| "│┃".contains(*c));
                    assert!(is_side, "{pane:?} with {focus:?} at {size:?}\n{frame}");
                }
            }
        }
    }
}

#[test]
fn a_terminal_that_is_too_small_says_what_is_needed() {
    let frame = Bench::bundled().frame(50, 15);
    let said = "Terminal too small: this is 50×15, nearmiss needs 60×18";
    let words: Vec<&str> = frame.split_whitespace().collect();
    assert!(words.join(" ").contains(said), "{frame}");
    for size in [(59, 18), (60, 17), (1, 1)] {
        assert!(
            !Bench::bundled().frame(size.0, size.1).contains("scenarios"),
            "{size:?}"
        );
    }
}

#[test]
fn a_short_list_leaves_its_height_to_the_map() {
    let mut bench = Bench::bundled();
    let count = u16::try_from(bench.model.list.rows.len()).unwrap();
    let rows = |bench: &Bench, pane: Pane, columns, rows| {
        let screen = ratatui::layout::Rect::new(0, 0, columns, rows);
        let areas = crate::layout::split(screen, &bench.model).unwrap();
        let found = areas.panes.iter().find(|(other, _)| *other == pane);
        found.map_or(0, |(_, area)| area.height)
    };
    bench.model.focus = Pane::Scenarios;
    for (columns, height) in [(200, 60), (100, 60), (70, 60)] {
        let list = rows(&bench, Pane::Scenarios, columns, height);
        assert_eq!(list, count + 4, "{columns}×{height}");
        assert!(rows(&bench, Pane::Map, columns, height) >= 16);
    }
    let short = rows(&bench, Pane::Map, 200, 60);
    // A filter does not move panes, many scenarios do.
    bench.press("/");
    bench.type_text("merge");
    assert_eq!(rows(&bench, Pane::Map, 200, 60), short);
    let entries = bench.model.list.rows[0].entry.clone();
    for _ in 0..60 {
        bench.model.list.append(entries.clone());
    }
    assert!(rows(&bench, Pane::Map, 200, 60) < short);
    assert!(rows(&bench, Pane::Scenarios, 200, 60) > count + 4);
}
