//! Legibility tests of the shipped themes: WCAG 2.2 contrast, colour differences in CIELAB, and simulated red and
//! green colour blindness.
#![allow(clippy::unwrap_used)]

use ratatui::style::Color;

use super::{ColorDepth, SURFACES, Theme, color};

/// Backgrounds that terminals usually have, for themes that leave theirs out: black, the default of some, One Dark, Solarized.
const DARK: [[u8; 3]; 4] = [
    [0, 0, 0],
    [0x1e, 0x1e, 0x1e],
    [0x28, 0x2c, 0x34],
    [0x00, 0x2b, 0x36],
];
const LIGHT: [[u8; 3]; 3] = [[255, 255, 255], [0xfa, 0xfa, 0xfa], [0xfd, 0xf6, 0xe3]];

/// Roles that words are written in.
const WORDS: [&str; 24] = [
    "text",
    "dim",
    "title",
    "accent",
    "ego",
    "obstacle",
    "static_obstacle",
    "truck",
    "cycle",
    "pedestrian",
    "picked",
    "danger",
    "danger_medium",
    "danger_low",
    "warning",
    "safe",
    "agree",
    "disagree",
    "sign",
    "light_red",
    "light_amber",
    "light_green",
    "tape",
    "attacker",
];
/// Roles of lines and signs.
const LINES: [&str; 11] = [
    "lane",
    "trail",
    "ego_trail",
    "goal",
    "crosswalk",
    "brake_light",
    "indicator",
    "map_marking",
    "predicted",
    "occupancy",
    "border_focused",
];

/// Linear RGB to what a protanope and a deuteranope see of it: Machado, Oliveira and Fernandes,
/// "A Physiologically-based Model for Simulation of Color Vision Deficiency", 2009, severity 1.
const PROTANOPE: [[f64; 3]; 3] = [
    [0.152_286, 1.052_583, -0.204_868],
    [0.114_503, 0.786_281, 0.099_216],
    [-0.003_882, -0.048_116, 1.051_998],
];
const DEUTERANOPE: [[f64; 3]; 3] = [
    [0.367_322, 0.860_646, -0.227_968],
    [0.280_085, 0.672_501, 0.047_413],
    [-0.011_820, 0.042_940, 0.968_881],
];
const TRICHROMAT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn linear(rgb: [u8; 3]) -> [f64; 3] {
    rgb.map(|c| {
        let c = f64::from(c) / 255.0;
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    })
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// WCAG 2.2, "contrast ratio": 1 to 21.
fn contrast(a: [u8; 3], b: [u8; 3]) -> f64 {
    let luminance = |rgb| dot(linear(rgb), [0.2126, 0.7152, 0.0722]) + 0.05;
    let (a, b) = (luminance(a), luminance(b));
    a.max(b) / a.min(b)
}

fn lab(rgb: [f64; 3]) -> [f64; 3] {
    let f = |t: f64| {
        if t > 216.0 / 24389.0 {
            t.cbrt()
        } else {
            (24389.0 / 27.0 * t + 16.0) / 116.0
        }
    };
    let x = f(dot(rgb, [0.412_456_4, 0.357_576_1, 0.180_437_5]) / 0.950_47);
    let y = f(dot(rgb, [0.212_672_9, 0.715_152_2, 0.072_175_0]));
    let z = f(dot(rgb, [0.019_333_9, 0.119_192_0, 0.950_304_1]) / 1.088_83);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The distance in CIELAB (ΔE of 1976) of two colours, as seen by these eyes.
fn difference(a: [u8; 3], b: [u8; 3], eyes: &[[f64; 3]; 3]) -> f64 {
    let seen = |rgb| lab(eyes.map(|row| dot(row, linear(rgb)).clamp(0.0, 1.0)));
    let (a, b) = (seen(a), seen(b));
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).powi(2))
        .sum::<f64>()
        .sqrt()
}

fn themes() -> Vec<Theme> {
    let nowhere = std::path::Path::new("/nonexistent");
    nearmiss_settings::ThemeFile::shipped()
        .map(|name| Theme::load(name, nowhere, true).unwrap())
        .collect()
}

fn rgb(theme: &Theme, role: &str) -> [u8; 3] {
    color::components(theme.role(role).unwrap()).unwrap()
}

#[test]
fn the_formulas_are_right() {
    assert!((contrast([0; 3], [255; 3]) - 21.0).abs() < 1e-9);
    // #767676 on white is the common example of 4.54.
    assert!((contrast([0x76; 3], [255; 3]) - 4.54).abs() < 0.01);
    let red = lab(linear([255, 0, 0]));
    for (found, known) in red.iter().zip([53.24, 80.09, 67.20]) {
        assert!((found - known).abs() < 0.05, "{red:?}");
    }
    // Pure red and a dark green are one colour to deuteranopes, nearly.
    let (red, green) = ([200, 60, 20], [120, 110, 20]);
    assert!(difference(red, green, &TRICHROMAT) > 40.0);
    assert!(difference(red, green, &DEUTERANOPE) < 25.0);
}

