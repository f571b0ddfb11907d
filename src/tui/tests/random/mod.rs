//! Random input: keys, text, mouse, resizes, pastes and messages of every kind, in any order.
//!
//! `NEARMISS_RANDOM_CASES` raises the number of sequences, each of [`LENGTH`] inputs; `NEARMISS_RANDOM_SEED` begins
//! with another one, and a failure names the one to repeat it with.

mod plausible;
mod world;

use std::any::{Any, TypeId};
use std::collections::BTreeSet;
use std::ffi::OsString;

use nearmiss_settings::Keys;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use proptest::strategy::ValueTree;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};

use crate::action::ACTIONS;
use crate::features::batch::BatchScreen;
use crate::features::models::Models;
use crate::features::palette::Palette;
use crate::features::picker::{Choice, PickerScreen};
use crate::features::pictures::Pictures;
use crate::features::plot::Measures;
use crate::features::prompt::saving::Templates;
use crate::features::scenarios::Orders;
use crate::features::themes::Themes;
use crate::keymap::{Code, Key, Preset};
use crate::model::{Line, Model, ShownAnswer};
use crate::tests::random::world::{News, World};

/// Inputs of a sequence.
const LENGTH: u64 = 1000;

/// Default number of sequences; one takes about five seconds.
const CASES: u64 = 1;

/// Presses of Esc after which everything is closed, whatever was open.
const ESCAPES: usize = 10;

/// One thing that happens.
#[derive(Debug, Clone)]
pub enum Input {
    /// Keys, one after another.
    Keys(Vec<Key>),
    /// An action by its name in the palette.
    Named(&'static str),
    /// The mouse does something at this part of the screen's width and height.
    Mouse(u8, f64, f64),
    /// The terminal has another size.
    Resize(u16, u16),
    /// Text is pasted.
    Paste(String),
    /// Milliseconds pass.
    Passed(u64),
    /// So many of the things that were asked for are done.
    Done(usize),
    /// An unrequested message arrives.
    News(News),
    /// A frame is drawn.
    Drawn,
    /// Esc is pressed until nothing is open.
    Out,
}

fn key_of_the_table() -> impl Strategy<Value = Vec<Key>> {
    let presets = Preset::ALL.map(crate::keymap::Keymap::from_preset);
    let mut all = Vec::new();
    for keymap in &presets {
        for entry in ACTIONS {
            all.extend(keymap.keys(entry).map(|chord| chord.0.clone()));
        }
    }
    select(all)
}

/// Keys after the digits of a count.
fn counted(count: u32, keys: Vec<Key>) -> Vec<Key> {
    let digits = count.to_string();
    let digits = digits.chars().map(|c| Key::plain(Code::Char(c)));
    digits.chain(keys).collect()
}

fn any_key() -> impl Strategy<Value = Vec<Key>> {
    let codes = [
        Code::Up,
        Code::Down,
        Code::Left,
        Code::Right,
        Code::Home,
        Code::End,
        Code::PageUp,
        Code::PageDown,
        Code::Enter,
        Code::Esc,
        Code::Tab,
        Code::BackTab,
        Code::Backspace,
        Code::Delete,
        Code::Function(1),
        Code::Function(12),
    ];
    let code = prop_oneof![
        3 => select(codes.to_vec()),
        4 => (b' '..=b'~').prop_map(|c| Code::Char(char::from(c))),
        1 => select(vec!['ö', '猫', 'ж', '\u{301}', '\u{1f697}', '\u{202e}']).prop_map(Code::Char),
    ];
    let modifiers = (
        prop::bool::weighted(0.15),
        prop::bool::weighted(0.1),
        prop::bool::weighted(0.1),
    );
    (code, modifiers).prop_map(|(code, (ctrl, alt, shift))| {
        vec![Key {
            code,
            ctrl,
            alt,
            shift: shift && !matches!(code, Code::Char(_)),
        }]
    })
}

fn text() -> impl Strategy<Value = String> {
    select(vec![
        "merge",
        "301 is near at step 20",
        "{{ description }}",
        "{% for",
        "two\nlines\r\nand a third",
        "\u{1b}]0;owned\u{7}\u{1b}[2J",
        "",
        "猫\u{200b}e\u{301}\u{1f468}\u{200d}\u{1f469}",
        "risk<2 obstacles>3",
        "model:lab verdict:dangerous",
        "999999999999999999999999",
    ])
    .prop_map(String::from)
}

fn size() -> impl Strategy<Value = (u16, u16)> {
    prop_oneof![
        3 => (1..=300u16, 1..=100u16),
        2 => select(vec![(80, 24), (100, 30), (110, 32), (120, 40), (200, 60), (300, 100), (1, 1), (60, 18), (79, 24), (100, 20), (160, 24), (59, 17)]),
    ]
}

fn input() -> impl Strategy<Value = Input> {
    let names: Vec<&'static str> = ACTIONS.iter().map(|entry| entry.id).collect();
    prop_oneof![
        40 => key_of_the_table().prop_map(Input::Keys),
        6 => (1..10_000u32, key_of_the_table()).prop_map(|(count, keys)| Input::Keys(counted(count, keys))),
        14 => any_key().prop_map(Input::Keys),
        4 => text().prop_map(|text| Input::Keys(text.chars().map(|c| Key::plain(Code::Char(c))).collect())),
        8 => select(names).prop_map(Input::Named),
        8 => (0..5u8, 0.0..1.1, 0.0..1.1).prop_map(|(what, x, y)| Input::Mouse(what, x, y)),
        2 => size().prop_map(|(columns, rows)| Input::Resize(columns, rows)),
        2 => text().prop_map(Input::Paste),
        5 => prop_oneof![0..100u64, 0..5000u64].prop_map(Input::Passed),
        12 => (1..6usize).prop_map(Input::Done),
        4 => world::news().prop_map(Input::News),
        6 => Just(Input::Drawn),
        1 => Just(Input::Out),
    ]
}

fn from_environment(name: &str, otherwise: u64) -> u64 {
    let said = std::env::var(name).ok();
    said.map_or(otherwise, |n| n.parse().expect(name))
}

/// The person and the terminal of a seed: the same for the same seed.
fn world(seed: u64) -> (World, Vec<Input>) {
    let mut bytes = [0; 32];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &bytes);
    let mut runner = TestRunner::new_with_rng(ProptestConfig::default(), rng);
    let keys = select(vec![Keys::Plain, Keys::Vim, Keys::Emacs]);
    let preset = select(Preset::ALL.to_vec());
    let length = from_environment("NEARMISS_RANDOM_LENGTH", LENGTH);
    let inputs = vec(input(), usize::try_from(length).unwrap());
    let tree = (keys, preset, size(), inputs).new_tree(&mut runner);
    let (keys, preset, size, inputs) = tree.unwrap().current();
    (World::new(keys, preset, size), inputs)
}

