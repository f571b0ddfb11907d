//! A search ends where somebody says so.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::driven::coarse;
use super::generated::with;
use crate::generation::Progress;
use crate::metrics::Thresholds;
use crate::planner::Forecast;
use crate::scenario::{WantedEgo, bundled};
use crate::tui::loaded::{Opened, Wish, Working};

/// Any attack on the ego that turns right.
pub fn right_turn() -> Wish {
    let mut all = bundled().into_iter();
    Wish {
        entry: all.find(|e| e.name.contains("RightTurn")).unwrap(),
        change: None,
        forecast: Forecast::Lane,
        only: None,
        seed: 1,
        writer: None,
        folder: None,
    }
}

#[test]
fn who_says_no_is_asked_for_nothing_more() {
    let wish = right_turn();
    let settings = coarse(wish.forecast);
    let thresholds = Thresholds::shipped();
    let ends = [
        |at: Working| matches!(at, Working::Driving(4, _)),
        |at: Working| matches!(at, Working::Searching(progress, _) if progress.tried > 0),
    ];
    for end in ends {
        let mut heard = Vec::new();
        let mut watch = |at| {
            heard.push(at);
            !end(at)
        };
        let how = with(&settings, &|| false);
        let made = Opened::generated(&wish, &WantedEgo::Beside, thresholds, &how, &mut watch);
        assert!(matches!(made, Ok(None)));
        let said_no = heard.iter().position(|at| end(*at));
        assert_eq!(said_no, Some(heard.len() - 1), "{heard:?}");
    }
}

#[test]
fn a_search_that_is_to_stop_begins_no_motion_and_no_drive_more() {
    let wish = right_turn();
    let settings = coarse(wish.forecast);
    let thresholds = Thresholds::shipped();
    // Somebody says so in the middle of the first round, of 32 motions.
    let asked = AtomicUsize::new(0);
    let stop = || asked.fetch_add(1, Ordering::Relaxed) >= 10;
    let mut last = Progress::default();
    let mut watch = |at| {
        if let Working::Searching(progress, _) = at {
            last = progress;
        }
        asked.load(Ordering::Relaxed) < 10
    };
    let how = with(&settings, &stop);
    let made = Opened::generated(&wish, &WantedEgo::Beside, thresholds, &how, &mut watch);
    assert!(matches!(made, Ok(None)));
    assert!(last.refused >= 22 && last.driven == 0, "{last:?}");
}
