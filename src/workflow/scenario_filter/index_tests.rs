//! Terms about the windows of an index.
#![allow(clippy::unwrap_used)]

use super::*;
use nearmiss_formats::bundled;
use nearmiss_scene::corpus::{Manoeuvre, RoadType, WindowEgo, WindowPlace};
use nearmiss_scene::scenario::ObstacleType;

struct Row(Entry, Indexed);

impl Filterable for Row {
    fn entry(&self) -> &Entry {
        &self.0
    }
    fn tags(&self) -> impl Iterator<Item = &str> {
        std::iter::empty()
    }
    fn country(&self) -> &str {
        ""
    }
    fn has(&self, _property: Property) -> Option<bool> {
        None
    }
    fn agreement(&self) -> Option<Agreement> {
        None
    }
    fn number(&self, _number: Number) -> Option<f64> {
        None
    }
    fn indexed(&self) -> &Indexed {
        &self.1
    }
}

fn window(manoeuvre: Manoeuvre, road: RoadType, severity: u8) -> CellWindows {
    CellWindows {
        manoeuvre,
        road,
        severity,
        actor: match manoeuvre {
            Manoeuvre::CutIn => ObstacleType::Truck,
            _ => ObstacleType::PriorityVehicle,
        },
        windows: 1,
        asked: 0,
        example: WindowPlace {
            ego: WindowEgo::Recorded,
            ego_id: 1,
            obstacle: 2,
            steps: (0, 20),
            worst_step: 3,
        },
    }
}

/// A harmless cut-in in a town, and a critical crossing at an intersection.
fn row() -> Row {
    let windows = [
        window(Manoeuvre::CutIn, RoadType::Urban, 4),
        window(Manoeuvre::Crossing, RoadType::Intersection, 1),
    ];
    let entry = bundled().remove(0);
    Row(entry, Indexed::Windows(Arc::new(windows)))
}

fn passes(row: &Row, text: &str) -> bool {
    let filter = Filter::read(text, None);
    assert!(
        filter.wrong.is_empty() && !filter.incomplete,
        "{text}: {:?}",
        filter.wrong
    );
    let mut matching = Matching::default();
    filter.score(row, WordMatch::Part, &mut matching).is_some()
}

#[test]
fn one_window_satisfies_all_terms() {
    let row = row();
    for (filter, through) in [
        ("manoeuvre:cut_in", true),
        ("maneuver:Cut-In", true),
        ("manoeuvre:cut_in road:urban severity:later", true),
        ("manoeuvre:cut_in severity:critical", false),
        ("manoeuvre:cut_in road:intersection", false),
        ("road:intersection severity<=1", true),
        ("severity:conflict", true),
        ("severity:1", true),
        ("severity<1", false),
        ("severity=4 road:urban", true),
        ("severity>4", false),
        ("manoeuvre:oncoming", false),
        ("!manoeuvre:oncoming", true),
        ("!manoeuvre:cut_in", false),
        ("road:intersection !severity<1", true),
        ("road:intersection !severity=1", false),
        ("actor:truck manoeuvre:cut_in", true),
        ("actor:truck manoeuvre:crossing", false),
        ("actor:priority_vehicle", true),
        ("actor:bus,priority_vehicle road:urban", false),
        ("manoeuvre:oncoming,cut_in severity:later,near_miss", true),
        ("!manoeuvre:oncoming,cut_in", false),
        ("severity:0,2", false),
    ] {
        assert_eq!(passes(&row, filter), through, "{filter}");
    }
}

#[test]
fn a_scenario_outside_the_index_matches_no_term_and_no_opposite() {
    for indexed in [Indexed::Unknown, Indexed::Changed, Indexed::Missing] {
        let row = Row(bundled().remove(0), indexed);
        for filter in ["manoeuvre:cut_in", "!manoeuvre:cut_in", "severity<=5"] {
            assert!(!passes(&row, filter), "{filter}");
        }
    }
}

#[test]
fn half_typed_values_wait_and_wrong_ones_are_named() {
    for typed in [
        "manoeuvre:",
        "manoeuvre:cut",
        "road:inter",
        "severity:crit",
        "severity<=",
        "manoeuvre:cut_in,",
        "actor:bus,tr",
    ] {
        let filter = Filter::read(typed, None);
        assert!(filter.incomplete && filter.wrong.is_empty(), "{typed}");
        assert!(!filter.filters(), "{typed}");
    }
    for (typed, says) in [
        ("manoeuvre:cutin", "turning_across"),
        ("road:city", "off_road"),
        ("severity:deadly", "critical"),
        ("severity:7", "near_miss"),
        ("actor:tractor", "priority_vehicle"),
        ("road:urban,city", "unknown value `city`"),
        ("severity<x", "not a number"),
    ] {
        let wrong = Filter::read(typed, None).wrong.join(" ");
        assert!(wrong.contains(says), "{typed}: {wrong}");
    }
}

#[test]
fn a_search_takes_every_kind_of_term() {
    for filter in [
        "manoeuvre:cut_in ttc<1.5 road:highway",
        "actor:bicycle,pedestrian manoeuvre:crossing road:intersection pet<=0.9",
        "manoeuvre:following,followed time_gap<0.8 thw<1 headway<10",
        "!actor:truck,bus !road:highway !ttc<2",
        "ttc>=0.5 ttc<=1.5 country:DEU,USA",
        "actor:car,parked_vehicle manoeuvre:standing distance<0.8",
        "severity:critical risk<=2 risk>=1 severity<=2",
        "rss_margin<-1.5 drac>=6 btn>1 wttc<1 ttc_lane<2.5",
        "duration>30 obstacles>50 no:answers has:tags has:error",
        "verdict:differ tag:roundabout folder:highd",
        "ZAM_Urban-3_3",
        "germany US101",
    ] {
        let read = crate::checked_filter(filter);
        assert!(read.is_ok(), "{filter}: {read:?}");
    }
    for (sentence, is_one) in [
        ("cut-ins on motorways", true),
        ("ttc<1 on motorways", true),
        ("trucks merging in Germany", true),
        ("motorways ttc<1", false),
        ("'US101 'merge ^ZAM !xml", false),
    ] {
        let read = crate::checked_filter(sentence);
        let says = read
            .err()
            .is_some_and(|why| why.contains("reads as a sentence"));
        assert_eq!(says, is_one, "{sentence}");
    }
}

#[test]
fn without_an_index_its_terms_are_errors_and_the_others_filter() {
    let mut filter = Filter::read("road:urban no:index folder:x", None);
    assert_eq!(filter.index_term(), Some("road:"));
    filter.refuse_index_terms("needs an index");
    assert_eq!(filter.wrong, ["`road:` needs an index"]);
    assert!(filter.index_term().is_none() && filter.filters());
}
