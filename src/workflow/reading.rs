//! What the user's configuration says of files that are read: tables of tracks, folders of maps, who plays OpenSCENARIO.

use std::path::PathBuf;

use nearmiss_base::system;
use nearmiss_base::system::processes::program;
use nearmiss_formats as formats;
use nearmiss_formats::{NamedTable, Player, TableOptions};
use nearmiss_settings::{Config, Folders};

/// The tables that the configuration describes.
///
/// # Errors
/// It names columns with words that no column has.
pub fn named_tables(config: &Config) -> Result<Vec<NamedTable>, String> {
    let named = config.track_tables().into_iter().map(|(name, table)| {
        let columns = table.columns.parse();
        Ok(NamedTable {
            columns: columns
                .map_err(|error| format!("config.toml: tracks.{name}.columns: {error}"))?,
            name,
            rate: table.rate,
            map: table.map,
        })
    });
    named.collect()
}

/// Tells the readers of recordings how tables are read, where the user's maps are, and who plays scenarios. Said once,
/// before the first file is read.
pub fn read_as_said(tables: TableOptions, config: &Config, folders: Option<&Folders>) {
    formats::read_tables_with(tables);
    if let Some(maps) = &config.maps {
        formats::look_for_maps_in(maps.clone());
    }
    let kept = folders.map(Folders::played);
    formats::play_with(player(config.esmini.as_deref(), kept));
}

/// Who plays OpenSCENARIO files as the configuration says, or why none does and what to do; its recordings are `kept`.
fn player(said: Option<&str>, kept: Option<PathBuf>) -> Result<Player, String> {
    let found = match said {
        Some("off") => return Err("esmini could play it, but is \"off\" in config.toml".into()),
        Some(said) => program(said).ok_or_else(|| format!("config.toml: esmini = \"{said}\" is no program")),
        None => program("esmini").filter(|found| found.is_absolute()).ok_or_else(|| {
            "install esmini (https://github.com/esmini/esmini) or set `esmini` of config.toml to its path".into()
        }),
    };
    // It runs in a folder of its own.
    let absolute = found.and_then(|program| {
        std::path::absolute(&program)
            .map_err(|error| format!("{}: {}", program.display(), system::error_text(&error)))
    });
    absolute.map(|program| Player {
        program,
        kept,
        longest: formats::LONGEST_PLAY,
    })
}
