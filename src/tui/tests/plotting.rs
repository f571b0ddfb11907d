//! Measures over time, and the list in their order.

use super::bench::Bench;
use crate::features::scenarios::request::Rank;
use crate::features::values::ReadThresholds;
use crate::message::Msg;

#[test]
fn any_measure_is_plotted_for_chosen_obstacles() {
    let mut bench = Bench::bundled();
    bench.press("space p m");
    bench.type_text("ttc");
    bench.press("enter");
    assert_eq!(bench.model.plot.measure.id, "ttc");
    let picked = bench.model.picked.unwrap();
    // The picked one has dashes, marked ones have others, all together have none.
    let frame = bench.frame(200, 60);
    assert!(frame.contains(&format!("⠒⠒⠀⠀⠒⠒ {picked}")), "{frame}");
    bench.press("space p o n space p o n");
    assert_eq!(bench.model.plot.marked.len(), 2);
    assert_eq!(bench.model.plot.marked[0], picked);
    let frame = bench.frame(200, 60);
    for words in [
        "· picked",
        "critical 1.50 s",
        &format!("⠂⠀⠂ {picked}"),
        "⠒⠒ min",
    ] {
        assert!(frame.contains(words), "{words}: {frame}");
    }
    bench.press("shift-n space p o");
    assert_eq!(bench.model.plot.marked.len(), 1);
    bench.press("down");
    assert!(bench.model.plot.marked.is_empty(), "of another scenario");
    assert!(bench.model.plot.series.is_some());
}

#[test]
fn the_list_is_sorted_by_a_measure() {
    let mut bench = Bench::bundled();
    let selected = bench.model.list.current();
    bench.press("space l s");
    bench.type_text("headway");
    bench.press("enter");
    let asked = bench.effects.iter().find_map(|e| match e.request() {
        Some(Rank::All(measure, entries)) => Some((*measure, entries.len())),
        _ => None,
    });
    assert_eq!(asked, Some(("headway", 8)));
    assert!(bench.frame(200, 60).contains("by headway, m"));
    for (place, value) in [(0, Some(3.0)), (5, Some(0.25)), (2, None)] {
        bench.send(Msg::reply::<Rank>(("headway", place, value)));
    }
    bench.send(Msg::reply::<Rank>(("ttc", 1, Some(0.0))));
    assert_eq!(
        bench.model.list.visible[..2],
        [5, 0],
        "what is not known comes last"
    );
    assert_eq!(bench.model.list.current(), selected);
    assert!(bench.frame(200, 60).contains("0.25 "));
    bench.press("space l s enter");
    assert_eq!(bench.model.list.visible[..3], [0, 1, 2]);
}

#[test]
fn measures_to_choose_from_are_there_whole() {
    for key in ["space p m", "space l s"] {
        let mut bench = Bench::bundled();
        bench.press(key);
        let frame = bench.frame(200, 60);
        let inside = frame.lines().filter_map(|line| line.split('┃').nth(1));
        for line in inside {
            assert!(!line.contains('…'), "{line}");
        }
        // In a small window, the selected one is there whole below the list.
        bench.type_text("rss_long_margin");
        let frame = bench.frame(80, 24);
        let inside = frame.lines().filter_map(|line| line.split('┃').nth(1));
        let words: Vec<&str> = inside.map(str::trim).collect();
        let words = words.join(" ");
        let measure = nearmiss_scene::metrics::measure("rss_long_margin").unwrap();
        assert!(words.contains(measure.source), "{frame}");
    }
}

/// What is inside the plot's frame, its borders included.
fn plotted(bench: &Bench, columns: u16, rows: u16) -> String {
    let frame = bench.frame(columns, rows);
    let from = frame
        .lines()
        .position(|l| l.contains(&format!("┌ {}", bench.model.plot.measure.id)));
    let lines: Vec<&str> = frame.lines().skip(from.unwrap()).collect();
    let right = |line: &&str| {
        line.chars()
            .skip(usize::from(columns) / 2)
            .collect::<String>()
    };
    lines.iter().map(right).collect::<Vec<_>>().join("\n")
}

#[test]
fn axes_have_round_ends_and_units_and_marks_have_names() {
    let mut bench = Bench::bundled();
    bench.press("space p m");
    bench.type_text("distance");
    bench.press("enter space p o n space p o n");
    for (columns, rows) in [(80, 24), (120, 40), (200, 60)] {
        let plot = plotted(&bench, columns, rows);
        assert!(
            (plot.contains(" s ") || plot.contains(" s│")) && plot.contains(" m┤"),
            "{plot}"
        );
        for id in &bench.model.plot.marked {
            assert!(
                // The picked one has dashes, the marked ones have dots and others.
                ["⠂", "⠐⠀", "⠐"]
                    .iter()
                    .any(|sign| plot.contains(&format!("{sign} {id}"))),
                "{id} at {columns}×{rows}: {plot}"
            );
        }
        let numbers = plot.lines().filter(|l| l.contains('┤')).count();
        assert!((2..=6).contains(&numbers), "{plot}");
        let title = plot.lines().next().unwrap();
        assert!(title.ends_with('┐') && !title.contains("· ┐"), "{title}");
    }
}

#[test]
fn a_threshold_that_is_far_away_is_an_arrow_with_its_value() {
    let mut bench = Bench::bundled();
    bench.press("space p m");
    bench.type_text("ttc");
    bench.press("enter");
    assert_eq!(bench.model.plot.measure.id, "ttc");
    let text = "[[threshold]]\nmeasure = \"ttc\"\nname = \"far\"\nvalue = 900\n";
    let far = nearmiss_scene::metrics::Thresholds::read(text, "mine.toml").unwrap();
    bench.send(Msg::reply::<ReadThresholds>(Ok(std::sync::Arc::new(far))));
    for (columns, rows) in [(160, 45), (200, 60)] {
        let plot = plotted(&bench, columns, rows);
        assert!(plot.contains("↑ ") && plot.contains("far 900 s"), "{plot}");
    }
}

#[test]
fn risk_scores_are_steps_with_six_numbers_and_events() {
    let mut bench = Bench::bundled();
    bench.press("x");
    assert_eq!(bench.model.plot.measure.id, "risk");
    for (columns, rows) in [(120, 40), (200, 60), (300, 100)] {
        let plot = plotted(&bench, columns, rows);
        let number = |line: &str| line.split_once('┤')?.0.chars().last();
        let numbers: Vec<(usize, char)> = plot
            .lines()
            .enumerate()
            .filter_map(|(y, line)| Some((y, number(line)?)))
            .collect();
        let words: String = numbers.iter().map(|(_, number)| number).collect();
        assert_eq!(words, "543210", "{plot}");
        let gaps: Vec<usize> = numbers
            .windows(2)
            .map(|pair| pair[1].0 - pair[0].0)
            .collect();
        assert!(gaps.iter().all(|gap| *gap == gaps[0]), "{plot}");
        // The contact, and the window that is judged.
        assert!(
            plot.contains('X') && plot.contains('[') && plot.contains(']'),
            "{plot}"
        );
    }
    assert!(
        plotted(&bench, 200, 60).contains("X contact")
            || plotted(&bench, 200, 60).contains("contact X")
    );
}
