//! The list on the screen: filter, columns, groups, tags, and scenarios that arrive in pieces.

use ratatui::layout::Position;

use super::bench::Bench;
use crate::features::scenarios::request::{Find, Found, Rank, Survey};
use crate::features::scenarios::tags::{ScenarioTags, TagsScreen};
use crate::loaded::{Facts, Verdicts};
use crate::message::{Effect, Mouse, Msg};
use crate::model::{Grouping, Pane};
use crate::theme::ColorDepth;
use nearmiss_formats::{EgoSelection, bundled};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::Task;
use nearmiss_settings::Tags;
use nearmiss_store::{Origin, StoredVerdict};

/// A stored answer about a bundled scenario, recorded by others.
pub fn stored(
    name: &str,
    task: Task,
    window: Option<(i64, i64)>,
    dangerous: bool,
) -> StoredVerdict {
    StoredVerdict {
        scenario_hash: None,
        scenario: name.into(),
        ego: "1".into(),
        origin: Origin::Recorded,
        task,
        window,
        dangerous,
    }
}

/// The bundled scenarios, all of them read; three answers about the first, one about the second.
pub fn surveyed() -> Bench {
    let (one, two) = ("ZAM_HardBraking-1_1_T-1", "ZAM_CutIn-1_1_T-1");
    let verdicts: Verdicts = vec![
        stored(one, Task::Collision, None, true),
        stored(one, Task::Collision, Some((51, 60)), false),
        stored(one, Task::Safety, Some((40, 49)), true),
        stored(one, Task::Safety, None, true),
        stored(two, Task::Collision, None, false),
    ]
    .into();
    let mut bench = Bench::bundled();
    for (place, entry) in bundled().iter().enumerate() {
        let facts = Facts::read(
            entry,
            &EgoSelection::Beside,
            Thresholds::shipped(),
            &verdicts,
        );
        bench.send(Msg::reply::<Survey>((place, facts)));
    }
    bench
}

#[test]
fn answers_are_held_against_the_built_in_judge_and_counted() {
    let bench = surveyed();
    let facts = |place: usize| bench.model.list.rows[place].facts().unwrap();
    let first = facts(0);
    assert_eq!((first.collision.agree, first.collision.differ), (1, 1));
    assert_eq!(
        first.safety.count(),
        1,
        "without a window there is no truth"
    );
    assert_eq!((facts(1).tally().agree, facts(1).tally().differ), (1, 0));
    assert_eq!(facts(2).tally().count(), 0);
    assert!(facts(1).tags.contains(&"cut_in".to_string()));
    assert_eq!(facts(1).country, "ZAM");
    assert!(facts(0).seconds > 5.0);
    let frame = bench.frame(200, 60);
    assert!(frame.contains("≠1/3") && frame.contains("=1"), "{frame}");
    assert!(bench.frame(80, 24).contains('≠'));
}

#[test]
fn at_200_by_60() {
    let mut bench = surveyed();
    bench.model.focus = Pane::Scenarios;
    bench.press("/");
    bench.type_text("zam tag:critical");
    insta::assert_snapshot!(bench.frame(200, 60));
}

#[test]
fn grouped_at_80_by_24() {
    let mut bench = surveyed();
    bench.press("space l g space l g space l g space l g g g enter");
    bench.model.toasts.clear();
    insta::assert_snapshot!(bench.frame(80, 24));
}

#[test]
fn without_colour_everything_is_said() {
    let mut bench = surveyed();
    let coloured = {
        bench.press("z");
        bench.frame(80, 24)
    };
    bench.model.theme = bench.model.theme.clone().at_depth(ColorDepth::None);
    assert_eq!(bench.frame(80, 24), coloured);
    insta::assert_snapshot!(coloured);
}

#[test]
fn matched_letters_are_marked() {
    use ratatui::style::Modifier;
    let mut bench = surveyed();
    bench.press("/");
    bench.type_text("cutin");
    let mut terminal = ratatui::Terminal::new(ratatui::backend::TestBackend::new(120, 40)).unwrap();
    let draw = |f: &mut ratatui::Frame<'_>| crate::views::draw(f, &bench.model);
    terminal.draw(draw).unwrap();
    let buffer = terminal.backend().buffer();
    let row = (0..40)
        .find(|&y| (0..20).any(|x| buffer[(x, y)].symbol() == "▸"))
        .unwrap();
    let marked = (0..24)
        .map(|x| &buffer[(x, row)])
        .filter(|cell| cell.modifier.contains(Modifier::UNDERLINED));
    let letters: String = marked.map(|cell| cell.symbol()).collect();
    assert_eq!(letters.to_lowercase(), "cutin");
}

