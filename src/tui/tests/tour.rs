//! The tour: the key that each step names leads to it, and its answers are labelled as examples.

use nearmiss_study::evaluation::Answer;
use nearmiss_workflow::example_runs;

use crate::features::answers::LoadStored;
use crate::features::generation::panel::VariantScreen;
use crate::features::results::ResultsScreen;
use crate::features::tour::Tour;
use crate::keymap::{Keymap, Preset};
use crate::message::Msg;
use crate::model::{JobKind, Model, ShownAnswer};
use crate::tests::answers::stored_of;
use crate::tests::bench::Bench;
use crate::tests::making;

/// The tour at its beginning, with the example answers on the open scenario.
fn on_tour() -> Bench {
    let mut bench = Bench::bundled();
    bench.model.tour = Some(Tour::default());
    bench.model.size = (160, 45);
    let name = bench.model.opened.as_ref().unwrap().name.clone();
    let runs = example_runs(1).into_iter();
    let here = runs.filter(|run| run.question.scenario == name);
    let answers: Vec<Answer> = here.map(Answer::from).collect();
    assert_eq!(answers.len(), 2);
    let of = stored_of(&bench);
    bench.send(Msg::reply::<LoadStored>((of, answers)));
    bench
}

fn line(bench: &Bench) -> String {
    bench.frame(160, 45).lines().next().unwrap().to_string()
}

/// The keys that the line of the tour names, as the bench presses them.
fn named(line: &str) -> String {
    let (_, after) = line.split_once(" · ").unwrap();
    let after = after.replace(", then ", " ");
    let is_key = |word: &&str| word.len() == 1 || word.starts_with(char::is_uppercase);
    let keys = after.split(' ').take_while(is_key);
    let keys = keys.map(|key| match key.len() {
        1 => key.to_string(),
        _ => key.to_lowercase(),
    });
    keys.collect::<Vec<_>>().join(" ")
}

/// Presses the keys of a step, whose line is whole in a narrow terminal too.
fn follow(bench: &mut Bench, place: usize) {
    let line = line(bench);
    let begins = format!(" tour {}/9 · ", place + 1);
    assert!(line.starts_with(&begins), "{line}");
    let narrow = bench.frame(80, 24);
    let first = narrow.lines().next().unwrap();
    assert!(!first.ends_with('…'), "{first}");
    bench.press(&named(&line));
}

#[test]
fn each_step_is_reached_by_the_key_that_it_names() {
    let reached: [fn(&Model) -> bool; 7] = [
        |model| model.clock.playing,
        |model| model.answers.shown == ShownAnswer::Column(1),
        |model| model.claims.picked.is_some(),
        |model| model.compare.open,
        |model| model.compare.hides(),
        |model| model.screens.find::<ResultsScreen>().is_some(),
        |model| {
            model
                .jobs
                .all
                .iter()
                .any(|job| job.kind == JobKind::Generate)
        },
    ];
    let ways = Preset::ALL
        .into_iter()
        .flat_map(|p| [(p, false), (p, true)]);
    for (preset, rates) in ways {
        let mut bench = on_tour();
        bench.model.look.keymap = Keymap::from_preset(preset);
        for (place, reached) in reached.iter().enumerate() {
            follow(&mut bench, place);
            assert!(reached(&bench.model), "{preset:?}: {place}");
            if rates && bench.model.compare.hides() {
                bench.press("1");
                assert!(!bench.model.compare.hides());
            }
        }
        assert_eq!(making::asked(&bench).len(), 1);
        assert!(!bench.model.compare.open, "the search is seen");
        bench.press("space g v");
        assert!(bench.model.screens.is_empty(), "nothing to show yet");
        let line = line(&bench);
        assert!(line.starts_with(" tour 8/9 · Space g v "), "{line}");
    }
}

#[test]
fn it_ends_in_the_editor_after_the_variant() {
    let mut bench = making::dangerous();
    bench.model.tour = Some(Tour::default());
    bench.model.size = (160, 45);
    for place in 0..8 {
        follow(&mut bench, place);
    }
    assert!(bench.model.screens.is_top::<VariantScreen>());
    follow(&mut bench, 8);
    assert!(bench.model.prompt.editing);
    let line = line(&bench);
    assert!(line.starts_with(" tour · that was all"), "{line}");
}

#[test]
fn its_line_covers_nothing() {
    let mut bench = on_tour();
    let with = bench.frame(120, 41);
    bench.model.tour = None;
    let (_, below) = with.split_once('\n').unwrap();
    assert_eq!(below, bench.frame(120, 40));
}

#[test]
fn its_answers_are_labelled_as_examples_wherever_they_stand() {
    for run in example_runs(1) {
        assert!(run.question.model.contains("example"), "{run:?}");
        assert_eq!(run.source.as_deref(), Some("an example of nearmiss"));
    }
    let mut bench = on_tour();
    for keys in ["", "g d", "space o c"] {
        bench.press(keys);
        let frame = bench.frame(160, 45);
        for name in ["example-a", "example-b"] {
            assert!(frame.contains(name), "{keys}: {frame}");
        }
    }
}
