//! Messages one after the other in a file: MCAP with its chunks, and traces of OSI, each message behind its length.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

use nearmiss_base::system;

/// How MCAP begins and ends.
pub const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// No record or message is larger, bytes.
const LARGEST: u64 = 1 << 30;

/// What a message is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Schema {
    /// `osi3.GroundTruth`.
    GroundTruth,
    /// `osi3.SensorView`, with a ground truth in it.
    SensorView,
    /// `osi3.MapAsamOpenDrive`, an extension by omega-prime.
    Map,
}

impl Schema {
    fn of_name(name: &str) -> Option<Self> {
        match name.rsplit('.').next() {
            Some("GroundTruth") => Some(Self::GroundTruth),
            Some("SensorView") => Some(Self::SensorView),
            Some("MapAsamOpenDrive" | "MapASAMOpenDRIVE") => Some(Self::Map),
            _ => None,
        }
    }
}

/// Whether messages go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// The next one is wanted.
    More,
    /// No other one is.
    Enough,
}

/// What takes messages.
type Take<'t> = &'t mut dyn FnMut(Schema, &[u8]) -> Result<Next, String>;

/// Gives the messages of a trace to `take`; each is behind its length, four bytes with the lowest first.
///
/// # Errors
/// The file is cut or damaged, or what `take` says.
pub fn trace(path: &Path, schema: Schema, take: Take<'_>) -> Result<(), String> {
    let mut file = open(path)?;
    let mut bytes = Vec::new();
    for number in 1.. {
        let Some(length) = exact_or_end::<4>(&mut file)? else {
            return Ok(());
        };
        let length = u64::from(u32::from_le_bytes(length));
        fill(&mut file, length, &mut bytes)
            .map_err(|error| format!("message {number}: {error}; is the file truncated?"))?;
        if take(schema, &bytes).map_err(|error| format!("message {number}: {error}"))?
            == Next::Enough
        {
            return Ok(());
        }
    }
    Ok(())
}

/// Gives the messages of an MCAP file whose schemas are known to `take`, in the order of the file.
///
/// # Errors
/// The file is cut or damaged, or what `take` says.
pub fn mcap(path: &Path, take: Take<'_>) -> Result<(), String> {
    let mut file = begun(path)?;
    Known::default()
        .records(&mut file, Within::File, take)
        .map(drop)
}

/// Whether an MCAP file has ground truth: as its summary says, else by its first chunk.
///
/// # Errors
/// The file is cut or damaged.
pub fn has_ground_truth(path: &Path) -> Result<bool, String> {
    let mut file = begun(path)?;
    let summary = summary(&mut file)?;
    let mut known = Known {
        is_glance: true,
        ..Known::default()
    };
    let mut glance = |known: &mut Known, start: u64| {
        file.seek(SeekFrom::Start(start)).map_err(cut)?;
        known.records(&mut file, Within::File, &mut |_, _| Ok(Next::Enough))
    };
    if let Some(start) = summary {
        glance(&mut known, start)?;
    }
    // Some writers say nothing of schemas there.
    if known.schemas.is_empty() {
        glance(&mut known, MAGIC.len() as u64)?;
    }
    let mut all = known.schemas.into_values().flatten();
    Ok(all.any(|schema| schema != Schema::Map))
}

/// Where the summary begins, if the file has one; back behind the magic.
fn summary(file: &mut BufReader<File>) -> Result<Option<u64>, String> {
    // A footer with two places and a checksum, and the magic.
    const END: i64 = 1 + 8 + 8 + 8 + 4 + 8;
    if file.seek(SeekFrom::End(-END)).is_err() {
        return Ok(None);
    }
    let end = exact_or_end::<{ END as usize }>(file)?.unwrap_or([0; END as usize]);
    file.seek(SeekFrom::Start(MAGIC.len() as u64))
        .map_err(cut)?;
    if end[0] != FOOTER || !end.ends_with(MAGIC) {
        return Ok(None);
    }
    let start = Cursor(&end[9..]).u64();
    Ok(start.filter(|start| *start > 0))
}

fn begun(path: &Path) -> Result<BufReader<File>, String> {
    let mut file = open(path)?;
    match exact_or_end::<8>(&mut file)? {
        Some(magic) if magic == MAGIC => Ok(file),
        _ => Err("not an MCAP file".into()),
    }
}

fn open(path: &Path) -> Result<BufReader<File>, String> {
    let file = system::open_file(path).map_err(|error| system::error_text(&error))?;
    Ok(BufReader::with_capacity(1 << 18, file))
}

/// So many bytes; nothing at the end.
fn exact_or_end<const N: usize>(from: &mut impl Read) -> Result<Option<[u8; N]>, String> {
    let mut bytes = [0; N];
    match from.read_exact(&mut bytes[..1]) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(None),
        other => other.map_err(|error| system::error_text(&error))?,
    }
    from.read_exact(&mut bytes[1..]).map_err(cut)?;
    Ok(Some(bytes))
}

