//! The tour: the key that each step names leads to it, and its answers are labelled as examples.

use nearmiss_study::evaluation::Answer;
use nearmiss_workflow::example_runs;

use crate::features::answers::LoadStored;
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
    let is_key = |word: &&str| word.len() == 1 || word.starts_with(char::is_uppercase);
    let keys = after.split(' ').take_while(is_key);
    let keys = keys.map(|key| match key.len() {
        1 => key.to_string(),
        _ => key.to_lowercase(),
    });
    keys.collect::<Vec<_>>().join(" ")
}

#[test]
fn each_step_is_reached_by_the_key_that_it_names() {
    let reached: [fn(&Model) -> bool; 8] = [
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
        |model| model.prompt.editing,
    ];
    for preset in Preset::ALL {
        let mut bench = on_tour();
        bench.model.look.keymap = Keymap::from_preset(preset);
        for (place, reached) in reached.iter().enumerate() {
            let line = line(&bench);
            let begins = format!(" tour {}/8 · ", place + 1);
            assert!(line.starts_with(&begins), "{preset:?}: {line}");
            bench.press(&named(&line));
            assert!(reached(&bench.model), "{preset:?}: {line}");
        }
        assert_eq!(making::asked(&bench).len(), 1);
        let line = line(&bench);
        assert!(line.starts_with(" tour · that was all"), "{line}");
    }
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
