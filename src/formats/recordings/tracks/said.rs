//! What the user says of tables, and to which files that applies.

use std::cell::RefCell;
use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use super::Columns;
use crate::Entry;
use crate::dispatch::{self, Applies};

/// What the user says of tables.
#[derive(Debug, Clone, Default)]
pub struct TableOptions {
    /// Of every table.
    pub columns: Option<Columns>,
    /// Frames a second.
    pub rate: Option<f64>,
    /// The map beside every table.
    pub map: Option<PathBuf>,
    /// Tables of the configuration, by name; one fits a table that has all of its columns.
    pub named: Vec<NamedTable>,
}

/// A table that the configuration describes.
#[derive(Debug, Clone)]
pub struct NamedTable {
    /// Its name.
    pub name: String,
    /// Its columns.
    pub columns: Columns,
    /// Frames a second.
    pub rate: Option<f64>,
    /// The map beside it.
    pub map: Option<PathBuf>,
}

static OPTIONS: OnceLock<Arc<TableOptions>> = OnceLock::new();

/// Says how the user's tables are to be read. Said once, before the first one is read, so that all readings of a table are
/// the same.
pub fn read_tables_with(options: TableOptions) {
    // What is said again is what is said already: there is one command line.
    let _ = OPTIONS.set(Arc::new(options));
}

thread_local! {
    /// What is said of the tables that this thread reads now, in place of that.
    static NOW: RefCell<Option<Arc<TableOptions>>> = const { RefCell::new(None) };
}

/// Reads tables as these options say, whatever is said of others; what is read is not kept for other readings.
pub fn reading_tables_with<T>(options: TableOptions, read: impl FnOnce() -> T) -> T {
    /// Also where reading panics.
    struct Before(Option<Arc<TableOptions>>);
    impl Drop for Before {
        fn drop(&mut self) {
            NOW.set(self.0.take());
        }
    }
    let _before = Before(NOW.replace(Some(Arc::new(options))));
    read()
}

/// Whether [`reading_tables_with`] reads.
pub(super) fn is_own_reading() -> bool {
    NOW.with_borrow(Option::is_some)
}

pub(super) fn options() -> Arc<TableOptions> {
    let now = NOW.with_borrow(Option::clone);
    now.unwrap_or_else(|| OPTIONS.get_or_init(Arc::default).clone())
}

/// What is said of all tables that are read otherwise.
#[must_use]
pub fn usual_table_options() -> TableOptions {
    (**OPTIONS.get_or_init(Arc::default)).clone()
}

/// Refuses what the user says of every table where it applies to none of these scenarios; `has_others` is whether other
/// tables are read beside them.
///
/// # Errors
/// An option that applies to nothing.
pub fn check_table_options(entries: &[Entry], has_others: bool) -> Result<(), String> {
    let options = options();
    let said = [
        ("--columns", options.columns.is_some(), Applies::All),
        ("--rate", options.rate.is_some(), Applies::All),
        ("--map", options.map.is_some(), Applies::Map),
    ];
    let said = said.into_iter();
    let said =
        said.filter(|(_, is_said, wanted)| *is_said && !(has_others && *wanted == Applies::All));
    for (option, _, wanted) in said {
        // Of a long recording there are many scenarios.
        let files: HashSet<PathBuf> = entries.iter().filter_map(Entry::file).collect();
        if files.iter().any(|file| dispatch::applies(file) >= wanted) {
            continue;
        }
        let (more, has, have) = match wanted {
            Applies::Map => (
                " and recordings of esmini, ASAM OSI, nuScenes and py123d",
                ", which has its own",
                ", which have their own",
            ),
            _ => (" (`nearmiss help tracks`)", "", ""),
        };
        let others = match entries {
            [one] => format!("{}{has}", one.display()),
            all => format!("these {} scenarios{have}", all.len()),
        };
        return Err(format!(
            "{option} applies to tables of tracks{more}, not to {others}; leave it out"
        ));
    }
    Ok(())
}
