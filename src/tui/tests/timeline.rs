//! The timeline: strips, marks, loops, and jumps.

use super::answers::stored_of;
use super::bench::{Bench, answer};
use super::events;
use super::listing::surveyed;
use crate::clock::PlayRange;
use crate::features::answers::LoadStored;
use crate::features::scenarios::request::Survey;
use crate::message::Msg;
use crate::model::{Heat, ShownAnswer};
use crate::update::update;
use nearmiss_study::evaluation::Answer;

/// The rows inside the timeline's frame, its title first.
fn timeline(bench: &Bench, columns: u16, rows: u16) -> Vec<String> {
    let frame = bench.frame(columns, rows);
    let lines: Vec<&str> = frame.lines().collect();
    let from = lines.iter().position(|l| l.contains("· step ")).unwrap();
    let left = lines[from]
        .chars()
        .take_while(|c| *c != '·')
        .collect::<String>();
    let left = left.chars().count() - left.chars().rev().position(|c| c == '┌').unwrap() - 1;
    let cut = |l: &&str| l.chars().skip(left).collect::<String>();
    lines[from..].iter().take(8).map(cut).collect()
}

#[test]
fn strips_show_other_measures_and_none() {
    let mut bench = Bench::bundled();
    bench.press("x");
    let risk = timeline(&bench, 200, 60);
    assert!(
        risk[0].contains("bars grow with danger: full = risk 0"),
        "{risk:#?}"
    );
    let mut seen = vec![risk[1].clone()];
    for (heat, words) in [
        (Heat::Ttc, "full = ttc ≤ 1.50 s"),
        (Heat::Distance, "full = distance ≤ 0.50 m"),
    ] {
        bench.press("space p h");
        assert_eq!(bench.model.heat, heat);
        let now = timeline(&bench, 200, 60);
        assert!(now[0].contains(words), "{now:#?}");
        assert!(!seen.contains(&now[1]), "other bars: {now:#?}");
        seen.push(now[1].clone());
    }
    bench.press("space p m");
    bench.type_text("drac");
    bench.press("enter space p h");
    assert_eq!(bench.model.heat, Heat::Plotted);
    assert!(timeline(&bench, 200, 60)[0].contains("full = drac ≥"));
    bench.press("space p h");
    assert_eq!(bench.model.heat, Heat::Off);
    let off = timeline(&bench, 200, 60).join("\n");
    assert!(!off.contains('█') && off.contains("marks"), "{off}");
    bench.press("space p h");
    assert_eq!(bench.model.heat, Heat::Risk);
}

#[test]
fn the_minimum_of_the_plotted_measure_is_of_the_picked_obstacle_or_of_all() {
    let mut bench = Bench::bundled();
    bench.press("space p m");
    bench.type_text("distance");
    bench.press("enter");
    let nearest = bench
        .model
        .opened
        .as_ref()
        .unwrap()
        .headline
        .clone()
        .unwrap()
        .distance
        .unwrap();
    bench.model.picked = None;
    bench.press("g m");
    assert_eq!(bench.model.clock.step(), nearest.step);
    assert_eq!(bench.model.picked, Some(nearest.obstacle));
    let series = bench.model.plot.series.as_ref().unwrap();
    let other = series
        .obstacles()
        .iter()
        .copied()
        .find(|id| *id != nearest.obstacle)
        .unwrap();
    let row: Vec<f64> = series
        .row("distance", other)
        .iter()
        .filter_map(|r| r.value())
        .collect();
    let least = row.iter().copied().fold(f64::MAX, f64::min);
    bench.model.picked = Some(other);
    bench.press("g m");
    let series = bench.model.plot.series.as_ref().unwrap();
    let here = series
        .at("distance", other, bench.model.clock.step())
        .value();
    assert_eq!(here, Some(least));
    assert_eq!(bench.model.picked, Some(other));
    assert!(
        bench
            .model
            .toasts
            .last()
            .unwrap()
            .text
            .contains("min distance")
    );
    bench.press("space p m");
    bench.type_text("drac");
    bench.press("enter");
    bench.model.picked = None;
    bench.press("g m");
    assert!(bench.model.toasts.last().unwrap().text.contains("max drac"));
}

