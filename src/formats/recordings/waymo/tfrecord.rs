//! TFRecord files: one record after the other, each with its length and the checksums of both.

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

use super::crc32c::masked;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::report::Report;
use nearmiss_base::system;

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
            _ => system::words(error),
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
