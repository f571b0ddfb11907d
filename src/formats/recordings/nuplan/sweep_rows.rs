//! The rows of a table that belong to sweeps of the lidar, found without looking at all of them each time.

use std::collections::HashMap;
use std::mem::size_of;

use super::clock::Clock;
use super::record::{Record, Token};
use super::sqlite::Database;
use crate::commonroad::ReadError;

/// The column that names the sweep of a row.
const SWEEP: &str = "lidar_pc_token";

/// Where the rows of each sweep are.
#[derive(Debug)]
pub enum SweepRows {
    /// An index of the file finds them.
    Indexed,
    /// From one row to another, by the places of sweeps.
    Runs(Vec<Vec<(i64, i64)>>),
}

impl SweepRows {
    /// Of a table, which may be missing; `sweeps` are the places of sweeps.
    ///
    /// # Errors
    /// The table is damaged.
    pub fn find(
        database: &Database,
        table: &str,
        sweeps: &HashMap<Token, usize>,
    ) -> Result<Self, ReadError> {
        if database.has_index(table, SWEEP) {
            return Ok(Self::Indexed);
        }
        let mut runs = vec![Vec::new(); sweeps.len()];
        if !database.has(table) {
            return Ok(Self::Runs(runs));
        }
        database.each(table, &["rowid", SWEEP], &mut |row| {
            let Some(place) = sweeps.get(&row.token(1)?) else {
                return Ok(());
            };
            let number = row.whole(0)?;
            let runs: &mut Vec<(i64, i64)> = &mut runs[*place];
            match runs.last_mut() {
                Some((_, last)) if last.checked_add(1) == Some(number) => *last = number,
                _ => runs.push((number, number)),
            }
            Ok(())
        })?;
        Ok(Self::Runs(runs))
    }

    /// Bytes.
    pub fn size(&self) -> usize {
        match self {
            Self::Indexed => 0,
            Self::Runs(runs) => {
                let each = runs
                    .iter()
                    .map(|runs| size_of::<Vec<()>>() + 16 * runs.capacity());
                each.sum()
            }
        }
    }

    /// Gives the rows of the sweeps of a clock to `take`, with their steps.
    ///
    /// # Errors
    /// The table is missing or damaged, or `take` refuses a row.
    pub fn each(
        &self,
        database: &Database,
        table: &str,
        columns: &[&str],
        clock: &Clock<'_>,
        take: &mut dyn FnMut(&Record<'_>, i64) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        match self {
            Self::Indexed => {
                let query = database.query(table, columns, &format!("WHERE {SWEEP} = ?1"))?;
                for (place, step) in &clock.sweeps {
                    let token = clock.log.sweeps[*place].token.to_be_bytes();
                    query.each([token], &mut |row| take(row, *step))?;
                }
            }
            Self::Runs(runs) => {
                let query = database.query(table, columns, "WHERE rowid BETWEEN ?1 AND ?2")?;
                for (place, step) in &clock.sweeps {
                    for (first, last) in &runs[*place] {
                        query.each([first, last], &mut |row| take(row, *step))?;
                    }
                }
            }
        }
        Ok(())
    }
}
