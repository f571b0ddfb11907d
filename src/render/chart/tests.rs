//! Charts hold every value and name, also without values, and no number that is none.

use super::{Axis, Bar, BarChart, ChartPoint, ChartSeries, PointChart};
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
