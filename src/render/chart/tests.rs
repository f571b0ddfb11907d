//! Charts hold every value and name, also without values, and no number that is none.

use super::{
    Axis, Bar, BarChart, ChartPoint, ChartSeries, JudgedEvent, PointChart, RatePoint, TwoAxesChart,
};
use crate::display::Provenance;
use crate::{Palette, svg};

#[test]
fn bars_have_names_numbers_and_intervals() {
    let bar = |name: &str, value, interval| Bar {
        name: name.into(),
        value,
        interval,
        n: 40,
        apart: false,
    };
    let chart = BarChart {
        axis: "F1".into(),
        bars: vec![
            bar("ego · cp · lab/<x>", Some(0.83), Some((0.7, 0.91))),
            bar("nothing", None, None),
        ],
        palette: Palette::paper(),
        provenance: Provenance::default(),
    };
    let svg = svg(&chart.picture());
    for words in [
        "0.83 [0.70, 0.91]  n = 40",
        "no value  n = 40",
        "lab/&lt;x&gt;",
        ">F1<",
    ] {
        assert!(svg.contains(words), "{words}: {svg}");
    }
}

#[test]
fn points_are_drawn_with_a_legend_also_where_there_are_none() {
    let point = |x, y| ChartPoint {
        x,
        y,
        interval: Some((y - 0.1, y + 0.1)),
    };
    let series = |name: &str, points| ChartSeries {
        name: name.into(),
        points,
    };
    let chart = |all: Vec<ChartSeries>, range| PointChart {
        across: Axis {
            name: "lead (s)".into(),
            range,
        },
        up: Axis {
            name: "said yes".into(),
            range: (0.0, 1.0),
        },
        series: all,
        joined: true,
        diagonal: false,
        palette: Palette::paper(),
        provenance: Provenance::default(),
    };
    let some = vec![
        series("a", vec![point(0.5, 0.9), point(2.0, 0.4)]),
        series("b", vec![]),
    ];
    for (all, range) in [
        (some, (0.0, 2.0)),
        (vec![], (0.0, 0.0)),
        (vec![series("c", vec![point(1.0, 1.0)])], (1.0, 1.0)),
    ] {
        let svg = svg(&chart(all, range).picture());
        assert!(
            svg.contains("lead (s)") && !svg.contains("NaN") && !svg.contains("inf"),
            "{svg}"
        );
    }
}

fn judged(events: &[(&str, usize, usize, f64)]) -> String {
    let event = |(name, avoided, decided, rate): &(&str, usize, usize, f64)| JudgedEvent {
        name: (*name).into(),
        avoided: *avoided,
        decided: *decided,
        rates: vec![
            Some(RatePoint {
                rate: *rate,
                interval: (rate / 2.0, rate * 2.0 + 3.0),
            }),
            None,
        ],
    };
    let chart = TwoAxesChart {
        axis: "an hour".into(),
        egos: vec!["recorded egos".into(), "obstacle egos".into()],
        events: events.iter().map(event).collect(),
        palette: Palette::paper(),
        provenance: Provenance::default(),
    };
    svg(&chart.picture())
}

/// Where words stand in a picture, from above.
fn height(svg: &str, words: &str) -> f64 {
    let before = svg.split(&format!(">{words}<")).next().unwrap();
    let y = before.rsplit_once(" y=\"").unwrap().1;
    y.split('"').next().unwrap().parse().unwrap()
}

#[test]
fn the_more_drivers_avoid_an_event_the_higher_it_stands() {
    let svg = judged(&[
        ("low", 1, 3, 2.0),
        ("high", 3, 3, 0.0),
        ("also low", 1, 3, 2.0),
    ]);
    let heights: Vec<f64> = ["3 of 3", "2 of 3", "low", "also low", "0 of 3"]
        .iter()
        .map(|words| height(&svg, words))
        .collect();
    assert!(heights.is_sorted(), "{heights:?}");
    assert!((height(&svg, "high") - heights[0]).abs() < 0.01);
    for words in [
        "foreseeable and preventable",
        "has to be avoided",
        "foreseeable, not preventable",
        "open: not seen, upper bound",
        "obstacle egos",
    ] {
        assert!(svg.contains(words), "{words}: {svg}");
    }
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    // Shares of different numbers of drivers stand side by side; the ends are always there.
    let svg = judged(&[("a", 1, 2, 1.0), ("b", 3, 6, 1.0), ("c", 3, 4, 1.0)]);
    let heights: Vec<f64> = ["all", "3 of 4", "3 of 6, 1 of 2", "none"]
        .iter()
        .map(|words| height(&svg, words))
        .collect();
    assert!(heights.is_sorted(), "{heights:?}");
}

#[test]
fn what_was_not_seen_has_an_arrow_and_an_open_mark() {
    let event = |rate| {
        let svg = judged(&[("one", 1, 2, rate)]);
        let event = svg.split("<g class=\"event\"").nth(1).unwrap();
        event.split("</g>").next().unwrap().to_owned()
    };
    let (seen, unseen) = (event(2.0), event(0.0));
    // A line with two ends and a mark; an arrow of two lines and a mark.
    assert_eq!(seen.matches("<path").count(), 4, "{seen}");
    assert_eq!(unseen.matches("<path").count(), 3, "{unseen}");
    let filled =
        |event: &str| event.matches("<path").count() - event.matches("fill=\"none\"").count();
    assert_eq!((filled(&seen), filled(&unseen)), (1, 0), "{seen} {unseen}");
}
