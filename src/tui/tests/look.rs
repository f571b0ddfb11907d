//! Themes, chords, reloaded files, and screens without colours or Unicode.

use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::style::{Color, Modifier};

use crate::action::Scope;
use crate::features::details::DetailsScreen;
use crate::features::help::HelpScreen;
use crate::keymap::{Keymap, Preset};
use crate::message::{Effect, Msg, Reloaded};
use crate::model::{Glyphs, Pane};
use crate::tests::bench::Bench;
use crate::theme::{ColorDepth, Theme};
use crate::views;
use nearmiss_settings::Config;

fn bench() -> Bench {
    let mut bench = Bench::bundled();
    let nowhere = std::path::Path::new("/nonexistent");
    bench.send(Msg::Reloaded(Reloaded::Themes(Theme::all(nowhere))));
    bench
}

fn vim() -> Bench {
    let mut bench = bench();
    bench.model.look.keymap = Keymap::from_preset(Preset::Vim);
    bench
}

fn buffer(bench: &Bench, columns: u16, rows: u16) -> Buffer {
    let mut terminal = Terminal::new(TestBackend::new(columns, rows)).unwrap();
    let drawn = terminal.draw(|frame| views::draw(frame, &bench.model));
    drawn.unwrap().buffer.clone()
}

/// What the newest message says.
fn said(bench: &Bench) -> String {
    bench
        .model
        .toasts
        .last()
        .map_or(String::new(), |t| t.text.clone())
}

#[test]
fn a_theme_is_seen_while_it_is_looked_for() {
    let mut bench = bench();
    assert_eq!(bench.model.theme.name, "dark");
    // Auto, contrast and colorblind first, which are dark here.
    bench.press("ctrl-t down");
    assert_eq!(bench.model.theme.name, "contrast-dark");
    bench.press("down down");
    assert_eq!(bench.model.theme.name, "dark");
    bench.press("down");
    assert_eq!(bench.model.theme.name, "light");
    bench.type_text("col");
    assert_eq!(bench.model.theme.name, "colorblind-dark");
    bench.press("esc");
    assert_eq!(bench.model.theme.name, "dark");
    bench.press("ctrl-t");
    bench.type_text("contr");
    bench.press("enter");
    assert_eq!(bench.model.theme.name, "contrast-dark");
    assert!(
        said(&bench).contains("theme = \"contrast\""),
        "{}",
        said(&bench)
    );
    assert!(bench.model.screens.is_empty());
    // What is picked is where the list opens again.
    bench.press("ctrl-t");
    assert_eq!(bench.model.theme.name, "contrast-dark");
}

#[test]
fn auto_follows_the_background() {
    let mut bench = bench();
    bench.model.look.dark = false;
    bench.press("ctrl-t");
    bench.type_text("auto");
    bench.press("enter");
    assert_eq!(bench.model.theme.name, "light");
}

#[test]
fn the_theme_picker() {
    let mut bench = bench();
    bench.press("ctrl-t down down");
    insta::assert_snapshot!(bench.frame(80, 24));
}

#[test]
fn the_box_after_a_prefix() {
    let mut bench = vim();
    bench.press("g");
    insta::assert_snapshot!(bench.frame(80, 24));
}

#[test]
fn keys_of_several_strokes() {
    let mut bench = vim();
    bench.press("j j");
    assert_eq!(bench.model.list.selected, 2);
    bench.press("g");
    assert!(!bench.model.look.pending.is_empty());
    bench.press("g");
    assert_eq!(bench.model.list.selected, 0);
    assert!(bench.model.look.pending.is_empty());
    // Esc and Ctrl-C give up the prefix and do nothing else.
    for key in ["esc", "ctrl-c"] {
        bench.press("shift-g g");
        bench.press(key);
        assert!(bench.model.look.pending.is_empty() && bench.effects.iter().all(|e| !quits(e)));
        bench.press("g");
        assert!(!bench.model.look.pending.is_empty());
        bench.press("esc");
    }
    bench.press("g x");
    assert!(
        said(&bench).contains("g x is not bound"),
        "{}",
        said(&bench)
    );
    assert!(bench.model.list.selected > 0);
    bench.press("ctrl-w w");
    assert_eq!(bench.model.focus, Pane::Map);
    // A prefix is no key in what is typed.
    bench.press("/ g g");
    assert_eq!(bench.model.list.filter, "gg");
}

