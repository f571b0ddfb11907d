//! Tests of filter terms, groups, and orders while rows arrive.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use crate::features::scenarios::state::*;
use crate::loaded::Tally;
use nearmiss_base::geometry::Pose;
use nearmiss_scene::metrics::{Contact, ContactSide, Headline, Impact, Nearest, measure};

/// Scenarios of these files, all found.
fn list(files: &[&str]) -> List {
    let mut list = List::default();
    let entries = files.iter().map(|n| Entry::of_file(Path::new(n)));
    list.fill(entries.collect::<Vec<_>>().into());
    list
}

fn nearest(value: f64) -> Option<Nearest> {
    Some(Nearest {
        value,
        step: 3,
        obstacle: 7,
    })
}

fn facts(risk: f64, tags: &[&str], differ: u32, agree: u32) -> Facts {
    Facts {
        hash: String::new(),
        obstacles: 4,
        seconds: 6.0,
        country: "DEU".into(),
        tags: tags.iter().map(ToString::to_string).collect(),
        headline: Some(Headline {
            moments: Vec::new(),
            contact: (risk == 0.0).then_some(Contact {
                obstacle: 7,
                step: 3,
                time: 0.3,
                overlaps: true,
                is_possible: false,
                impact: Impact {
                    closing_speed: 9.4,
                    angle: 0.0,
                    sides: [ContactSide::Front, ContactSide::Rear],
                    overlap: 1.0,
                    delta_v: Some([4.7, 4.7]),
                    p_serious: Ok(0.005),
                    rank: 0.005,
                },
                ego: Pose::new(0.0, 0.0, 0.0),
                other: Pose::new(4.0, 0.0, 0.0),
            }),
            distance: nearest(risk),
            ttc: None,
            risk: nearest(risk),
        }),
        collision: Tally { agree, differ },
        safety: Tally::default(),
        recording: Tally::default(),
    }
}

/// Four scenarios: a contact with answers, a near miss, one without an ego, one that cannot be read.
fn four() -> List {
    let mut list = list(&[
        "a/DEU_Bremen-1_10_T-1.xml",
        "a/USA_Peach-4_8_T-1.xml",
        "b/DEU_Bonn-1_1_T-1.xml",
        "b/broken.xml",
    ]);
    list.survey(0, Ok(facts(0.0, &["urban", "cut_in"], 1, 2)));
    let usa = Facts {
        country: "USA".into(),
        obstacles: 12,
        ..facts(2.0, &["highway"], 0, 3)
    };
    list.survey(1, Ok(usa));
    let alone = Facts {
        headline: None,
        ..facts(5.0, &["urban"], 0, 0)
    };
    list.survey(2, Ok(alone));
    list.survey(3, Err("damaged".into()));
    list.settle();
    list
}

#[test]
fn filters_fuzzily_and_keeps_the_selection() {
    let mut list = list(&[
        "a/DEU_Bremen-1_10_T-1.xml",
        "a/USA_Peach-4_8_T-1.xml",
        "b/DEU_Bonn-1_1_T-1.xml",
    ]);
    list.move_by(2);
    assert_eq!(list.current(), Some(2));
    list.set_filter("brem".into());
    assert_eq!(list.visible, [0]);
    list.set_filter(String::new());
    assert_eq!(list.visible.len(), 3);
    list.set_filter("nothing like it".into());
    assert_eq!(list.current(), None);
    list.set_filter("dbn".into());
    let matched = list
        .read
        .matched("DEU_Bonn-1_1_T-1", list.matched, &mut Matching::default());
    assert_eq!(matched, [0, 4, 6], "{:?}", list.visible);
}

#[test]
fn words_are_parts_first_and_similar_names_only_where_nothing_has_them() {
    let mut list = list(&[
        "DEU_Bonn-1.xml",
        "ESP_Barcelona-on-n.xml",
        "USA_Lanker-1.xml",
    ]);
    list.survey(2, Ok(facts(0.0, &["urban", "bonnet"], 0, 0)));
    list.set_filter("BONN".into());
    assert_eq!(list.visible, [0, 2], "its name, and a tag");
    assert_eq!(list.matched, WordMatch::Part);
    list.set_filter("brcln".into());
    assert_eq!(list.visible, [1]);
    assert_eq!(list.matched, WordMatch::Fuzzy);
    list.set_filter("risk>".into());
    assert!(list.read.incomplete && !list.read.filters());
    assert_eq!(list.visible.len(), 3);
}