#[test]
fn a_wrong_term_is_said_in_the_list() {
    let mut bench = surveyed();
    bench.press("/");
    bench.type_text("tga:x");
    for size in [(80, 24), (120, 40)] {
        let frame = bench.frame(size.0, size.1);
        assert!(frame.contains("! unknown filter `tga:`"), "{frame}");
    }
    bench.press("esc ?");
    let help: Vec<String> = (0..40)
        .map(|_| {
            bench.press("pagedown");
            bench.frame(120, 40)
        })
        .collect();
    assert!(help.iter().any(|frame| frame.contains("verdict:differ")));
}

#[test]
fn groups_go_round_and_the_mouse_shuts_them() {
    let mut bench = surveyed();
    bench.press("space l g");
    assert_eq!(bench.model.list.grouping, Grouping::Country);
    let frame = bench.frame(120, 40);
    let row = frame.lines().position(|l| l.contains("- ZAM (8)")).unwrap();
    let at = Position::new(6, u16::try_from(row).unwrap());
    bench.send(Msg::Mouse(Mouse::Press(at)));
    assert!(bench.frame(120, 40).contains("+ ZAM (8)"));
    bench.press("enter space l g space l g space l g space l g");
    assert_eq!(bench.model.list.grouping, Grouping::None);
}

#[test]
fn a_click_meets_the_row_below_filter_and_heads() {
    let mut bench = surveyed();
    bench.press("/");
    bench.type_text("zam");
    bench.press("enter");
    let frame = bench.frame(200, 60);
    let row = frame.lines().position(|l| l.contains("ZAM_Merge")).unwrap();
    let at = Position::new(6, u16::try_from(row).unwrap());
    bench.send(Msg::Mouse(Mouse::Press(at)));
    assert_eq!(
        bench.model.opened.as_ref().unwrap().name,
        "ZAM_Merge-1_1_T-1"
    );
}

#[test]
fn tags_are_typed_kept_and_found() {
    let mut bench = surveyed();
    bench.press("space l t");
    assert!(bench.model.screens.is_top::<TagsScreen>());
    bench.type_text("odd #later");
    let frame = bench.frame(120, 40);
    assert!(frame.contains("tags of ZAM_HardBraking") && frame.contains("critical"));
    bench.press("enter");
    let Ok(ScenarioTags::Change(name, tags)) = bench.effects.pop().unwrap().into_request() else {
        panic!("{:?}", bench.effects);
    };
    assert_eq!(tags, ["odd", "later"]);
    let folder = tempfile::tempdir().unwrap();
    let kept = Tags::change(&folder.path().join("tags.toml"), &name, tags);
    bench.send(Msg::reply::<ScenarioTags>(kept));
    bench.press("/");
    bench.type_text("tag:later");
    assert_eq!(bench.model.list.visible, [0]);
    bench.press("enter space l t");
    assert!(bench.frame(120, 40).contains("# odd later"));
    bench.press("esc");
    bench.send(Msg::reply::<ScenarioTags>(Err("tags.toml: line 2".into())));
    assert_eq!(bench.model.list.visible, [0], "they stay");
    assert!(bench.frame(120, 40).contains("tags.toml: line 2"));
}

#[test]
fn sorting_by_the_same_again_turns_it_around() {
    let mut bench = surveyed();
    for words in [" by obstacles", " by obstacles, reversed"] {
        bench.press("space l s");
        bench.type_text("obstacles");
        bench.press("enter");
        let frame = bench.frame(200, 60);
        assert!(frame.contains(words), "{frame}");
    }
    let list = &bench.model.list;
    let counts = list
        .visible
        .iter()
        .map(|&p| list.rows[p].facts().unwrap().obstacles);
    assert!(counts.is_sorted());
    let ranked = |e: &Effect| matches!(e.request(), Some(Rank::All(..)));
    bench.press("space l s");
    bench.type_text("risk");
    bench.press("enter");
    assert!(
        !bench.effects.iter().any(ranked),
        "the risk is known with the facts"
    );
}

#[test]
fn the_list_fills_while_the_search_goes_on() {
    let mut bench = Bench::empty();
    let mut all = bundled();
    let later = all.split_off(3);
    bench.send(Msg::reply::<Find>(Found::More(all)));
    assert!(bench.model.opened.is_some(), "the first is open already");
    let frame = bench.frame(120, 40);
    assert!(frame.contains("scenarios 3…"), "{frame}");
    bench.press("down");
    let selected = bench.model.list.current();
    bench.send(Msg::reply::<Find>(Found::More(later)));
    bench.send(Msg::reply::<Find>(Found::Ended(Ok(Vec::new()))));
    assert_eq!(bench.model.list.current(), selected);
    assert!(bench.frame(120, 40).contains("scenarios 8 "));
    let asked = bench.effects.iter().map(|effect| match effect.request() {
        Some(Survey::All(entries) | Survey::More(entries)) => entries.len(),
        _ => 0,
    });
    assert_eq!(asked.sum::<usize>(), 8);
}
