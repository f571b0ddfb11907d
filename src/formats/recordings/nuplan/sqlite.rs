//! SQLite files of others: their tables and rows, without writing to them or beside them.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;

use nearmiss_base::system;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, OpenFlags, Params, Row};

use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::{At, Leftovers, Report};

/// How SQLite files begin.
pub const MAGIC: &[u8] = b"SQLite format 3\0";

/// No table that is read has more rows.
const MOST_ROWS: usize = 20_000_000;

/// Tables of a file that are looked at.
const MOST_TABLES: usize = 10_000;

/// Tables of SQLite and of GeoPackage about the others begin so.
const BOOKKEEPING: [&str; 4] = ["sqlite_", "gpkg_", "rtree_", "alembic_"];

/// So many tables of a file are named in a message.
const MAX_LISTED: usize = 6;

/// No row takes fewer bytes.
const SMALLEST_ROW: u64 = 4;

/// A file that is only read.
pub struct Database {
    connection: Connection,
    report: Report,
    tables: Vec<String>,
    most_rows: usize,
    /// The columns of tables that were asked for, in lower case.
    asked: RefCell<TableColumns>,
}

/// Columns of tables.
pub type TableColumns = BTreeMap<String, BTreeSet<String>>;

/// What is done with a row.
pub type Take<'t> = &'t mut dyn FnMut(&Record<'_>) -> Result<(), ReadError>;

/// A query that is asked once or often.
pub struct Query<'q> {
    sql: String,
    database: &'q Database,
    table: &'q str,
    columns: &'q [&'q str],
}

impl Database {
    /// Opens a file as one that does not change: SQLite makes neither locks nor files beside it.
    ///
    /// # Errors
    /// It cannot be opened, or is damaged.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let report = Report::about(path.display().to_string());
        let io = |error| ReadError::io(report.file(), &error);
        system::check_file(path).map_err(io)?;
        let bytes = path.metadata().map_err(io)?.len();
        let whole = std::path::absolute(path).map_err(io)?;
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY
            | OpenFlags::SQLITE_OPEN_NO_MUTEX
            | OpenFlags::SQLITE_OPEN_URI;
        let opened = Connection::open_with_flags(address(&whole), flags).and_then(|connection| {
            // Nothing in the file is run: no functions in its views, triggers and indexes.
            connection.execute_batch("PRAGMA trusted_schema=OFF; PRAGMA cell_size_check=ON")?;
            let tables = tables(&connection)?;
            Ok((connection, tables))
        });
        let (connection, tables) = opened.map_err(|error| report.fail(error_text(&error)))?;
        Ok(Self {
            connection,
            report,
            tables,
            asked: RefCell::default(),
            // Pages of a damaged file may lead in circles.
            most_rows: usize::try_from(bytes / SMALLEST_ROW)
                .map_or(MOST_ROWS, |n| n.min(MOST_ROWS)),
        })
    }

    /// The names of its tables; views and virtual tables are none.
    pub fn tables(&self) -> &[String] {
        &self.tables
    }

    /// Whether it has a table.
    pub fn has(&self, table: &str) -> bool {
        self.tables.iter().any(|name| name == table)
    }

    /// Whether rows are found by a column without looking at all.
    pub fn has_index(&self, table: &str, column: &str) -> bool {
        let sql = "SELECT count(*) FROM pragma_index_list(?1) AS list, pragma_index_info(list.name) AS info WHERE info.seqno = 0 AND info.name = ?2";
        let count = self
            .connection
            .query_row(sql, [table, column], |row| row.get::<_, i64>(0));
        count.is_ok_and(|count| count > 0)
    }

    /// A query of columns of a table; one that begins with `?` may be missing, and is empty then. The first one is the key
    /// of a row; `rest` follows the name of the table.
    ///
    /// # Errors
    /// The table or a column is missing.
    pub fn query<'q>(
        &'q self,
        table: &'q str,
        columns: &'q [&'q str],
        rest: &str,
    ) -> Result<Query<'q>, ReadError> {
        if !self.has(table) {
            return Err(self.table(table).fail("the table is missing"));
        }
        let known = self
            .columns(table)
            .map_err(|error| self.table(table).fail(error_text(&error)))?;
        {
            let mut tables = self.asked.borrow_mut();
            let asked = tables.entry(table.to_string()).or_default();
            let names = columns.iter().map(|name| name.trim_start_matches('?'));
            asked.extend(names.map(str::to_lowercase));
        }
        let mut parts = Vec::with_capacity(columns.len());
        for column in columns {
            let name = column.trim_start_matches('?');
            // Names of columns are those of this program.
            // `rowid` is one that every table has.
            parts.push(
                if name == "rowid" || known.iter().any(|n| n.eq_ignore_ascii_case(name)) {
                    format!("\"{name}\"")
                } else if name.len() < column.len() {
                    "NULL".into()
                } else {
                    let message = format!("no column `{name}`; it has {}", first_names(&known));
                    return Err(self.table(table).fail(message));
                },
            );
        }
        Ok(Query {
            sql: format!("SELECT {} FROM \"{table}\" {rest}", parts.join(", ")),
            database: self,
            table,
            columns,
        })
    }

    fn columns(&self, table: &str) -> rusqlite::Result<Vec<String>> {
        let sql = "SELECT name FROM pragma_table_info(?1)";
        let mut found = self.connection.prepare_cached(sql)?;
        let names = found.query_map([table], |row| row.get::<_, String>(0))?;
        names.collect()
    }

    /// The columns that were asked for so far.
    pub fn asked(&self) -> TableColumns {
        self.asked.borrow().clone()
    }

    /// Counts the tables that neither this nor an earlier reading asked for, and the columns of the others.
    pub fn count_unused(&self, earlier: &TableColumns, leftovers: &mut Leftovers) {
        let asked = self.asked.borrow();
        let own = |name: &&String| !BOOKKEEPING.iter().any(|start| name.starts_with(start));
        for table in self.tables.iter().filter(own) {
            let known = [&*asked, earlier].map(|all| all.get(table));
            if known.iter().all(Option::is_none) {
                leftovers.add(&format!("table {table}"), || 0);
                continue;
            }
            for column in self.columns(table).unwrap_or_default() {
                let lower = column.to_lowercase();
                let is_asked = known.iter().flatten().any(|names| names.contains(&lower));
                // Keys are how errors and other tables name a row.
                if !is_asked && lower != "token" && lower != "fid" {
                    leftovers.add(&format!("table {table}, column {column}"), || 0);
                }
            }
        }
    }

    /// Gives all rows of a table to `take`.
    ///
    /// # Errors
    /// The table is missing or damaged, or `take` refuses a row.
    pub fn each(&self, table: &str, columns: &[&str], take: Take<'_>) -> Result<(), ReadError> {
        self.query(table, columns, "")?.each([], take)
    }

    /// Gives the rows with a token in a column to `take`.
    ///
    /// # Errors
    /// As [`each`](Self::each).
    pub fn with_token(
        &self,
        table: &str,
        columns: &[&str],
        column: &str,
        token: Token,
        take: Take<'_>,
    ) -> Result<(), ReadError> {
        let rest = format!("WHERE \"{column}\" = ?1");
        let query = self.query(table, columns, &rest)?;
        query.each([token.to_be_bytes()], take)
    }

    fn table(&self, table: &str) -> At<'_> {
        self.report.at(format!("table {table}"))
    }

    /// An error about the whole file.
    pub fn fail(&self, message: impl Into<String>) -> ReadError {
        self.report.fail(message)
    }
}