#[test]
fn terms_ask_for_what_is_known() {
    let mut list = four();
    let cases: &[(&str, &[usize])] = &[
        ("tag:cut_in", &[0]),
        ("tag:URB", &[0, 2]),
        ("!tag:urban", &[1, 3]),
        ("country:deu", &[0, 2]),
        ("country:US", &[1]),
        ("folder:b", &[2, 3]),
        ("has:collision", &[0]),
        ("no:collision", &[1, 2]),
        ("no:ego", &[2]),
        ("has:error", &[3]),
        ("has:answers", &[0, 1]),
        ("no:answers", &[2]),
        ("has:tags", &[]),
        ("risk<3", &[0, 1]),
        ("risk<=0", &[0]),
        ("risk>0", &[1]),
        ("risk=2", &[1]),
        ("obstacles>=12", &[1]),
        ("duration<7", &[0, 1, 2]),
        ("answers>2", &[0, 1]),
        ("verdict:disagree", &[0]),
        ("verdict:differ", &[0]),
        ("verdict:agree", &[1]),
        ("verdict:none", &[2, 3]),
        ("tag:urban risk<3 brem", &[0]),
        ("tag:urban peach", &[]),
    ];
    for (filter, expected) in cases {
        list.set_filter((*filter).to_string());
        assert_eq!(list.visible, *expected, "{filter}");
        assert!(
            list.read.wrong.is_empty(),
            "{filter}: {:?}",
            list.read.wrong
        );
    }
}

#[test]
fn a_wrong_term_is_said_and_one_that_is_being_typed_is_not() {
    let mut list = four();
    for (filter, words) in [
        ("tga:urban", "unknown filter `tga:`"),
        (
            "has:wheels",
            "unknown value `wheels` of `has:`; available: collision",
        ),
        ("verdict:maybe", "unknown value `maybe` of `verdict:`"),
        ("speed>3", "unknown number `speed`"),
        ("risk<low", "`low` is not a number"),
        ("risk<nan", "`nan` is not a number"),
        ("drac>3", "needs the list sorted by it"),
    ] {
        list.set_filter(filter.into());
        let wrong = list.read.wrong.join(" ");
        assert!(wrong.contains(words), "{filter}: {wrong}");
        assert_eq!(list.visible.len(), 4, "{filter}");
    }
    for filter in ["tag:", "has:", "has:coll", "verdict:dis", "risk<", "risk<-"] {
        list.set_filter(filter.into());
        assert!(
            list.read.wrong.is_empty(),
            "{filter}: {:?}",
            list.read.wrong
        );
        assert_eq!(list.visible.len(), 4, "{filter}");
    }
    list.set_filter(String::new());
    list.sort_by(Order::Measure(measure("drac").unwrap()));
    let ranked = |value| Ranked {
        value: Some(value),
        stand_in: None,
    };
    list.rank("drac", 1, ranked(4.0));
    list.rank("drac", 0, ranked(1.0));
    list.set_filter("drac>3".into());
    assert_eq!(
        (list.visible.as_slice(), list.read.wrong.len()),
        (&[1][..], 0)
    );
}

#[test]
fn own_tags_are_found_like_those_of_the_file() {
    let mut list = four();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tags.toml");
    let tags = Tags::change(&path, "broken", vec!["look_again".into()]).unwrap();
    list.set_filter("tag:again".into());
    assert!(list.visible.is_empty());
    list.set_tags(tags);
    list.settle();
    assert_eq!(list.visible, [3]);
    list.set_filter("has:tags".into());
    assert_eq!(list.visible, [3]);
}

fn shown(list: &List) -> Vec<String> {
    let line = |line: &Line| match line {
        Line::Head(group) => {
            let group = &list.groups[*group];
            let sign = if group.shut { "+" } else { "-" };
            format!("{sign}{} {}", group.name, group.count)
        }
        Line::Scenario(place, _) => place.to_string(),
    };
    list.lines.iter().map(line).collect()
}

