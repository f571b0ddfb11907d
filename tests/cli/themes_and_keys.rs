//! `themes` and `keys`, and a terminal that cannot move its cursor.

use super::support::program::Home;

#[test]
fn themes_are_shown_in_as_many_colours_as_asked_for() {
    let home = Home::new();
    let plain = home.run(&["config", "themes"]).status(0);
    assert!(!plain.stdout.contains('\x1b'), "{}", plain.stdout);
    for name in ["dark", "light", "contrast", "colorblind"] {
        assert!(plain.stdout.contains(name), "{}", plain.stdout);
    }
    for (depth, sign) in [("true", "[38;2;"), ("256", "[38;5;"), ("16", "[9")] {
        let ended = home
            .run(&["config", "themes", "dark", "--depth", depth])
            .status(0);
        assert!(ended.stdout.contains(sign), "{}", ended.stdout);
    }
    let unknown = home.run(&["config", "themes", "darkk"]).status(2);
    assert!(
        unknown.stderr.contains("unknown theme `darkk`"),
        "{}",
        unknown.stderr
    );
}

#[test]
fn a_theme_with_mistakes_is_named_with_line_and_key() {
    let home = Home::new();
    let path = home.config().join("themes/mine.toml");
    home.write(path, "dark = true\n[roles]\ntext = \"blurple\"\n");
    let ended = home.run(&["config", "themes", "mine"]).status(2);
    assert!(
        ended.stderr.contains("mine.toml:3: roles.text"),
        "{}",
        ended.stderr
    );
    let all = home.run(&["config", "themes"]).status(0);
    assert!(
        all.stdout.contains("mine.toml:3: roles.text"),
        "{}",
        all.stdout
    );
}

#[test]
fn the_printed_keymap_is_a_keymap() {
    let home = Home::new();
    let path = home.config().join("keymap.toml");
    let table = home.run(&["config", "keys"]).status(0).stdout;
    assert!(
        table.contains("palette") && table.contains("ctrl-p"),
        "{table}"
    );
    let printed = home
        .run(&["config", "keys", "--format=toml"])
        .status(0)
        .stdout;
    home.write(&path, printed);
    let again = home.run(&["config", "keys"]).status(0).stdout;
    // The columns may be narrower without it.
    let words = |table: &str| -> Vec<String> {
        let words = table.split_whitespace().filter(|word| *word != "ctrl-c");
        words
            .map(|word| word.trim_end_matches(',').to_string())
            .collect()
    };
    assert_eq!(words(&table), words(&again));
    home.write(&path, "preset = \"vim\"\n[global]\nplay = \"f9\"\n");
    let own = home.run(&["config", "keys"]).status(0).stdout;
    assert!(own.contains("f9") && own.contains("g g"), "{own}");
    let vim = home
        .run(&["config", "keys", "--preset", "vim"])
        .status(0)
        .stdout;
    assert!(!vim.contains("f9") && vim.contains("g g"), "{vim}");
}

#[test]
fn every_mistake_of_a_keymap_is_named() {
    let home = Home::new();
    let path = home.config().join("keymap.toml");
    home.write(
        path,
        "[global]\nplay = \"f5\"\nquitt = \"q\"\nhelp = \"hyper-h\"\nworst = \"f5\"\n",
    );
    let ended = home.run(&["config", "keys"]).status(2);
    for words in [
        "keymap.toml:5: global.worst: `f5` is also the key of global.play in line 2",
        "keymap.toml:3: unknown action `global.quitt`; did you mean `quit`?",
        "keymap.toml:4: global.help: `hyper-h` is not a key",
    ] {
        assert!(ended.stderr.contains(words), "{}", ended.stderr);
    }
}
