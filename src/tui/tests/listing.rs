//! The list of scenarios: facts, tags, saved views, the search, and ten thousand rows.

use std::path::Path;
use std::time::{Duration, Instant};

use nearmiss_formats::{EgoSelection, Entry, bundled};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::Task;
use nearmiss_settings::{Folders, SavedView, SavedViews, Tags};
use nearmiss_store::{Origin, StoredVerdict};
use nearmiss_workflow::find_in_pieces;
use ratatui::layout::Position;

use crate::features::generation::request::write;
use crate::features::scenarios::request::{Find, Found, Rank, Survey};
use crate::features::scenarios::saved_views::ListViews;
use crate::features::scenarios::tags::{ScenarioTags, TagsScreen};
use crate::loaded::{Facts, GenerationStage, Opened, Ranked, StandInEgo, Verdicts};
use crate::message::{Effect, Mouse, Msg};
use crate::model::{Grouping, JobKind, JobState, OpenId, Order, Pane};
use crate::tests::bench::{self, Bench};
use crate::tests::editing::said;
use crate::tests::making::{self, arrive, asked, dangerous, open, shown, stopped};
use crate::theme::ColorDepth;
use crate::update::{Open, update};

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
    survey(&mut bench, &verdicts);
    bench
}

/// All bundled scenarios are read.
fn survey(bench: &mut Bench, verdicts: &Verdicts) {
    for (place, entry) in bundled().iter().enumerate() {
        let facts = Facts::read(
            entry,
            &EgoSelection::Beside,
            Thresholds::shipped(),
            verdicts,
        );
        bench.send(Msg::reply::<Survey>((place, facts)));
    }
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

/// What the list orders the scenarios by that are severest, as its first rows show it.
fn severest(bench: &Bench, count: usize) -> Vec<(u8, String)> {
    let list = &bench.model.list;
    let places = list.visible.iter().take(count);
    let worst = places.map(|&p| {
        let headline = list.rows[p].facts().unwrap().headline.as_ref().unwrap();
        *headline.worst().unwrap()
    });
    let frame = bench.frame(200, 60);
    worst
        .map(|moment| {
            let (word, value, unit) = moment.measured().unwrap();
            let digits = if value < 10.0 { 2 } else { 1 };
            let finer = format!("{word} {value:.digits$} {unit}");
            assert!(frame.contains(&finer), "{finer}: {frame}");
            (moment.grade.number(), finer)
        })
        .collect()
}

#[test]
fn four_keys_lead_to_the_severest_scenario_and_no_two_are_alike() {
    let mut bench = surveyed();
    bench.press("down down");
    bench.press("space l s enter");
    bench.send(Msg::Drawing);
    let list = &bench.model.list;
    assert_eq!((list.order, list.selected), (Order::Severity, 0));
    assert_eq!(list.opened, Some(list.visible[0]), "it is open");
    let mut all = severest(&bench, 8);
    assert!(all.iter().map(|(grade, _)| grade).is_sorted());
    all.dedup();
    assert_eq!(all.len(), 8, "{all:?}");
    // The same keys lead back to the order of before, and leave open what is open.
    let opened = bench.model.list.opened;
    bench.press("space l s enter");
    bench.send(Msg::Drawing);
    assert_eq!(bench.model.list.order, Order::Found);
    assert_eq!(bench.model.list.opened, opened);
}

#[test]
fn the_severest_is_opened_when_all_are_read_unless_a_key_came_before() {
    for stays in [false, true] {
        let mut bench = Bench::bundled();
        bench.press("down");
        let opened = bench.model.list.opened;
        bench.press("space l s enter");
        bench.send(Msg::Drawing);
        assert_eq!(bench.model.list.opened, opened, "nothing is known yet");
        if stays {
            bench.press("right");
        }
        survey(&mut bench, &Verdicts::default());
        bench.send(Msg::Drawing);
        let list = &bench.model.list;
        assert_ne!(list.visible[0], opened.unwrap());
        let expected = if stays { opened } else { Some(list.visible[0]) };
        assert_eq!(list.opened, expected);
    }
}

#[test]
fn for_an_order_by_danger_the_planner_drives_who_has_no_ego() {
    let mut bench = surveyed();
    bench.press("down down down");
    let opened = bench.model.list.opened;
    let facts = |row: usize, bench: &mut Bench| {
        let facts = bench.model.list.rows[row].facts.as_mut();
        facts.unwrap().as_mut().unwrap().headline.take()
    };
    let headline = facts(0, &mut bench);
    facts(5, &mut bench);
    bench.press("space l s enter");
    bench.send(Msg::Drawing);
    bench.send(Msg::Drawing);
    let asked = bench.effects.iter().filter_map(|e| match e.request() {
        Some(Rank::All("severity", entries)) => Some(entries),
        _ => None,
    });
    let asked: Vec<_> = asked.flatten().map(|(place, _)| *place).collect();
    assert_eq!(asked, [0, 5], "once");
    assert_eq!(bench.model.list.opened, opened, "not all is known yet");
    assert!(said(&bench).contains("once the planner has tried to drive them"));
    let frame = bench.frame(160, 45);
    assert!(frame.contains("no ego in 2: the planner drives"), "{frame}");
    let stand_in = headline.map(|headline| StandInEgo {
        obstacle: None,
        headline,
        seconds: 3.0,
    });
    let found = Ranked {
        value: None,
        stand_in,
    };
    bench.send(Msg::reply::<Rank>(("severity", 0, found)));
    bench.send(Msg::reply::<Rank>(("severity", 5, Ranked::default())));
    bench.send(Msg::Drawing);
    let list = &bench.model.list;
    assert!(!list.rows[0].lacks_ego() && list.rows[5].lacks_ego());
    assert_eq!(list.visible.last(), Some(&5));
    assert_eq!(list.opened, Some(list.visible[0]));
    // The row keeps the reason for its place.
    bench.model.zoomed = true;
    let frame = bench.frame(200, 60);
    let row = frame.lines().find(|line| line.contains(" planned "));
    let has_reason = |row: &str| row.contains("serious 0.57 %") && row.contains(" 0X");
    assert!(row.is_some_and(has_reason), "{frame}");
    assert!(frame.contains("no ego in 1 "), "{frame}");
}

#[test]
fn an_order_that_needs_no_drives_ends_them_and_keeps_what_was_driven() {
    let mut bench = surveyed();
    bench.press("down down down");
    let take = |row: usize, bench: &mut Bench| {
        let facts = bench.model.list.rows[row].facts.as_mut();
        facts.unwrap().as_mut().unwrap().headline.take()
    };
    let headline = take(0, &mut bench);
    take(5, &mut bench);
    bench.press("space l s enter");
    bench.send(Msg::Drawing);
    bench.effects.clear();
    bench.press("space l s enter");
    assert_eq!(bench.model.list.order, Order::Found);
    let stops = |e: &Effect| matches!(e.request(), Some(Rank::Stop));
    assert!(bench.effects.iter().any(stops));
    let mut jobs = bench.model.jobs.all.iter();
    assert!(!jobs.any(|job| job.is_running() && matches!(job.kind, JobKind::Ranking(_))));
    let stand_in = headline.map(|headline| StandInEgo {
        obstacle: None,
        headline,
        seconds: 3.0,
    });
    let late = Ranked {
        value: None,
        stand_in,
    };
    bench.send(Msg::reply::<Rank>(("severity", 0, late)));
    bench.press("space l s enter");
    bench.send(Msg::Drawing);
    let asked = bench.effects.iter().find_map(|e| match e.request() {
        Some(Rank::All("severity", entries)) => Some(entries.iter().map(|(place, _)| *place)),
        _ => None,
    });
    assert!(asked.unwrap().eq([5]), "the ego of the first is known");
    assert!(bench.model.list.leads);
    bench.press("space o j x");
    assert!(!bench.model.list.leads, "nothing opens after a cancel");
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

const MANY: usize = 2_000;

fn entries() -> Vec<Entry> {
    let countries = ["DEU", "USA", "ESP", "CHN"];
    let name = |i: usize| format!("f{}/{}_Town{i:04}-1_1_T-1.xml", i % 7, countries[i % 4]);
    (0..MANY)
        .map(|i| Entry::of_file(Path::new(&name(i))))
        .collect()
}

/// The least time that something takes of several tries: others use the machine too.
fn least(mut what: impl FnMut()) -> Duration {
    let tries = (0..21).map(|_| {
        let begun = Instant::now();
        what();
        begun.elapsed()
    });
    tries.min().unwrap()
}

fn facts() -> Facts {
    let read = |entry: &Entry| {
        Facts::read(
            entry,
            &EgoSelection::Beside,
            Thresholds::shipped(),
            &Verdicts::default(),
        )
    };
    read(&bundled()[0]).unwrap()
}

#[test]
fn the_first_frame_counts_thousands() {
    let mut bench = Bench::empty();
    drop(update(
        &mut bench.model,
        Msg::reply::<Find>(Found::More(entries())),
    ));
    drop(update(&mut bench.model, Msg::Drawing));
    assert!(bench.frame(200, 60).contains("scenarios 2000"));
}

#[test]
fn a_frame_costs_the_same_for_thousands_and_for_few() {
    let frames = |count: usize| {
        let mut bench = Bench::empty();
        drop(update(
            &mut bench.model,
            Msg::reply::<Find>(Found::More(entries()[..count].to_vec())),
        ));
        drop(update(&mut bench.model, Msg::Drawing));
        least(|| drop(bench.frame(200, 60)))
    };
    let (few, many) = (frames(60), frames(MANY));
    assert!(many < few * 3, "{few:?} {many:?}");
}

#[test]
fn what_arrives_is_sorted_once_a_frame() {
    let mut bench = Bench::empty();
    drop(update(
        &mut bench.model,
        Msg::reply::<Find>(Found::More(entries())),
    ));
    bench.model.list.sort_by(crate::model::Order::Obstacles);
    let facts = facts();
    let arriving = least(|| {
        for place in 0..MANY {
            drop(update(
                &mut bench.model,
                Msg::reply::<Survey>((place, Ok(facts.clone()))),
            ));
        }
    });
    let settling = least(|| {
        drop(update(
            &mut bench.model,
            Msg::reply::<Survey>((0, Ok(facts.clone()))),
        ));
        drop(update(&mut bench.model, Msg::Drawing));
    });
    // Sorting at every message would take as long as sorting two thousand times.
    assert!(arriving < settling * 60, "{arriving:?} {settling:?}");
    assert_eq!(bench.model.list.facts_read, MANY);
}

#[test]
fn what_is_on_the_screen_is_asked_for_first_and_once() {
    let mut bench = Bench::empty();
    drop(update(
        &mut bench.model,
        Msg::reply::<Find>(Found::More(entries())),
    ));
    drop(update(&mut bench.model, Msg::Drawing));
    bench.frame(120, 40);
    bench.model.list.selected = 1_000;
    bench.frame(120, 40);
    let mut asked = update(&mut bench.model, Msg::Drawing);
    let Ok(Survey::First(places)) = asked.pop().unwrap().into_request() else {
        panic!("{asked:?}");
    };
    assert!(places.contains(&1_000) && places.len() < 60, "{places:?}");
    assert!(update(&mut bench.model, Msg::Drawing).is_empty(), "once");
    assert_eq!(bench.model.list.current(), Some(1_000));
}

#[test]
fn folders_of_thousands_come_in_pieces_and_whole() {
    let folder = tempfile::tempdir().unwrap();
    for i in 0..700 {
        let below = folder.path().join(format!("f{}", i % 3));
        std::fs::create_dir_all(&below).unwrap();
        std::fs::write(below.join(format!("s{i:03}.xml")), "<commonRoad/>").unwrap();
    }
    std::fs::write(folder.path().join("empty.xml"), "").unwrap();
    let paths = [folder.path().to_path_buf()];
    let mut pieces = Vec::new();
    let passed_over = find_in_pieces(&paths, &mut |piece| pieces.push(piece)).unwrap();
    assert_eq!(passed_over.len(), 1);
    assert!(
        pieces.len() > 2 && pieces[0].len() == 64,
        "{}",
        pieces.len()
    );
    let mut all: Vec<String> = pieces.iter().flatten().map(Entry::display).collect();
    assert_eq!(all.len(), 700);
    assert!(all.is_sorted(), "folders and files come by name");
    let found = nearmiss_formats::find(&paths).unwrap();
    all.sort();
    let whole: Vec<String> = found.entries.iter().map(Entry::display).collect();
    assert_eq!(all, whole);
    let nothing = tempfile::tempdir().unwrap();
    let error = find_in_pieces(&[nothing.path().to_path_buf()], &mut |_| {}).unwrap_err();
    assert!(error.to_string().contains("no CommonRoad scenario"));
}

/// Does on the disk what was asked for, in a folder of its own.
fn kept(bench: &mut Bench, folders: &Folders) {
    for effect in std::mem::take(&mut bench.effects) {
        let path = folders.views();
        let views = match effect.into_request() {
            Ok(ListViews::Read) => SavedViews::read(&path),
            Ok(ListViews::Change(name, view)) => SavedViews::change(&path, &name, view),
            Err(_) => continue,
        };
        bench.send(Msg::reply::<ListViews>(views));
    }
}

#[test]
fn a_view_is_saved_chosen_again_and_deleted() {
    let folder = tempfile::tempdir().unwrap();
    let folders = Folders {
        config: folder.path().join("config"),
        data: folder.path().join("data"),
    };
    let mut bench = Bench::bundled();
    bench.model.list.sort_by(Order::Name);
    bench.model.list.sort_by(Order::Name);
    bench.model.list.group_by(Grouping::Country);
    bench.model.list.set_filter("mer".into());
    let shown = bench.model.list.lines.clone();
    bench.perform("saved-views");
    kept(&mut bench, &folders);
    let frame = bench.frame(80, 24);
    let now = "type a name to save the list as it is: mer · sorted by name reversed · by country";
    assert!(frame.contains(&now[..60]), "{frame}");
    bench.type_text("merging, by name");
    assert!(bench.frame(80, 24).contains("save as `merging, by name`"));
    bench.press("enter");
    kept(&mut bench, &folders);

    let mut later = Bench::bundled();
    assert_ne!(later.model.list.lines, shown);
    later.perform("saved-views");
    kept(&mut later, &folders);
    insta::assert_snapshot!("saved_views_at_80_by_24", later.frame(80, 24));
    later.press("enter");
    assert_eq!(later.model.list.view(), bench.model.list.view());
    assert_eq!(later.model.list.lines, shown);
    assert!(later.model.screens.is_empty());

    later.perform("saved-views");
    later.press("ctrl-d");
    kept(&mut later, &folders);
    let there = |bench: &Bench| bench.model.list.views.iter().count();
    assert_eq!(there(&later), 1, "one press deletes nothing");
    assert!(later.frame(80, 24).contains("Ctrl-D again deletes"));
    later.press("ctrl-d");
    kept(&mut later, &folders);
    assert_eq!(there(&later), 0);
}

#[test]
fn what_is_not_known_of_a_view_is_named_and_the_rest_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("views.toml");
    let view = SavedView::new("mer", "sparkle", true, "mood");
    let views = SavedViews::change(&path, "newer", Some(view)).unwrap();
    let mut bench = Bench::bundled();
    bench.send(Msg::reply::<ListViews>(Ok(views)));
    bench.perform("saved-views");
    bench.press("enter");
    assert!(said(&bench).contains("the order `sparkle` and the grouping `mood`"));
    assert_eq!(bench.model.list.filter, "mer");
    assert_eq!(bench.model.list.order, Order::Found);
    bench.send(Msg::reply::<ListViews>(Err(
        "views.toml: line 2: broken".into()
    )));
    assert!(said(&bench).contains("line 2"));
    assert_eq!(bench.model.list.views.iter().count(), 1);
}

#[test]
fn a_search_can_be_cancelled_and_ends_when_something_else_opens() {
    let mut bench = open("rightturn");
    bench.press("space g g esc");
    assert_eq!((asked(&bench).len(), stopped(&bench)), (1, 0));
    let frame = bench.frame(80, 24);
    assert!(frame.contains("Esc again cancels"), "{frame}");
    bench.press("esc");
    assert_eq!((asked(&bench).len(), stopped(&bench)), (1, 1));
    assert!(bench.model.generation.under_way.is_none());
    let state = |bench: &Bench| bench.model.jobs.all.last().unwrap().state.clone();
    assert_eq!(state(&bench), JobState::Stopping);
    for (columns, rows) in [(80, 24), (200, 60)] {
        let frame = bench.frame(columns, rows);
        assert!(
            frame.lines().next().unwrap().contains("cancelling…"),
            "{frame}"
        );
    }
    // What still arrives of it is dropped.
    let (id, _) = asked(&bench).pop().unwrap();
    bench.send(bench::generating(id, GenerationStage::Proving));
    assert_eq!(state(&bench), JobState::Stopping);
    arrive(&mut bench);
    assert!(bench.model.variant().is_none());
    assert!(matches!(state(&bench), JobState::Cancelled(_)));
    assert!(!bench.frame(200, 60).contains("cancelling…"));
    bench.press("space g g space g g");
    assert_eq!((asked(&bench).len(), stopped(&bench)), (2, 1));
    assert!(
        making::said(&bench).contains("generating"),
        "{}",
        making::said(&bench)
    );
    // Another key between the two, or a long wait, takes the first one back.
    bench.press("esc x esc");
    bench.send(Msg::Passed(std::time::Duration::from_secs(5)));
    bench.press("esc");
    assert_eq!(stopped(&bench), 1);
    bench.press("esc");
    assert_eq!((asked(&bench).len(), stopped(&bench)), (2, 2));
    bench.press("space g g space o j x esc");
    assert_eq!((asked(&bench).len(), stopped(&bench)), (3, 3));
    bench.press("/");
    for _ in 0..9 {
        bench.press("space e r");
    }
    bench.press("enter space g g down");
    assert_eq!((asked(&bench).len(), stopped(&bench)), (4, 4));
}

#[test]
fn a_search_asked_for_while_the_scenario_is_read_begins_when_it_is_open() {
    let mut bench = open("rightturn");
    let place = bench.model.list.opened.unwrap();
    bench.model.opening = Some((OpenId(1_000_000), None));
    bench.press("space g g");
    assert!(asked(&bench).is_empty());
    assert!(
        making::said(&bench).contains("still being read"),
        "{}",
        making::said(&bench)
    );
    let opened = bench.model.opened.clone().unwrap();
    bench.send(Msg::reply::<Open>((OpenId(1_000_000), Ok(opened))));
    assert_eq!(asked(&bench).len(), 1);
    assert_eq!(bench.model.list.opened, Some(place));
}

#[test]
fn a_saved_variant_has_its_original_beside_it_and_opens_it() {
    let made = shown(&dangerous()).made.clone();
    let folder = tempfile::tempdir().unwrap();
    write(&made, Some(folder.path())).unwrap();
    let files = std::fs::read_dir(folder.path()).unwrap();
    let file = files
        .map(|file| file.unwrap().path())
        .find(|path| {
            let name = path.to_string_lossy().into_owned();
            name.ends_with(".xml") && !name.ends_with(".solution.xml")
        })
        .unwrap();
    let read = || {
        let thresholds = Thresholds::shipped();
        let entry = Entry::of_file(&file);
        Box::new(Opened::read(&entry, &EgoSelection::Beside, thresholds).unwrap())
    };
    let mut bench = Bench::bundled();
    bench.model.opened = Some(read());
    bench.press("space g v");
    let words = bench.frame(100, 60);
    for part in [
        "an ideal driver avoids it",
        "a saved variant: ",
        "Space g o",
        "it passed the gate",
    ] {
        assert!(words.contains(part), "{part}: {words}");
    }
    let driver = made.good_driver.as_ref().unwrap();
    let used = format!("{:.1} m/s²", driver.max_acceleration.unwrap());
    assert!(words.contains(&used), "{used}: {words}");
    bench.press("space g v");
    bench.press("space m s");
    let second = bench.model.second_moment().unwrap().title();
    assert!(second.starts_with("original"), "{second}");
    bench.press("space g o");
    let original = bundled()
        .into_iter()
        .find(|entry| made.file.starts_with(&entry.name))
        .unwrap();
    let opened = bench.model.opened.as_ref().unwrap();
    assert_eq!(
        (&opened.name, opened.scenario.hash),
        (&original.name, made.original())
    );
    assert!(making::said(&bench).contains("goes back to the variant"));

    // Another file under the original's name is not the original.
    let certificate = file.with_extension("json");
    let text = std::fs::read_to_string(&certificate).unwrap();
    let hash = made.original().to_string();
    std::fs::write(&certificate, text.replace(&hash, "0123")).unwrap();
    let mut bench = Bench::bundled();
    bench.model.opened = Some(read());
    bench.press("space g o");
    let words = making::said(&bench);
    assert!(
        words.contains(&format!("the original {}", original.name)),
        "{words}"
    );
    assert!(words.contains("nor among the bundled scenarios"), "{words}");
}