/// What is in the folder that the tests run in.
fn working_folder() -> BTreeSet<OsString> {
    let entries = std::fs::read_dir(".").unwrap();
    entries.map(|entry| entry.unwrap().file_name()).collect()
}

#[test]
fn whatever_happens_nothing_breaks_and_esc_leads_out() {
    let first = from_environment("NEARMISS_RANDOM_SEED", 1);
    let cases = from_environment("NEARMISS_RANDOM_CASES", CASES);
    let before = working_folder();
    for seed in first..first + cases {
        let (mut world, inputs) = world(seed);
        world.told = format!("NEARMISS_RANDOM_SEED={seed}");
        for input in &inputs {
            world.take(input);
        }
        world.out();
        world.draw();
    }
    assert_eq!(working_folder(), before, "keys write files");
}

/// Whether nothing lies over the main screen and nothing is typed.
fn on_main_screen(model: &Model) -> bool {
    what_is_open(model).is_empty()
}

/// What is open beside the main screen, in words.
fn what_is_open(model: &Model) -> String {
    let open = [
        (!model.screens.is_empty(), format!("{:?}", model.screens)),
        (model.compare.open, format!("{:?}", model.compare)),
        (
            model.prompt.editing,
            format!("the editor, {}", model.prompt.editor.mode()),
        ),
        (model.list.filtering.is_some(), "the filter".into()),
        (model.zoomed, "one pane alone".into()),
        (!model.look.pending.is_empty(), "a chord".into()),
        (model.map.tape.is_some(), "the tape".into()),
    ];
    let words: Vec<String> = open
        .into_iter()
        .filter(|(open, _)| *open)
        .map(|(_, what)| what)
        .collect();
    words.join(", ")
}

