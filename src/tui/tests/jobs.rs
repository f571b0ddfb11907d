//! Marked scenarios, the card before a batch, and the list of tasks.

use std::sync::Arc;
use std::time::Duration;

use crate::features::batch::request::{AskBatch, BatchAnswer, BatchProgress, EstimateBatch};
use crate::features::history::HistoryScreen;
use crate::features::scenarios::request::{Find, Found, Survey};
use crate::message::{Effect, Msg};
use crate::model::{Batch, Counts, JobId, JobState, Notice, Update};
use crate::tests::bench::{self, Bench, answer, no_verdict};
use nearmiss_store::Consumed;
use nearmiss_study::evaluation::batch::Estimate;

/// The last batch that was to be counted.
fn counted(bench: &Bench) -> (JobId, Arc<Batch>) {
    let mut asks = bench.effects.iter().rev();
    let found = asks.find_map(|effect| match effect.request() {
        Some(EstimateBatch { id, batch }) => Some((*id, Arc::clone(batch))),
        _ => None,
    });
    found.expect("a batch was counted")
}

#[test]
fn windows_are_drawn_as_on_the_command_line_and_the_card_says_which() {
    let mut bench = Bench::bundled();
    bench.model.model = "lab/small".into();
    for (keys, words) in [
        (
            "space a a",
            "10 steps with the contact; safe ones like them",
        ),
        (
            "esc space a t space a a",
            "10 steps up to 1 s before contact; safe ones like them",
        ),
    ] {
        bench.press(keys);
        let (id, batch) = counted(&bench);
        let request = &batch.experiment;
        assert_eq!((request.within, request.every_scenario), (Some(2.0), true));
        let reading = Counts {
            read: (3, 8),
            ..Counts::default()
        };
        bench.send(Msg::reply::<EstimateBatch>((id, Update::Progress(reading))));
        let card = bench.frame(120, 40);
        for words in [words, "3 of 8 recordings read"] {
            assert!(card.contains(words), "{words}: {card}");
        }
        let left_out = Counts {
            left_out: Some("1 safe scenario is not asked about".into()),
            ..counts(8)
        };
        bench.send(Msg::reply::<EstimateBatch>((
            id,
            Update::Progress(left_out),
        )));
        let card = bench.frame(120, 40);
        assert!(
            card.contains("1 safe scenario is not asked about"),
            "{card}"
        );
    }
    bench.press("esc");
    assert!(matches!(bench.effects.last(), Some(Effect::Cancel(_))));
}

fn begun(bench: &Bench) -> Option<JobId> {
    bench
        .effects
        .iter()
        .find_map(|effect| match effect.request() {
            Some(AskBatch { id, .. }) => Some(*id),
            _ => None,
        })
}

fn counts(looked: usize) -> Counts {
    Counts {
        looked,
        estimate: Estimate {
            requests: looked as u64 - 1,
            stored: 1,
            tokens: 12_345,
            usd: 0.1234,
            ..Estimate::default()
        },
        at_once: 4,
        ..Counts::default()
    }
}

/// A batch about all bundled scenarios that was said yes to.
fn asking() -> (Bench, JobId) {
    let mut bench = Bench::bundled();
    bench.model.model = "lab/small".into();
    bench.press("space a a");
    let (id, batch) = counted(&bench);
    assert_eq!(batch.entries.len(), 8);
    bench.send(Msg::reply::<EstimateBatch>((
        id,
        Update::Progress(counts(8)),
    )));
    bench.press("enter");
    assert_eq!(begun(&bench), Some(id));
    bench.send(Msg::reply::<AskBatch>((
        id,
        Update::Progress(BatchProgress::Named("b1".into(), 8)),
    )));
    (bench, id)
}

fn ended(dangerous: bool, truth: bool) -> Result<BatchAnswer, String> {
    let mut answer = answer("lab/small", dangerous, 301);
    answer.consumed = Consumed {
        cost_usd: Some(0.01),
        ..answer.consumed
    };
    Ok(BatchAnswer {
        about: None,
        answer: Box::new(answer),
        truth: Some(truth),
    })
}