#[test]
fn loops_go_round_everything_then_the_window() {
    let mut bench = Bench::bundled();
    bench.press("space t l");
    assert_eq!(bench.model.clock.lap(), PlayRange::Whole);
    assert!(timeline(&bench, 120, 40)[0].contains("1× · loop"));
    bench.press("space t l");
    let window = bench.model.window().unwrap();
    assert_eq!(
        bench.model.clock.lap(),
        PlayRange::Part(window.first(), window.last())
    );
    assert!(timeline(&bench, 200, 60)[0].contains("loop 51–60"));
    bench.press("p");
    for _ in 0..40 {
        bench.send(Msg::Passed(std::time::Duration::from_millis(90)));
        let step = bench.model.clock.step();
        assert!((window.first()..=window.last()).contains(&step), "{step}");
    }
    assert!(bench.model.clock.playing);
    bench.press("space t l");
    assert_eq!(bench.model.clock.lap(), PlayRange::Once);
}

/// Three answers of the store about what is open, the second and third of which differ.
fn with_stored(bench: &mut Bench) {
    let of = stored_of(bench);
    let dangerous = bench
        .model
        .answers
        .reference
        .as_ref()
        .unwrap()
        .verdict
        .dangerous;
    let of_model = |model: &str, dangerous: bool, last: i64| Answer {
        window: Some((last - 9, last)),
        ..answer(model, dangerous, 301)
    };
    let answers = vec![
        of_model("lab/right", dangerous, 20),
        of_model("lab/wrong", !dangerous, 30),
        of_model("lab/wrong_too", !dangerous, 50),
    ];
    bench.send(Msg::reply::<LoadStored>((of, answers)));
}

#[test]
fn disagreements_are_marked_and_found_one_after_the_other() {
    let mut bench = surveyed();
    with_stored(&mut bench);
    let steps: Vec<i64> = bench.model.disagreements().iter().map(|d| d.step).collect();
    assert_eq!(steps, [30, 50]);
    let rows = timeline(&bench, 200, 60).join("\n");
    assert!(rows.matches('≠').count() >= 2, "{rows}");
    let model = |bench: &Bench| bench.model.answers.column().map(|c| c.model.clone());
    bench.press("home g d");
    assert_eq!(
        (bench.model.clock.step(), model(&bench)),
        (30, Some("lab/wrong".into()))
    );
    assert!(
        bench
            .model
            .toasts
            .last()
            .unwrap()
            .text
            .starts_with("1 of 2: lab/wrong says no")
    );
    bench.press("g d");
    assert_eq!(
        (bench.model.clock.step(), model(&bench)),
        (50, Some("lab/wrong_too".into()))
    );
    // No other scenario of the list has one: from the first again.
    bench.press("g d");
    assert_eq!(bench.model.clock.step(), 30);
}

#[test]
fn the_next_disagreement_may_be_in_another_scenario() {
    let mut bench = surveyed();
    bench.press("g g down down down");
    assert_eq!(bench.model.list.opened, Some(3));
    bench.press("g d");
    assert_eq!(bench.model.list.opened, Some(0), "the store has one there");
    assert_eq!(bench.model.list.current(), Some(0));
    assert!(bench.model.seek.is_some());
    with_stored(&mut bench);
    assert_eq!(bench.model.clock.step(), 30);
    assert_eq!(bench.model.answers.shown, ShownAnswer::Column(1));
    assert!(bench.model.seek.is_none());
}

#[test]
fn where_nothing_differs_it_is_said() {
    let mut bench = Bench::bundled();
    bench.press("g d");
    let words = &bench.model.toasts.last().unwrap().text;
    assert!(
        words.contains("no answer") && words.contains("8 scenarios are not read"),
        "{words}"
    );
}

#[test]
fn an_answer_that_arrives_is_counted() {
    let mut bench = Bench::bundled();
    bench.model.model = "lab/small".into();
    bench.press("r");
    let (id, _) = bench.asked();
    let effects = update(
        &mut bench.model,
        events::answered(id, Ok(Box::new(answer("lab/small", false, 302)))),
    );
    let counted = effects
        .iter()
        .any(|e| matches!(e.request(), Some(Survey::Again(rows)) if rows.len() == 1));
    assert!(counted, "{effects:?}");
}

#[test]
fn the_picture_at_200_by_60() {
    let mut bench = surveyed();
    with_stored(&mut bench);
    bench.press("home g d space p h");
    bench.model.toasts.clear();
    insta::assert_snapshot!(timeline(&bench, 200, 60).join("\n"));
}