/// Replaces `into` by so many bytes.
fn fill(from: &mut impl Read, length: u64, into: &mut Vec<u8>) -> Result<(), String> {
    if length > LARGEST {
        return Err(format!("{length} bytes are more than it can have"));
    }
    into.clear();
    // Memory grows with what is there, whatever a damaged length says.
    let read = from.take(length).read_to_end(into).map_err(cut)?;
    if (read as u64) < length {
        return Err(format!("{length} bytes, of which {read} are there"));
    }
    Ok(())
}

fn cut(error: std::io::Error) -> String {
    match error.kind() {
        ErrorKind::UnexpectedEof => "the file ends within a record; is it truncated?".into(),
        _ => system::error_text(&error),
    }
}

// Kinds of records, as the specification numbers them.
const FOOTER: u8 = 0x02;
const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;
const MESSAGE: u8 = 0x05;
const CHUNK: u8 = 0x06;
const DATA_END: u8 = 0x0f;

/// Where records are: chunks have no chunks in them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Within {
    File,
    Chunk,
}

/// Schemas and channels that were met.
#[derive(Default)]
struct Known {
    /// Whether the first chunk is enough.
    is_glance: bool,
    schemas: HashMap<u16, Option<Schema>>,
    channels: HashMap<u16, Option<Schema>>,
}

impl Known {
    fn records(
        &mut self,
        mut from: &mut dyn Read,
        within: Within,
        take: Take<'_>,
    ) -> Result<Next, String> {
        let mut bytes = Vec::new();
        loop {
            let Some([kind]) = exact_or_end::<1>(&mut from)? else {
                return Ok(Next::More);
            };
            let length = exact_or_end::<8>(&mut from)?
                .ok_or("the file ends within a record; is it truncated?")?;
            fill(&mut from, u64::from_le_bytes(length), &mut bytes)
                .map_err(|error| format!("a record of {error}; is the file truncated?"))?;
            let damaged = || format!("a record of kind {kind} is damaged");
            match kind {
                SCHEMA => self.schema(&bytes).ok_or_else(damaged)?,
                CHANNEL => self.channel(&bytes).ok_or_else(damaged)?,
                MESSAGE => {
                    let mut fields = Cursor(&bytes);
                    let channel = fields.u16().ok_or_else(damaged)?;
                    // Its number, and when it was logged and published.
                    let message = fields.after(4 + 8 + 8).ok_or_else(damaged)?;
                    if let Some(Some(schema)) = self.channels.get(&channel)
                        && take(*schema, message)? == Next::Enough
                    {
                        return Ok(Next::Enough);
                    }
                }
                CHUNK if within == Within::Chunk => return Err("a chunk within a chunk".into()),
                CHUNK => {
                    let (compression, packed) = chunk(&bytes).ok_or_else(damaged)?;
                    let mut unpacked: Box<dyn Read> = match compression {
                        "" => Box::new(packed),
                        "zstd" => Box::new(
                            zstd::Decoder::new(packed)
                                .map_err(|error| system::error_text(&error))?,
                        ),
                        "lz4" => Box::new(lz4_flex::frame::FrameDecoder::new(packed)),
                        other => {
                            return Err(format!(
                                "chunks are compressed with `{other}`; zstd and lz4 are read"
                            ));
                        }
                    };
                    let next = self.records(&mut unpacked, Within::Chunk, take)?;
                    if next == Next::Enough || self.is_glance {
                        return Ok(Next::Enough);
                    }
                }
                DATA_END | FOOTER => return Ok(Next::More),
                _ => {}
            }
        }
    }

    fn schema(&mut self, record: &[u8]) -> Option<()> {
        let mut fields = Cursor(record);
        let id = fields.u16()?;
        self.schemas.insert(id, Schema::of_name(fields.text()?));
        Some(())
    }

    fn channel(&mut self, record: &[u8]) -> Option<()> {
        let mut fields = Cursor(record);
        let (id, schema) = (fields.u16()?, fields.u16()?);
        let (_, encoding) = (fields.text()?, fields.text()?);
        let schema = self.schemas.get(&schema).copied().flatten();
        let is_read = encoding == "protobuf";
        self.channels.insert(id, schema.filter(|_| is_read));
        Some(())
    }
}

/// How a chunk is compressed, and its bytes.
fn chunk(record: &[u8]) -> Option<(&str, &[u8])> {
    // When it begins and ends, its size and checksum.
    let mut fields = Cursor(Cursor(record).after(8 + 8 + 8 + 4)?);
    let compression = fields.text()?;
    let length = fields.u64()?;
    let packed = fields.0.get(..usize::try_from(length).ok()?)?;
    Some((compression, packed))
}

/// The fields of a record; numbers have their lowest byte first.
struct Cursor<'a>(&'a [u8]);

impl<'a> Cursor<'a> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (bytes, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*bytes)
    }

    fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Option<&'a str> {
        let length = u32::from_le_bytes(self.take()?) as usize;
        let (text, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        std::str::from_utf8(text).ok()
    }

    /// What follows so many bytes.
    fn after(&self, count: usize) -> Option<&'a [u8]> {
        self.0.get(count..)
    }
}
