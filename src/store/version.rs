//! The version of the store's file, which is made whole in one transaction.

use rusqlite::{Connection, TransactionBehavior};

use super::StoreError;

/// Makes the tables of a new file.
const SCHEMA: &str = include_str!("schema.sql");

/// The version of a file that this program reads and writes.
pub const VERSION: i64 = 13;

/// Makes the tables of a new file. Several programs may try at once; one does it, the others wait.
pub fn create_tables(connection: &mut Connection) -> Result<(), StoreError> {
    if check_version(connection)? == VERSION {
        return Ok(());
    }
    let transaction = connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
    if check_version(&transaction)? == 0 {
        let tables: i64 =
            transaction.query_row("SELECT count(*) FROM sqlite_master", [], |row| row.get(0))?;
        if tables > 0 {
            return Err(StoreError::Foreign);
        }
        transaction.execute_batch(SCHEMA)?;
        transaction.pragma_update(None, "user_version", VERSION)?;
    }
    transaction.commit()?;
    Ok(())
}

/// The version of a file: [`VERSION`], or 0 of one without tables.
pub fn check_version(connection: &Connection) -> Result<i64, StoreError> {
    let found = connection.query_row("PRAGMA user_version", [], |row| row.get(0))?;
    match found {
        0 | VERSION => Ok(found),
        newer if newer > VERSION => Err(StoreError::Newer {
            found,
            known: VERSION,
        }),
        _ => Err(StoreError::Older {
            found,
            known: VERSION,
        }),
    }
}