#[test]
fn groups_have_heads_that_shut() {
    let mut list = four();
    list.move_by(1);
    list.group_by(Grouping::Country);
    let whole = ["-DEU 2", "0", "2", "-USA 1", "1", "-no country 1", "3"];
    assert_eq!(shown(&list), whole);
    assert_eq!(list.current(), Some(1), "the selection stays");
    assert!(!list.toggle_group(), "a scenario is no group");
    list.selected = 0;
    assert!(list.toggle_group());
    assert_eq!(shown(&list)[..2], ["+DEU 2", "-USA 1"]);
    assert_eq!((list.selected, list.current()), (0, None));
    assert!(list.select(2), "what is selected from elsewhere is shown");
    assert_eq!(list.current(), Some(2));
    list.group_by(Grouping::Tag);
    let whole = [
        "-cut_in 1",
        "0",
        "-highway 1",
        "1",
        "-urban 2",
        "0",
        "2",
        "-no tags 1",
        "3",
    ];
    assert_eq!(shown(&list), whole);
    assert_eq!(list.current(), Some(2));
    list.group_by(Grouping::Folder);
    assert_eq!(shown(&list), ["-a 2", "0", "1", "-b 2", "2", "3"]);
    list.group_by(Grouping::Verdict);
    let whole = [
        "-answers differ 1",
        "0",
        "-answers agree 1",
        "1",
        "-no answers 2",
        "2",
        "3",
    ];
    assert_eq!(shown(&list), whole);
}

#[test]
fn a_scenario_stands_under_each_of_its_tags_and_the_selection_knows_which() {
    let mut list = four();
    list.group_by(Grouping::Tag);
    list.selected = 5;
    assert_eq!(list.current(), Some(0), "under urban");
    let more = facts(1.0, &["a_new_one"], 0, 0);
    list.survey(3, Ok(more));
    list.settle();
    assert_eq!(list.current(), Some(0));
    assert_eq!(shown(&list)[list.selected - 1], "-urban 2");
}

#[test]
fn orders_hold_while_rows_arrive_and_the_selection_stays() {
    let mut list = list(&["a.xml", "b.xml", "c.xml"]);
    list.sort_by(Order::Measure(measure("risk").unwrap()));
    list.selected = 1;
    list.survey(2, Ok(facts(1.0, &[], 0, 0)));
    assert_eq!(list.visible, [0, 1, 2], "not before the next frame");
    list.settle();
    assert_eq!(
        (list.visible.as_slice(), list.current()),
        (&[2, 0, 1][..], Some(1))
    );
    list.survey(0, Ok(facts(0.0, &[], 2, 0)));
    list.add(vec![Entry::of_file(Path::new("d.xml"))]);
    list.settle();
    assert_eq!(
        (list.visible.as_slice(), list.current()),
        (&[0, 2, 1, 3][..], Some(1))
    );
    list.sort_by(Order::Measure(measure("risk").unwrap()));
    assert_eq!(list.visible, [2, 0, 1, 3], "what is not known stays last");
    list.sort_by(Order::Verdicts);
    assert_eq!(list.visible[0], 0);
    list.sort_by(Order::Name);
    list.sort_by(Order::Name);
    assert_eq!(list.visible, [3, 2, 1, 0]);
    assert_eq!(list.current(), Some(1));
}

#[test]
fn where_the_planner_failed_it_is_not_asked_again_when_more_come() {
    let mut list = four();
    list.sort_by(Order::Severity);
    let lacking = |list: &mut List| -> Vec<usize> {
        let asked = list.lacking_egos().into_iter();
        asked.map(|(place, _)| place).collect()
    };
    assert_eq!(lacking(&mut list), [2]);
    list.rank("severity", 2, Ranked::default());
    list.append(Entry::of_file(Path::new("c/variant.xml")));
    let alone = Facts {
        headline: None,
        ..facts(5.0, &[], 0, 0)
    };
    list.survey(4, Ok(alone));
    assert_eq!(lacking(&mut list), [4]);
}

#[test]
fn what_changes_nothing_on_the_screen_is_not_sorted_anew() {
    let mut list = list(&["a.xml", "b.xml"]);
    list.survey(0, Ok(facts(1.0, &[], 0, 0)));
    assert!(!list.stale, "found order asks for no facts");
    list.set_filter("a".into());
    list.survey(1, Ok(facts(1.0, &[], 0, 0)));
    assert!(!list.stale, "nor do words");
    list.set_filter("risk<2".into());
    list.survey(1, Ok(facts(1.0, &[], 0, 0)));
    assert!(list.stale);
}
