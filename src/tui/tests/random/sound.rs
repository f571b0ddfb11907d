//! Invariants of the model.

use std::any::{Any, TypeId};

use crate::features::batch::BatchScreen;
use crate::features::models::Models;
use crate::features::palette::Palette;
use crate::features::picker::{Choice, PickerScreen};
use crate::features::pictures::Pictures;
use crate::features::plot::Measures;
use crate::features::prompt::saving::Templates;
use crate::features::scenarios::Orders;
use crate::features::themes::Themes;
use crate::model::{Line, Model, ShownAnswer};

/// Whether nothing lies over the main screen and nothing is typed.
pub fn on_main_screen(model: &Model) -> bool {
    what_is_open(model).is_empty()
}

/// What is open beside the main screen, in words.
pub fn what_is_open(model: &Model) -> String {
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
pub fn check(model: &Model) {
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
    assert!(list.known <= list.rows.len());
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
        card.is_none() || model.card.is_some(),
        "a card without a batch"
    );
}

fn picker<C: Choice>(model: &Model) {
    if let Some(list) = model.screens.find::<PickerScreen<C>>() {
        let count = list.choice.count(model, &list.picker);
        within("line of the picker", list.picker.selected, count);
    }
}