fn quits(effect: &crate::message::Effect) -> bool {
    matches!(effect, crate::message::Effect::Quit)
}

#[test]
fn letters_of_other_alphabets_are_the_keys_they_are_on() {
    let mut bench = bench();
    // о and γ are on the keys of j and g.
    bench.press("о о");
    assert_eq!(bench.model.list.selected, 2);
    bench.press("γ γ");
    assert_eq!(bench.model.list.selected, 0);
    bench.press("о п п");
    assert_eq!(bench.model.list.selected, 0);
    // Where a text is typed they are what they are.
    bench.press("/ о");
    assert_eq!(bench.model.list.filter, "о");
}

#[test]
fn footer_help_palette_and_sentences_have_the_live_keys() {
    let text = "[global]\nplay = \"f5\"\nnext-obstacle = \"f6 o\"\nedit = []\n";
    let mut bench = bench();
    bench.send(Msg::Reloaded(Reloaded::Keymap(
        Keymap::parse("k", text).map_err(|m| m[0].clone()),
    )));
    bench.model.toasts.clear();
    let frame = bench.frame(200, 60);
    let footer = frame.lines().last().unwrap();
    assert!(
        footer.contains("F5 play") && !footer.contains("space"),
        "{footer}"
    );
    bench.press("?");
    bench.type_text("pick next");
    let help = bench.frame(200, 60);
    assert!(
        help.contains("F6 o") && !help.contains("leave the program"),
        "{help}"
    );
    bench.press("esc :");
    bench.type_text("next-obstacle");
    assert!(bench.frame(200, 60).contains("F6 o"));
    bench.press("esc");
    bench.model.picked = None;
    bench.press("space e t");
    assert!(said(&bench).contains("F6 o"), "{}", said(&bench));
}

#[test]
fn help_is_searched_and_closed() {
    let mut bench = bench();
    bench.press("?");
    bench.type_text("no such thing");
    assert!(bench.frame(100, 40).contains("no key or action matches"));
    bench.press("esc");
    assert!(bench.model.screens.is_empty());
    bench.press("? ?");
    assert!(bench.model.screens.is_empty());
    // What has no key is found too.
    bench.press("?");
    bench.type_text("read-thresholds");
    assert!(bench.frame(100, 40).contains("thresholds.toml"));
}

#[test]
fn a_broken_file_changes_nothing_and_is_complained_about() {
    let mut bench = bench();
    let good = Keymap::from_preset(Preset::Vim);
    bench.send(Msg::Reloaded(Reloaded::Keymap(Ok(good.clone()))));
    assert!(said(&bench).contains("keymap.toml"));
    let broken = Keymap::parse("keymap.toml", "[global]\nplay = 3\n").map_err(|m| m[0].clone());
    bench.send(Msg::Reloaded(Reloaded::Keymap(broken)));
    assert_eq!(bench.model.look.keymap, good);
    assert!(
        said(&bench).starts_with("keymap.toml:2: global.play"),
        "{}",
        said(&bench)
    );

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    let reload = |bench: &mut Bench, text: &str| {
        std::fs::write(&path, text).unwrap();
        bench.send(Msg::Reloaded(Reloaded::Themes(Theme::all(folder.path()))));
    };
    reload(&mut bench, "dark = true\n[roles]\ntext = \"red\"\n");
    let config = |theme: &str| {
        Box::new(Config {
            theme: Some(theme.into()),
            ..Config::default()
        })
    };
    bench.send(Msg::Reloaded(Reloaded::Config(Ok(config("mine")))));
    assert_eq!(bench.model.theme.text, Color::Red);
    reload(&mut bench, "dark = true\n[roles]\ntext = \"green\"\n");
    assert_eq!(bench.model.theme.text, Color::Green);
    reload(&mut bench, "dark = true\n[roles]\ntext = \"greeen\"\n");
    assert_eq!(bench.model.theme.text, Color::Green);
    assert!(
        said(&bench).contains("mine.toml:3: roles.text"),
        "{}",
        said(&bench)
    );
    bench.send(Msg::Reloaded(Reloaded::Config(Ok(config("yours")))));
    assert_eq!(bench.model.theme.text, Color::Green);
    assert!(said(&bench).contains("yours"), "{}", said(&bench));
    let error = "config.toml:1: no".to_string();
    bench.send(Msg::Reloaded(Reloaded::Config(Err(error))));
    assert!(
        said(&bench).contains("what was set stays"),
        "{}",
        said(&bench)
    );
}