/// AA asks for 4.5, AAA for 7. The nearest of 256 colours may be a little lighter than what a theme says.
fn least(theme: &Theme, depth: ColorDepth) -> f64 {
    match (theme.name.starts_with("contrast"), depth) {
        (true, ColorDepth::True) => 7.0,
        (true, _) => 6.5,
        (false, _) => 4.5,
    }
}

#[test]
fn words_can_be_read_on_every_surface() {
    for full in themes() {
        for depth in [ColorDepth::True, ColorDepth::Indexed] {
            let theme = full.clone().at_depth(depth);
            let name = format!("{} {depth:?}", theme.name);
            for surface in SURFACES {
                let of = |role: &str| contrast(rgb(&theme, role), rgb(&theme, surface));
                // Labels of the map have its ground behind them wherever they are.
                let words = match *surface {
                    "background" => least(&theme, depth),
                    "map_road" | "map_junction" | "map_path" => 0.0,
                    _ => 4.5,
                };
                for role in WORDS {
                    let found = of(role);
                    assert!(found >= words, "{name}: {role} {found:.2} on {surface}");
                }
                // Lines may recede.
                for role in LINES {
                    let found = of(role);
                    assert!(found >= 2.0, "{name}: {role} {found:.2} on {surface}");
                }
            }
            let bar = contrast(rgb(&theme, "selection"), rgb(&theme, "text"));
            assert!(bar >= 4.5, "{name}: the selected line {bar:.2}");
        }
    }
}

#[test]
fn roads_stand_out_from_the_ground_and_lane_edges_from_the_road() {
    for full in themes() {
        for depth in [ColorDepth::True, ColorDepth::Indexed] {
            let theme = full.clone().at_depth(depth);
            let name = format!("{} {depth:?}", theme.name);
            let of = |a: &str, b: &str| contrast(rgb(&theme, a), rgb(&theme, b));
            for road in ["map_road", "map_junction"] {
                let (ground, edge) = (of(road, "map_ground"), of("map_marking", road));
                assert!(ground >= 1.5, "{name}: {road} {ground:.2} on the ground");
                assert!(edge >= 4.0, "{name}: lane edges {edge:.2} on {road}");
            }
        }
    }
}

#[test]
fn words_can_be_read_on_the_backgrounds_of_terminals() {
    for full in themes() {
        for depth in [ColorDepth::True, ColorDepth::Indexed] {
            let theme = full.clone().at_depth(depth);
            for ground in if theme.dark { &DARK[..] } else { &LIGHT[..] } {
                for role in WORDS {
                    let found = contrast(rgb(&theme, role), *ground);
                    let name = &theme.name;
                    assert!(
                        found >= 4.5,
                        "{name} {depth:?}: {role} {found:.2} on {ground:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn dangerous_and_safe_look_different_to_everybody() {
    let themes = themes();
    let pairs = [
        ("danger", "safe", 40.0),
        ("danger", "warning", 20.0),
        ("warning", "safe", 40.0),
        ("light_red", "light_green", 40.0),
        ("light_red", "light_amber", 20.0),
        ("light_amber", "light_green", 40.0),
        ("agree", "disagree", 40.0),
        ("danger", "ego", 25.0),
        ("picked", "obstacle", 15.0),
    ];
    let made_for_it = |t: &&Theme| t.name.starts_with("colorblind");
    assert_eq!(themes.iter().filter(made_for_it).count(), 2);
    for theme in themes.iter().filter(made_for_it) {
        for depth in [ColorDepth::True, ColorDepth::Indexed] {
            let (name, theme) = (&theme.name, theme.clone().at_depth(depth));
            for (a, b, least) in pairs {
                for eyes in [&TRICHROMAT, &DEUTERANOPE, &PROTANOPE] {
                    let found = difference(rgb(&theme, a), rgb(&theme, b), eyes);
                    assert!(found >= least, "{name} {depth:?} {a} {b}: {found:.0}");
                }
            }
        }
    }
    // Agreement is told from disagreement in every theme.
    for theme in &themes {
        for eyes in [&TRICHROMAT, &DEUTERANOPE, &PROTANOPE] {
            let found = difference(rgb(theme, "agree"), rgb(theme, "disagree"), eyes);
            assert!(found >= 40.0, "{}: {found:.0}", theme.name);
        }
    }
    // The test sees what it looks for: the usual red and green do not pass it.
    let dark = themes.iter().find(|t| t.name == "dark").unwrap();
    assert!(difference(rgb(dark, "danger"), rgb(dark, "safe"), &DEUTERANOPE) < 40.0);
}

#[test]
fn the_selected_line_is_reversed() {
    use ratatui::style::Modifier;
    for theme in themes() {
        for depth in [
            ColorDepth::True,
            ColorDepth::Indexed,
            ColorDepth::Sixteen,
            ColorDepth::None,
        ] {
            let style = theme.clone().at_depth(depth).selected();
            assert!(
                style.add_modifier.contains(Modifier::REVERSED),
                "{}",
                theme.name
            );
            assert_eq!(style.fg == Some(Color::Reset), depth == ColorDepth::None);
        }
    }
}
