//! Every size from the smallest to 300×100: panes tile the screen, the one with the keys is there, nothing spills over.

use std::collections::HashSet;

use ratatui::layout::Rect;

use super::bench::Bench;
use crate::layout::{SMALLEST, split};
use crate::model::{Model, Pane};

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