#[test]
fn without_colours_and_without_unicode_everything_is_there() {
    for keys in ["", "?", "ctrl-t", ":", "i", "shift-v", "ctrl-w"] {
        for (columns, rows) in [(80, 24), (200, 60), (40, 10)] {
            let mut bench = bench();
            bench.model.look.depth = ColorDepth::None;
            bench.model.show_theme("auto").unwrap();
            bench.model.look.glyphs = Glyphs::Ascii;
            bench.press(keys);
            let drawn = buffer(&bench, columns, rows);
            for cell in &drawn.content {
                assert!(cell.symbol().is_ascii(), "{keys}: {}", cell.symbol());
                assert!(matches!(cell.fg, Color::Reset) && matches!(cell.bg, Color::Reset));
            }
        }
    }
}

#[test]
fn the_selected_line_is_reversed_in_every_theme() {
    for name in nearmiss_settings::ThemeFile::shipped() {
        let mut bench = bench();
        bench.model.look.chosen = name.into();
        bench.model.show_theme(name).unwrap();
        let drawn = buffer(&bench, 80, 24);
        let row = (0..24)
            .find(|&y| (0..80).any(|x| drawn[(x, y)].symbol() == "▸"))
            .unwrap();
        let start = (0..80).find(|&x| drawn[(x, row)].symbol() == "▸").unwrap();
        for x in start..start + 20 {
            let cell = &drawn[(x, row)];
            assert!(cell.modifier.contains(Modifier::REVERSED), "{name}");
            assert_eq!(
                (cell.fg, cell.bg),
                (bench.model.theme.selection, bench.model.theme.text)
            );
        }
    }
}

#[test]
fn every_pane_has_a_place_in_the_keymap_files() {
    for pane in Pane::ALL {
        assert!(Scope::ALL.iter().any(|(scope, ..)| *scope == pane.scope()));
    }
    let mut bench = bench();
    bench.press("?");
    assert!(bench.model.screens.is_top::<HelpScreen>());
}

#[test]
fn chords_work_in_windows_as_their_hints_say() {
    let mut bench = vim();
    bench.press("n space o d");
    let frame = bench.frame(120, 40);
    assert!(frame.contains("y y copy"), "{frame}");
    bench.press("y");
    assert!(bench.frame(120, 40).contains(" y … "), "what can follow");
    assert!(bench.model.screens.is_top::<DetailsScreen>());
    bench.press("y");
    let Some(Effect::Copy(text)) = bench.effects.last() else {
        panic!("nothing was copied");
    };
    assert!(text.contains("distance"), "{text}");
    bench.press("y x");
    assert!(said(&bench).contains("y x is not bound here"));
    bench.press("y esc");
    assert!(bench.model.screens.is_top::<DetailsScreen>(), "still open");
    bench.press("esc");
    assert!(bench.model.screens.is_empty());
    // Other keys for a window.
    let text = "[window]\ndown = \"f7\"\naccept = \"f8\"\n[global]\nlayers = \"f9\"\n";
    bench.model.look.keymap = Keymap::parse("keymap.toml", text).unwrap();
    let signs = bench.model.map.layers.signs;
    bench.press("f9 f7 f8");
    assert_ne!(bench.model.map.layers.signs, signs);
    assert!(bench.frame(120, 40).contains("F8 switch"));
}
