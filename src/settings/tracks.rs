//! `[tracks.NAME]` of `config.toml`: tables of tracks whose columns the user explains once.

use std::path::PathBuf;

use nearmiss_record::fields::Fields;
use toml::{Table, Value};

use super::Config;
use super::config::wrong;

nearmiss_record::fields! {
    /// A table of tracks; it is read so where it has all of these columns.
    pub struct TrackTable {
        "tracks" {
            /// Role of each column, as in `--columns`: `time=t[ms],id=track,x=px[ft],y=py[ft]`.
            columns [required]: String;
            /// Frame rate, for tables that count frames instead of time.
            rate: Option<f64>, Takes::Above(0.0, 1e6), "Hz";
            /// Map of the recording [default: none].
            map: Option<PathBuf>;
        }
    }
}

impl Config {
    /// The tables of tracks of the file, in the order of names.
    #[must_use]
    pub fn track_tables(&self) -> Vec<(String, TrackTable)> {
        let tables = self.tracks.iter().filter_map(|(name, value)| {
            let table = TrackTable::from_table(value.as_table()?).ok()?;
            Some((name.clone(), table))
        });
        tables.collect()
    }
}

/// What is wrong with the section: the names that lead to each mistake from its beginning, and a message.
pub(super) fn mistakes(section: &Table) -> Vec<(Vec<String>, String)> {
    let mut found = Vec::new();
    for (name, value) in section {
        let path = |key: &[&str]| -> Vec<String> {
            let names = std::iter::once(name.as_str()).chain(key.iter().copied());
            names.map(str::to_string).collect()
        };
        let Value::Table(table) = value else {
            let message = format!("tracks.{name}: expected a table, [tracks.{name}]");
            found.push((path(&[]), message));
            continue;
        };
        if !table.contains_key("columns") {
            found.push((path(&[]), format!("tracks.{name}: columns is missing")));
        }
        for (key, value) in table {
            let message = wrong::<TrackTable>(&format!("tracks.{name}."), key, value);
            found.extend(message.map(|message| (path(&[key]), message)));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn tables_have_columns_a_rate_and_a_map() {
        let text = "[tracks.lab]\ncolumns = \"time=t,id=who\"\nrate = 25\nmap = \"lab.osm\"\n";
        let config: Config = toml::from_str(text).unwrap();
        let [(name, table)] = &config.track_tables()[..] else {
            panic!()
        };
        assert_eq!(
            (name.as_str(), table.columns.as_str()),
            ("lab", "time=t,id=who")
        );
        assert_eq!(
            (table.rate, table.map.as_deref()),
            (Some(25.0), Some("lab.osm".as_ref()))
        );
        let wrong = |text: &str| -> Vec<String> {
            let table: Table = toml::from_str(text).unwrap();
            mistakes(&table)
                .into_iter()
                .map(|(_, words)| words)
                .collect()
        };
        assert_eq!(wrong("[a]\nrate = 1\n"), ["tracks.a: columns is missing"]);
        assert!(wrong("a = 1\n")[0].contains("expected a table"));
        let said = wrong("[a]\ncolumns = \"x=x\"\nrat = 1\nrate = -1\n");
        assert!(
            said[0].contains("did you mean `rate`") && said[1].contains("rate"),
            "{said:?}"
        );
    }
}
