//! Any bytes as a scenario: every command ends with a result or with an error in words.
#![no_main]

use std::path::Path;
use std::sync::LazyLock;

use clap::Parser;
use libfuzzer_sys::fuzz_target;
use nearmiss::{cli, tui};

#[path = "../../hostile/mutated/commands.rs"]
mod commands;
#[path = "../../hostile/mutated/small.rs"]
#[allow(dead_code)]
mod small;

/// A folder of our own, with an ego beside the scenario.
static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a folder for files");
    let ego = folder.path().join("ZAM_Fuzz-1_1_T-1.ego_trajectory.csv");
    std::fs::write(ego, small::ego()).expect("an ego");
    folder
});

fuzz_target!(|bytes: &[u8]| {
    // The first byte says which command.
    let Some((&number, bytes)) = bytes.split_first() else {
        return;
    };
    let folder: &Path = FOLDER.path();
    let file = folder.join("ZAM_Fuzz-1_1_T-1.xml");
    let ego = folder.join("ZAM_Fuzz-1_1_T-1.ego_trajectory.csv");
    std::fs::write(&file, bytes).expect("a scenario");
    let words = commands::words(usize::from(number) % commands::COUNT, &file, &ego, folder);
    let arguments = cli::Arguments::try_parse_from(words).expect("a command line without mistakes");
    let workbench = cli::Workbench {
        themes: tui::themes,
        keys: tui::keys,
        key_bindings: tui::key_bindings,
        theme_mistakes: tui::theme_mistakes,
        terminal: tui::terminal_here,
        screen: tui::screen,
    };
    let command = arguments.command.expect("a headless command");
    if let Err(failure) = cli::run(&command, &workbench) {
        assert!(!failure.message.trim().is_empty() || failure.status == 1);
    }
});
