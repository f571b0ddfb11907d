//! TFRecord files: one record after the other, each with its checksums, and which scenarios a file holds where.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use nearmiss_base::system;

use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::Report;

/// Length and its checksum, bytes.
pub const HEADER: usize = 12;

/// The payload's checksum, bytes.
const FOOTER: u64 = 4;

/// No scenario is larger, bytes; decoded, one takes many times as much.
const LARGEST_RECORD: u64 = 32 << 20;

/// More records are not in a file.
const MOST_RECORDS: usize = 1_000_000;

/// Where a record's payload lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Record {
    /// From 0.
    pub place: usize,
    /// Byte at which the payload begins.
    pub offset: u64,
    /// Bytes.
    pub length: u64,
}

/// A file of records that is read forwards.
pub struct Records {
    reader: BufReader<File>,
    at: u64,
    size: u64,
    count: usize,
    pub report: Report,
}

/// Whether a file that begins with `head` has records: the checksum of the first length tells.
pub fn begins(head: &[u8]) -> bool {
    let Some((length, checksum)) = head.split_at_checked(8) else {
        return false;
    };
    checksum.first_chunk().map(|c| u32::from_le_bytes(*c)) == Some(masked(length))
}

impl Records {
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let name = path.display().to_string();
        let io = |error: std::io::Error| ReadError::io(&name, &error);
        let file = system::open_file(path).map_err(io)?;
        let size = file.metadata().map_err(io)?.len();
        Ok(Self {
            reader: BufReader::new(file),
            at: 0,
            size,
            count: 0,
            report: Report::about(name),
        })
    }

    /// The next record, whose payload comes next in the file; nothing at its end.
    pub fn next(&mut self) -> Result<Option<Record>, ReadError> {
        if self.at == self.size {
            return Ok(None);
        }
        let place = self.count;
        let fail = |report: &Report, message: String| report.at(record(place)).fail(message);
        if place >= MOST_RECORDS {
            return Err(fail(
                &self.report,
                format!("more than {MOST_RECORDS} records"),
            ));
        }
        if self.size - self.at < HEADER as u64 {
            let message = format!("the file ends at byte {}, within its length", self.size);
            return Err(fail(&self.report, message));
        }
        let mut header = [0; HEADER];
        self.fill(&mut header, place)?;
        if !begins(&header) {
            let message = format!(
                "the checksum of its length, at byte {}, is wrong; the file is damaged",
                self.at - HEADER as u64
            );
            return Err(fail(&self.report, message));
        }
        let length = header.first_chunk().map_or(0, |l| u64::from_le_bytes(*l));
        let left = self.size - self.at;
        if left.checked_sub(FOOTER).is_none_or(|left| length > left) {
            let message =
                format!("it has {length} bytes, but the file ends after {left}; it is truncated");
            return Err(fail(&self.report, message));
        }
        if length > LARGEST_RECORD {
            let (size, most) = (length >> 20, LARGEST_RECORD >> 20);
            let message = format!("{size} MiB; at most {most} MiB of a record are read");
            return Err(fail(&self.report, message));
        }
        self.count += 1;
        Ok(Some(Record {
            place,
            offset: self.at,
            length,
        }))
    }

    /// Goes to what follows a record.
    pub fn pass(&mut self, record: Record) -> Result<(), ReadError> {
        self.go_to(record.offset + record.length + FOOTER, record.place)
    }

    /// The payload of a record, checked.
    pub fn payload(&mut self, record: Record) -> Result<Vec<u8>, ReadError> {
        self.go_to(record.offset, record.place)?;
        let mut bytes = vec![0; usize::try_from(record.length).unwrap_or_default()];
        self.fill(&mut bytes, record.place)?;
        let mut checksum = [0; FOOTER as usize];
        self.fill(&mut checksum, record.place)?;
        if u32::from_le_bytes(checksum) != masked(&bytes) {
            let message = "its checksum is wrong; the file is damaged";
            return Err(self.report.at(self::record(record.place)).fail(message));
        }
        Ok(bytes)
    }

    /// A string field of the message in a record, found without reading the others; nothing if it is not there.
    pub fn string_field(
        &mut self,
        record: Record,
        number: u64,
    ) -> Result<Option<String>, ReadError> {
        let end = record.offset + record.length;
        while self.at < end {
            let Some(key) = self.varint(record)? else {
                return Ok(None);
            };
            let length = match key & 7 {
                0 => {
                    self.varint(record)?;
                    continue;
                }
                1 => 8,
                2 => match self.varint(record)? {
                    Some(length) => length,
                    None => return Ok(None),
                },
                5 => 4,
                _ => return Ok(None),
            };
            if length > end.saturating_sub(self.at) {
                return Ok(None);
            }
            if key == number << 3 | 2 {
                let mut text = vec![0; usize::try_from(length.min(LONGEST_TEXT)).unwrap_or(0)];
                self.fill(&mut text, record.place)?;
                return Ok(String::from_utf8(text).ok());
            }
            self.go_to(self.at + length, record.place)?;
        }
        Ok(None)
    }

    fn varint(&mut self, record: Record) -> Result<Option<u64>, ReadError> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            if self.at >= record.offset + record.length {
                return Ok(None);
            }
            let mut byte = [0];
            self.fill(&mut byte, record.place)?;
            value |= u64::from(byte[0] & 0x7f) << shift;
            if byte[0] < 0x80 {
                return Ok(Some(value));
            }
        }
        Ok(None)
    }

    fn go_to(&mut self, at: u64, place: usize) -> Result<(), ReadError> {
        // Within what is buffered if it lies there.
        let by = i64::try_from(i128::from(at) - i128::from(self.at)).unwrap_or(i64::MAX);
        let gone = self
            .reader
            .seek_relative(by)
            .or_else(|_| self.reader.seek(SeekFrom::Start(at)).map(|_| ()));
        gone.map_err(|error| self.io(&error, place))?;
        self.at = at;
        Ok(())
    }

    fn fill(&mut self, bytes: &mut [u8], place: usize) -> Result<(), ReadError> {
        let read = self.reader.read_exact(bytes);
        read.map_err(|error| self.io(&error, place))?;
        self.at += bytes.len() as u64;
        Ok(())
    }

    fn io(&self, error: &std::io::Error, place: usize) -> ReadError {
        let message = match error.kind() {
            ErrorKind::UnexpectedEof => "the file became shorter while it was read".into(),
            _ => system::error_text(error),
        };
        self.report.at(record(place)).fail(message)
    }
}