impl Query<'_> {
    /// Gives its rows to `take`.
    ///
    /// # Errors
    /// The table is damaged, or `take` refuses a row.
    pub fn each(&self, parameters: impl Params, take: Take<'_>) -> Result<(), ReadError> {
        let at = || self.database.table(self.table);
        let fail = |error: rusqlite::Error| at().fail(error_text(&error));
        let mut prepared = { self.database.connection.prepare_cached(&self.sql) }.map_err(fail)?;
        let mut rows = prepared.query(parameters).map_err(fail)?;
        let mut count = 0;
        while let Some(row) = rows.next().map_err(fail)? {
            count += 1;
            let most = self.database.most_rows;
            if count > most {
                return Err(at().fail(format!("more than {most} rows; is the file damaged?")));
            }
            take(&Record {
                row,
                report: &self.database.report,
                table: self.table,
                columns: self.columns,
            })?;
        }
        Ok(())
    }
}

fn tables(connection: &Connection) -> rusqlite::Result<Vec<String>> {
    let sql = "SELECT name FROM sqlite_schema WHERE type = 'table' AND sql LIKE 'CREATE TABLE%'";
    let mut found = connection.prepare(sql)?;
    let names = found.query_map([], |row| row.get(0))?;
    names.take(MOST_TABLES).collect()
}

/// The first ones of some names.
pub fn first_names(names: &[String]) -> String {
    let more = match names.len().saturating_sub(MAX_LISTED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let first = &names[..names.len().min(MAX_LISTED)];
    format!("{}{more}", first.join(", "))
}

/// What SQLite says, and what that means for a file that is only read.
fn error_text(error: &rusqlite::Error) -> String {
    use rusqlite::ErrorCode::{DatabaseCorrupt, NotADatabase};
    match error.sqlite_error_code() {
        Some(DatabaseCorrupt | NotADatabase) => {
            "the file is damaged or cut short; get it again".into()
        }
        _ => format!("SQLite: {error}"),
    }
}

/// The address of a file that does not change.
fn address(path: &Path) -> String {
    let mut address = String::from("file:");
    for byte in path.as_os_str().as_encoded_bytes() {
        // `/C:/…` on Windows.
        match byte {
            b'\\' if cfg!(windows) => address.push('/'),
            b'/' | b'.' | b'-' | b'_' | b':' => address.push(char::from(*byte)),
            _ if byte.is_ascii_alphanumeric() => address.push(char::from(*byte)),
            _ => {
                let _ = write!(address, "%{byte:02x}");
            }
        }
    }
    address.push_str("?immutable=1");
    address
}

/// The key of a row: eight bytes in nuPlan.
pub type Token = u64;

/// A row of a table. Its first column is its key, by which errors name it.
pub struct Record<'r> {
    pub(super) row: &'r Row<'r>,
    pub(super) report: &'r Report,
    pub(super) table: &'r str,
    pub(super) columns: &'r [&'r str],
}

