//! Cancelling a search ends it.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::drive_fixtures::coarse;
use super::variant_fixtures::{SHORT, with};
use super::written::Canned;
use crate::loaded::{
    GenerationInputs, GenerationProgress, GenerationStage, Opened, VariantRequest, Writer,
};
use nearmiss_ask::prompts::Library;
use nearmiss_drive::generation::{
    AllowedAttacks, AttackSetup, ClosedLoop, Progress, VariantGenerator, search_until,
};
use nearmiss_drive::planner::{Cancel, Forecast};
use nearmiss_formats::{EgoSelection, bundled};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_study::evaluation;
use nearmiss_workflow::AttackSource;

/// Any attack on the ego that turns right.
pub fn right_turn() -> VariantRequest {
    let mut all = bundled().into_iter();
    VariantRequest {
        style: Default::default(),
        entry: all.find(|e| e.name.contains("RightTurn")).unwrap(),
        change: None,
        forecast: Forecast::Lane,
        planner: 0,
        only: None,
        wish: None,
        attackers: 1,
        seed: 1,
        writer: None,
        folder: None,
    }
}

#[test]
fn who_cancels_hears_nothing_more() {
    let wish = right_turn();
    let settings = coarse(wish.forecast);
    let thresholds = Thresholds::shipped();
    let ends = [
        |at: GenerationStage| matches!(at, GenerationStage::Driving(4, _)),
        |at: GenerationStage| matches!(at, GenerationStage::Searching(progress, _) if progress.tried > 0),
    ];
    for end in ends {
        let cancel = Cancel::default();
        let mut heard = Vec::new();
        let mut on_event = |event| {
            if let GenerationProgress::Working(at) = event {
                heard.push(at);
                if end(at) {
                    cancel.ask();
                }
            }
        };
        let (ego, how) = (EgoSelection::Beside, with(&settings));
        let made = Opened::generated(&wish, &ego, thresholds, &how, &cancel, &mut on_event);
        assert!(matches!(made, Ok(None)));
        let ended = heard.iter().position(|at| end(*at));
        assert_eq!(ended, Some(heard.len() - 1), "{heard:?}");
    }
}

#[test]
fn a_search_that_is_to_stop_begins_no_motion_and_no_drive_more() {
    let wish = right_turn();
    let settings = coarse(wish.forecast);
    let scenario = wish.entry.read().unwrap();
    let problem = &scenario.planning_problems[0];
    let cancel = Cancel::default();
    let driven = ClosedLoop::watched(
        scenario.clone(),
        problem,
        &settings,
        &cancel,
        &mut |_, _| true,
    );
    let workshop = VariantGenerator::from_closed_loop(driven.unwrap()).unwrap();
    // In the middle of the first round, of 32 motions in groups.
    let asked = AtomicUsize::new(0);
    let stop = || asked.fetch_add(1, Ordering::Relaxed) >= 10;
    let mut last = Progress::default();
    let mut watch = |progress| {
        last = progress;
        asked.load(Ordering::Relaxed) < 10
    };
    let search = |ground: &AttackSetup<'_>| {
        search_until(ground, &SHORT, AllowedAttacks::default(), &mut watch, &stop)
    };
    let found = workshop.on(search).unwrap();
    // Every motion after the tenth is refused unmade, and no further group of motions begins.
    assert!(last.tried >= 10 && last.tried <= 32, "{last:?}");
    assert!(
        last.refused >= last.tried - 10 && last.driven == 0,
        "{last:?}"
    );
    assert_eq!(found.progress(), last);
}

#[test]
fn who_cancels_is_driven_against_nothing_more() {
    let wish = VariantRequest {
        style: Default::default(),
        writer: Some(Box::new(Writer {
            model: "lab/small".into(),
            name: "test".into(),
            library: Library::load(None),
            settings: evaluation::Settings::default(),
            method: evaluation::generating::Method::default(),
            fresh: false,
        })),
        ..right_turn()
    };
    let (settings, thresholds) = (coarse(wish.forecast), Thresholds::shipped());
    for end in [GenerationStage::Proving, GenerationStage::Trying(0, 2)] {
        let cancel = Cancel::default();
        let mut heard = Vec::new();
        let mut on_event = |event| {
            if let GenerationProgress::Working(at) = event {
                heard.push(at);
                if at == end {
                    cancel.ask();
                }
            }
        };
        let how = GenerationInputs {
            settings: &settings,
            planner: None,
            source: AttackSource::Model(&Canned),
        };
        let ego = EgoSelection::Beside;
        let made = Opened::generated(&wish, &ego, thresholds, &how, &cancel, &mut on_event);
        assert!(matches!(made, Ok(None)));
        assert_eq!(heard.last(), Some(&end));
    }
}