/// Every place in a list is one of it, and everything that is named is there.
fn check(model: &Model) {
    list(model);
    scene(model);
    answers(model);
    screens(model);
    let (history, jobs) = (&model.history, &model.jobs);
    within("run", history.selected, history.rows.len());
    within("task", jobs.selected, jobs.all.len());
    let (row, column) = model.prompt.editor.cursor();
    within("line of the editor", row, model.prompt.editor.line_count());
    let columns = model.prompt.editor.lines().nth(row).map_or(0, Vec::len);
    assert!(
        column <= columns,
        "column {column} of {columns} in the editor"
    );
}

/// A selection is one of the lines, or the first of none.
#[track_caller]
fn within(what: &str, place: usize, count: usize) {
    assert!(place < count.max(1), "{what} {place} of {count}");
}

fn list(model: &Model) {
    let list = &model.list;
    within("line", list.selected, list.lines.len());
    for line in &list.lines {
        match line {
            Line::Head(group) => assert!(*group < list.groups.len()),
            Line::Scenario(place, group) => {
                assert!(*place < list.rows.len());
                assert!(group.is_none_or(|group| group < list.groups.len()));
            }
        }
    }
    assert!(list.opened.is_none_or(|place| place < list.rows.len()));
    assert!(list.facts_read <= list.rows.len());
    let source = model.source.as_ref();
    assert!(source.is_none_or(|(place, _)| *place < list.rows.len()));
}

fn scene(model: &Model) {
    let camera = &model.camera;
    let numbers = [
        camera.cell,
        camera.aspect,
        camera.center.x,
        camera.center.y,
        camera.shift.x,
        camera.shift.y,
    ];
    assert!(
        numbers.iter().all(|n| n.is_finite()) && camera.cell > 0.0,
        "{camera:?}"
    );
    let (first, last) = model.clock.range();
    assert!(
        (first..=last).contains(&model.clock.step()),
        "{:?}",
        model.clock
    );
    let Some(opened) = &model.opened else {
        assert!(model.picked.is_none() && model.taken.is_none());
        return;
    };
    let steps = opened.steps();
    assert!(
        steps.is_empty() || (first, last) == (steps.start, steps.end - 1),
        "the clock is that of another scenario"
    );
    let named = model
        .picked
        .iter()
        .chain(&model.plot.marked)
        .chain(&model.taken);
    for id in named {
        assert!(
            opened.scenario.obstacle(*id).is_some(),
            "obstacle {id} of {}",
            opened.name
        );
    }
}

fn answers(model: &Model) {
    let answers = &model.answers;
    let there = |shown: &ShownAnswer| match shown {
        ShownAnswer::Reference => true,
        ShownAnswer::Column(place) => *place < answers.columns.len(),
    };
    assert!(
        there(&answers.shown),
        "{:?} of {}",
        answers.shown,
        answers.columns.len()
    );
    let compare = &model.compare;
    if !compare.open {
        return;
    }
    assert!(compare.shown.iter().all(there), "{:?}", compare.shown);
    within("column", compare.focus, compare.shown.len());
    let count = compare.shown.len();
    assert!(compare.tops.len() == count && compare.marks.len() == count);
    assert!(
        compare.marking.is_none() || count > 0,
        "nothing is there to be marked"
    );
}

fn screens(model: &Model) {
    let kinds: Vec<TypeId> = model
        .screens
        .iter()
        .map(|s| (s as &dyn Any).type_id())
        .collect();
    for (i, kind) in kinds.iter().enumerate() {
        let twice = kinds[i + 1..].contains(kind);
        assert!(!twice, "twice open: {:?}", model.screens);
    }
    picker::<Palette>(model);
    picker::<Themes>(model);
    picker::<Pictures>(model);
    picker::<Models>(model);
    picker::<Templates>(model);
    picker::<Measures>(model);
    picker::<Orders>(model);
    let card = model.screens.find::<BatchScreen>();
    assert!(
        card.is_none() || model.proposal.is_some(),
        "a card without a batch"
    );
}

fn picker<C: Choice>(model: &Model) {
    if let Some(list) = model.screens.find::<PickerScreen<C>>() {
        let count = list.choice.count(model, &list.picker);
        within("line of the picker", list.picker.selected, count);
    }
}