#[test]
fn marks_stay_whatever_the_filter() {
    let mut bench = Bench::bundled();
    bench.press("* down *");
    let frame = bench.frame(120, 40);
    assert!(frame.contains("scenarios 8 * 2"), "{frame}");
    assert!(
        frame.contains("▸*ZAM_CutIn") && frame.contains(" *ZAM_HardBraking"),
        "{frame}"
    );
    bench.press("/");
    bench.type_text("merge");
    bench.press("enter");
    assert!(bench.frame(120, 40).contains("1/8 * 2"));
    bench.press("space a a");
    let (_, batch) = counted(&bench);
    let names: Vec<_> = batch.entries.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, ["ZAM_HardBraking-1_1_T-1", "ZAM_CutIn-1_1_T-1"]);
    bench.press("esc esc");
    bench.press("down");
    // The list is read again: what is gone is not counted.
    let left = nearmiss_formats::bundled().split_off(1);
    bench.send(Msg::reply::<Find>(Found::All(Ok(left.into()))));
    assert!(
        bench.frame(120, 40).contains("scenarios 1/7 * 1")
            || bench.frame(120, 40).contains("scenarios 7 * 1")
    );
    bench.perform("unmark-scenarios");
    bench.press("space a a");
    let listed = bench.model.list.visible.len();
    assert_eq!(counted(&bench).1.entries.len(), listed);
}

#[test]
fn nothing_is_asked_before_it_was_counted_and_said_yes_to() {
    let mut bench = Bench::bundled();
    bench.model.model = "lab/small".into();
    bench.press("space a a enter");
    let (id, _) = counted(&bench);
    assert_eq!(begun(&bench), None);
    bench.send(Msg::reply::<EstimateBatch>((
        JobId(0),
        Update::Progress(counts(8)),
    )));
    assert!(
        !bench.model.proposal.as_ref().unwrap().is_counted(),
        "an old count is dropped"
    );
    let mut refused = counts(8);
    refused.refused = Some("a key is needed: set LAB_KEY".into());
    bench.send(Msg::reply::<EstimateBatch>((id, Update::Progress(refused))));
    bench.press("enter");
    assert_eq!(begun(&bench), None);
    assert!(
        bench
            .frame(100, 30)
            .contains("a key is needed: set LAB_KEY")
    );
    bench.send(Msg::reply::<EstimateBatch>((
        id,
        Update::Progress(counts(8)),
    )));
    let card = bench.frame(100, 30);
    for words in [
        "8 listed",
        "1, free",
        "7, 4 at once",
        "12,345",
        "at most $0.1234",
    ] {
        assert!(card.contains(words), "{words}: {card}");
    }
    bench.press("esc");
    assert!(matches!(bench.effects.last(), Some(Effect::Cancel(_))));
    assert!(bench.model.proposal.is_none() && begun(&bench).is_none());
}

#[test]
fn a_batch_ends_with_one_message() {
    let (mut bench, id) = asking();
    bench.model.toasts.clear();
    for (said, truth) in [(true, true), (false, true), (true, true)] {
        bench.send(Msg::reply::<AskBatch>((
            id,
            Update::Progress(BatchProgress::Answered(ended(said, truth))),
        )));
    }
    let header = bench.frame(200, 60).lines().next().unwrap().to_string();
    assert!(
        header.contains("5 running of 8 · spent $0.0300"),
        "{header}"
    );
    for place in 3..7 {
        let why = Err(format!("no answer: fault {place}"));
        bench.send(Msg::reply::<AskBatch>((
            id,
            Update::Progress(BatchProgress::Answered(why)),
        )));
    }
    let silent = BatchAnswer {
        about: None,
        answer: Box::new(no_verdict("lab/small", "I cannot say")),
        truth: Some(true),
    };
    bench.send(Msg::reply::<AskBatch>((
        id,
        Update::Progress(BatchProgress::Answered(Ok(silent))),
    )));
    assert!(bench.model.toasts.is_empty());
    bench.send(Msg::reply::<AskBatch>((id, Update::Ended(Ok(())))));
    assert_eq!(bench.model.toasts.len(), 1);
    let toast = &bench.model.toasts[0];
    assert_eq!(toast.kind, Notice::Error);
    let words = "lab/small on 8 scenarios: 2 agree, 1 differ, 5 failed; first: no answer: fault 3";
    assert_eq!(toast.text, words);
    bench.press("space o j");
    let list = bench.frame(120, 40);
    assert!(
        list.contains("done") && list.contains("8/8") && list.contains("$0.0300"),
        "{list}"
    );
    bench.press("enter");
    assert_eq!(bench.model.history.line, "batch:b1");
    assert!(bench.model.screens.is_top::<HistoryScreen>());
    assert_eq!(bench.model.screens.iter().count(), 1);
}