/// No id is longer, bytes.
const LONGEST_TEXT: u64 = 256;

/// A record in messages, counted from 1.
pub fn record(place: usize) -> String {
    format!("record {}", place + 1)
}

/// The polynomial, its bits reversed.
const POLYNOMIAL: u32 = 0x82f6_3b78;

/// For each byte, and that byte with up to seven zeros after it: its remainder.
static TABLES: [[u32; 256]; 8] = tables();

const fn tables() -> [[u32; 256]; 8] {
    let mut tables = [[0; 256]; 8];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = byte as u32;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 1 == 1 {
                crc >> 1 ^ POLYNOMIAL
            } else {
                crc >> 1
            };
            bit += 1;
        }
        tables[0][byte] = crc;
        byte += 1;
    }
    let mut zeros = 1;
    while zeros < 8 {
        let mut byte = 0;
        while byte < 256 {
            let before = tables[zeros - 1][byte];
            tables[zeros][byte] = before >> 8 ^ tables[0][(before & 0xff) as usize];
            byte += 1;
        }
        zeros += 1;
    }
    tables
}

/// The checksum of `bytes`.
pub fn crc32c(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    let (eights, rest) = bytes.as_chunks::<8>();
    for eight in eights {
        let first = crc.to_le_bytes();
        crc = 0;
        for (i, byte) in eight.iter().enumerate() {
            let byte = byte ^ first.get(i).copied().unwrap_or(0);
            crc ^= TABLES[7 - i][usize::from(byte)];
        }
    }
    for byte in rest {
        crc = crc >> 8 ^ TABLES[0][usize::from(crc as u8 ^ byte)];
    }
    !crc
}

/// The checksum as TFRecord files write it.
pub fn masked(bytes: &[u8]) -> u32 {
    crc32c(bytes).rotate_right(15).wrapping_add(0xa282_ead8)
}

/// The field of a scenario with its id.
const SCENARIO_ID: u64 = 5;

/// No name of a scenario is longer.
const LONGEST_NAME: usize = 64;

/// Names of the scenarios in a file, with their places.
#[derive(Debug, Default)]
pub struct Index {
    /// In the order of the file. A scenario without a usable id has its place as its name, from 1.
    pub names: Vec<String>,
    records: Vec<Record>,
    by_name: HashMap<String, usize>,
}

impl Index {
    /// A scenario by its name, or by its place from 1.
    pub fn record(&self, part: &str) -> Option<Record> {
        let by_place = || part.parse::<usize>().ok()?.checked_sub(1);
        let place = self.by_name.get(part).copied().or_else(by_place)?;
        self.records.get(place).copied()
    }

    /// The only scenario.
    pub fn only(&self) -> Option<Record> {
        match self.records[..] {
            [only] => Some(only),
            _ => None,
        }
    }

    fn scan(path: &Path) -> Result<Self, ReadError> {
        let mut file = Records::open(path)?;
        let mut index = Self::default();
        while let Some(record) = file.next()? {
            let id = file.string_field(record, SCENARIO_ID)?;
            file.pass(record)?;
            let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
            let usable = |id: &String| {
                (1..=LONGEST_NAME).contains(&id.len())
                    && id.chars().all(plain)
                    && !index.by_name.contains_key(id)
            };
            let name = id
                .filter(usable)
                .unwrap_or_else(|| (record.place + 1).to_string());
            index.by_name.entry(name.clone()).or_insert(record.place);
            index.names.push(name);
            index.records.push(record);
        }
        Ok(index)
    }
}

/// A file as it was when it was looked through.
type CachedIndex = (PathBuf, u64, Option<SystemTime>, Arc<Index>);

/// The file that was looked through last: each of its scenarios asks for the same index.
static LAST: Mutex<Option<CachedIndex>> = Mutex::new(None);

/// The scenarios of a file, found by reading their ids only.
///
/// # Errors
/// The file cannot be read or is damaged: with the record.
pub fn scenario_index(path: &Path) -> Result<Arc<Index>, ReadError> {
    let found = path
        .metadata()
        .map_err(|error| ReadError::io(&path.display().to_string(), &error))?;
    let now = (found.len(), found.modified().ok());
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((seen, size, changed, index)) = &*last
        && seen == path
        && (*size, *changed) == now
    {
        return Ok(Arc::clone(index));
    }
    let index = Arc::new(Index::scan(path)?);
    *last = Some((path.to_path_buf(), now.0, now.1, Arc::clone(&index)));
    Ok(index)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_checksums() {
        assert_eq!(crc32c(b""), 0);
        assert_eq!(crc32c(b"123456789"), 0xe306_9283);
        // From RFC 3720: 32 zeros, 32 ones, and 32 bytes counting up.
        assert_eq!(crc32c(&[0; 32]), 0x8a91_36aa);
        assert_eq!(crc32c(&[0xff; 32]), 0x62a8_ab43);
        let up: Vec<u8> = (0..32).collect();
        assert_eq!(crc32c(&up), 0x46dd_794e);
    }
}