impl Record<'_> {
    fn value(&self, column: usize) -> ValueRef<'_> {
        self.row.get_ref(column).unwrap_or(ValueRef::Null)
    }

    /// The place of a column, for errors.
    pub fn at(&self, column: usize) -> At<'_> {
        let key = match self.value(0) {
            ValueRef::Integer(number) => number.to_string(),
            ValueRef::Text(text) => String::from_utf8_lossy(text).chars().take(40).collect(),
            ValueRef::Blob(bytes) => hex(bytes),
            _ => "?".into(),
        };
        let (table, column) = (self.table, self.columns.get(column).unwrap_or(&""));
        let column = column.trim_start_matches('?');
        self.report
            .at(format!("table {table}, row {key}, column {column}"))
    }

    /// Whether a column has nothing.
    pub fn is_empty(&self, column: usize) -> bool {
        self.value(column) == ValueRef::Null
    }

    /// A number.
    pub fn number(&self, column: usize) -> Result<f64, ReadError> {
        let value = match self.value(column) {
            ValueRef::Integer(value) => value as f64,
            ValueRef::Real(value) => value,
            other => return Err(self.wrong(column, other, "a number")),
        };
        if value.abs() < 1e6 {
            Ok(value)
        } else {
            self.at(column).number(value)
        }
    }

    /// A number, where there is one.
    pub fn optional_number(&self, column: usize) -> Result<Option<f64>, ReadError> {
        if self.is_empty(column) {
            Ok(None)
        } else {
            self.number(column).map(Some)
        }
    }

    /// A whole number.
    pub fn integer(&self, column: usize) -> Result<i64, ReadError> {
        match self.value(column) {
            ValueRef::Integer(value) => Ok(value),
            ValueRef::Real(value) if value.fract() == 0.0 && value.abs() < 1e15 => Ok(value as i64),
            other => Err(self.wrong(column, other, "a whole number")),
        }
    }

    /// A whole number, where there is one; keys of other tables are text in some files.
    pub fn optional_whole(&self, column: usize) -> Result<Option<i64>, ReadError> {
        match self.value(column) {
            ValueRef::Null => Ok(None),
            ValueRef::Text(text) => {
                let text = String::from_utf8_lossy(text);
                Ok(text.trim().parse::<f64>().ok().map(|value| value as i64))
            }
            _ => self.integer(column).map(Some),
        }
    }

    /// A text; nothing where there is none.
    pub fn text(&self, column: usize) -> String {
        match self.value(column) {
            ValueRef::Text(text) => String::from_utf8_lossy(text).into_owned(),
            ValueRef::Integer(value) => value.to_string(),
            _ => String::new(),
        }
    }

    /// Bytes.
    pub fn bytes(&self, column: usize) -> Result<&[u8], ReadError> {
        match self.value(column) {
            ValueRef::Blob(bytes) => Ok(bytes),
            other => Err(self.wrong(column, other, "a geometry")),
        }
    }

    /// The key of a row.
    pub fn token(&self, column: usize) -> Result<Token, ReadError> {
        let value = self.value(column);
        let bytes = match value {
            ValueRef::Blob(bytes) => <[u8; 8]>::try_from(bytes).ok(),
            _ => None,
        };
        let token = bytes.map(Token::from_be_bytes);
        token.ok_or_else(|| self.wrong(column, value, "a token of 8 bytes"))
    }

    /// The key of a row, where there is one.
    pub fn optional_token(&self, column: usize) -> Result<Option<Token>, ReadError> {
        if self.is_empty(column) {
            Ok(None)
        } else {
            self.token(column).map(Some)
        }
    }

    fn wrong(&self, column: usize, found: ValueRef<'_>, wanted: &str) -> ReadError {
        let found = match found {
            ValueRef::Null => "it is empty".to_string(),
            ValueRef::Integer(value) => format!("`{value}`"),
            ValueRef::Real(value) => format!("`{value}`"),
            ValueRef::Text(text) => {
                let text: String = String::from_utf8_lossy(text).chars().take(40).collect();
                format!("`{text}`")
            }
            ValueRef::Blob(bytes) => format!("{} bytes", bytes.len()),
        };
        self.at(column).fail(format!("{found}, not {wanted}"))
    }
}

fn hex(bytes: &[u8]) -> String {
    let all = bytes.iter().take(16);
    all.fold(String::new(), |mut hex, byte| {
        let _ = write!(hex, "{byte:02x}");
        hex
    })
}