#[test]
fn cancelling_a_batch_begins_nothing_more_and_twice_ends_what_was_sent() {
    let (mut bench, id) = asking();
    bench.send(Msg::reply::<AskBatch>((
        id,
        Update::Progress(BatchProgress::Answered(ended(true, true))),
    )));
    bench.press("space o j x");
    let stops = |bench: &Bench| {
        let stop = |e: &&Effect| matches!(e, Effect::Cancel(other) if *other == id);
        bench.effects.iter().filter(stop).count()
    };
    assert_eq!(stops(&bench), 1);
    assert_eq!(
        bench.model.jobs.all.last().unwrap().state,
        JobState::Stopping
    );
    bench.press("esc");
    bench.press("ctrl-c");
    assert_eq!(stops(&bench), 2);
    bench.send(Msg::reply::<AskBatch>((id, Update::Ended(Ok(())))));
    let state = &bench.model.jobs.all.last().unwrap().state;
    let words = "1 agree, 0 differ, 0 failed, 7 not asked";
    assert_eq!(*state, JobState::Cancelled(words.into()));
}

#[test]
fn questions_are_listed_with_what_they_took_and_can_be_cancelled() {
    let mut bench = Bench::bundled();
    bench.model.model = "lab/small".into();
    bench.model.uptime = Duration::from_secs(1);
    bench.press("r");
    let (first, _) = bench.asked();
    bench.press("down");
    bench.model.model = "lab/large".into();
    bench.press("r");
    let (second, _) = bench.asked();
    let header = bench.frame(200, 60).lines().next().unwrap().to_string();
    assert!(header.contains("2 running of 2"), "{header}");
    bench.model.uptime = Duration::from_secs(4);
    let mut paid = answer("lab/small", true, 301);
    paid.consumed.cost_usd = Some(0.5);
    bench.send(bench::answered(first, Ok(Box::new(paid))));
    bench.press("space o j");
    let list = bench.frame(120, 40);
    for words in [
        "lab/small on ZAM_HardBraking",
        "2,100 tok",
        "$0.5000",
        "3.0 s",
        "waiting",
        "lab/large on ZAM_CutIn",
    ] {
        assert!(list.contains(words), "{words}: {list}");
    }
    bench.press("x");
    assert!(
        bench
            .effects
            .iter()
            .any(|e| matches!(e, Effect::Cancel(id) if *id == second))
    );
    let failed = bench.model.answers.columns.iter().all(|c| !c.is_running());
    assert!(failed && bench.frame(120, 40).contains("cancelled"));
    bench.press("x");
    assert!(bench.frame(120, 40).contains("already finished"));
}

#[test]
fn surveys_and_rankings_are_listed_and_stopped() {
    let mut bench = Bench::bundled();
    bench.send(Msg::reply::<Survey>((0, Err("x".into()))));
    bench.send(Msg::reply::<Survey>((0, Err("x".into()))));
    bench.press("space o j");
    let list = bench.frame(120, 40);
    assert!(
        list.contains("1/8") && list.contains("the most dangerous moments"),
        "{list}"
    );
    bench.press("shift-x");
    assert!(matches!(
        bench.effects.last().and_then(Effect::request),
        Some(Survey::Stop)
    ));
    assert!(bench.model.jobs.all.iter().all(|job| !job.is_running()));
    let (mut bench, _) = asking();
    for place in 0..8 {
        bench.send(Msg::reply::<Survey>((place, Err("x".into()))));
    }
    assert_eq!(bench.model.jobs.all[0].state, JobState::Done(String::new()));
    for size in [(80, 24), (120, 40), (300, 90)] {
        bench.press("space o j");
        bench.frame(size.0, size.1);
    }
}

#[test]
fn an_answer_of_the_store_costs_nothing() {
    let (mut bench, id) = asking();
    let mut found = ended(true, true).unwrap();
    found.answer.past = Some(nearmiss_study::evaluation::StoredOrigin {
        created_ms: 0,
        origin: nearmiss_store::Origin::Asked,
        sample: 0,
    });
    bench.send(Msg::reply::<AskBatch>((
        id,
        Update::Progress(BatchProgress::Answered(Ok(found))),
    )));
    assert_eq!(bench.model.jobs.cost(), (0.0, 0));
    assert_eq!(bench.model.jobs.all.last().unwrap().tally, (1, 0, 0));
}

#[test]
fn the_card_at_80_by_24() {
    let mut bench = Bench::bundled();
    bench.model.model = "lab/small".into();
    bench.press("space a a");
    let (id, _) = counted(&bench);
    bench.send(Msg::reply::<EstimateBatch>((
        id,
        Update::Progress(counts(8)),
    )));
    insta::assert_snapshot!(bench.frame(80, 24));
}

#[test]
fn tasks_at_80_by_24() {
    let (mut bench, id) = asking();
    bench.send(Msg::reply::<AskBatch>((
        id,
        Update::Progress(BatchProgress::Answered(ended(true, true))),
    )));
    bench.model.toasts.clear();
    bench.press("space o j");
    insta::assert_snapshot!(bench.frame(80, 24));
}
