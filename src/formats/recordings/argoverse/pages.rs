//! Checks the pages of a column before they are unpacked: what their headers promise is taken as room at once.
//!
//! Headers are structs of Thrift's compact protocol, as the format of Parquet describes them.

/// No page of a scenario of seconds is larger when unpacked, bytes.
const LARGEST_PAGE: i64 = 64 << 20;

/// Encodings whose values are counted in the header and not once more in the data: plain, dictionaries, runs, and
/// streams of bytes.
const ENCODINGS: [i64; 6] = [0, 2, 3, 4, 8, 9];

/// Those of them whose values are places in a dictionary; of the dictionary itself one says the same.
const BY_DICTIONARY: [i64; 2] = [2, 8];

/// Kinds of pages: data, a dictionary, and data in the second version of the format.
const DATA: i64 = 0;
const DICTIONARY: i64 = 2;
const DATA_2: i64 = 3;

/// Structs and lists in each other.
const MAX_DEPTH: usize = 16;

/// Checks the pages of a column; a page has at most `most` values.
///
/// # Errors
/// What is wrong with one of them.
pub fn check(column: &[u8], most: usize) -> Result<(), String> {
    let mut thrift = Thrift {
        bytes: column,
        at: 0,
    };
    let mut place = 0;
    let mut has_dictionary = false;
    while thrift.at < column.len() {
        place += 1;
        let damaged = || format!("the header of page {place} is damaged");
        let header = thrift.header().ok_or_else(damaged)?;
        let packed = usize::try_from(header.packed).map_err(|_| damaged())?;
        let end = thrift
            .at
            .checked_add(packed)
            .filter(|end| *end <= column.len());
        thrift.at = end.ok_or_else(|| {
            format!("page {place} has {packed} bytes, which reach beyond its column")
        })?;
        if !(0..=LARGEST_PAGE).contains(&header.unpacked) {
            let size = header.unpacked;
            let most = LARGEST_PAGE >> 20;
            return Err(format!(
                "page {place} is to have {size} bytes unpacked; at most {most} MiB are read"
            ));
        }
        if !usize::try_from(header.values).is_ok_and(|values| values <= most) {
            let values = header.values;
            return Err(format!(
                "page {place} is to have {values} values; at most {most} are read"
            ));
        }
        if !ENCODINGS.contains(&header.encoding) {
            return Err(format!(
                "page {place} has encoding {}; plain values and dictionaries are read",
                header.encoding
            ));
        }
        // Others are taken for what they are not.
        match (header.kind, header.of) {
            (DICTIONARY, 7) if place == 1 => has_dictionary = true,
            (DATA, 5) | (DATA_2, 8) => {}
            _ => return Err(format!("page {place} is no page of data")),
        }
        if BY_DICTIONARY.contains(&header.encoding) && !has_dictionary {
            return Err(format!(
                "page {place} needs a dictionary, and there is none"
            ));
        }
    }
    Ok(())
}

/// What the header of a page says.
#[derive(Default)]
struct Header {
    kind: i64,
    /// The field with what there is to say about its kind.
    of: i64,
    unpacked: i64,
    packed: i64,
    values: i64,
    encoding: i64,
}

/// Structs of the compact protocol, one after the other.
struct Thrift<'b> {
    bytes: &'b [u8],
    at: usize,
}

impl Thrift<'_> {
    fn header(&mut self) -> Option<Header> {
        let mut header = Header::default();
        self.fields(0, &mut |path, value| match path {
            (0, 1) => header.kind = value,
            (0, 2) => header.unpacked = value,
            (0, 3) => header.packed = value,
            // Pages of data, of the dictionary, and of data in the second version.
            (of @ (5 | 7 | 8), 1) => (header.of, header.values) = (of, value),
            (5 | 7, 2) | (8, 4) => header.encoding = value,
            _ => {}
        })?;
        Some(header)
    }

    /// Goes through a struct and gives its numbers, and those of the structs in it, each with the field of the outer
    /// struct (0 in the outermost) and its own.
    fn fields(&mut self, outer: i64, take: &mut dyn FnMut((i64, i64), i64)) -> Option<()> {
        let mut id = 0;
        loop {
            let byte = self.byte()?;
            if byte == 0 {
                return Some(());
            }
            id = match byte >> 4 {
                0 => self.number()?,
                more => id + i64::from(more),
            };
            match byte & 0xf {
                4..=6 => take((outer, id), self.number()?),
                12 if outer == 0 => self.fields(id, take)?,
                kind => self.skip(kind, MAX_DEPTH)?,
            }
        }
    }

    fn skip(&mut self, kind: u8, deeper: usize) -> Option<()> {
        let deeper = deeper.checked_sub(1)?;
        match kind {
            // The value of a boolean is its type.
            1 | 2 => Some(()),
            3 => self.pass(1),
            4..=6 => self.varint().map(|_| ()),
            7 => self.pass(8),
            8 => {
                let length = usize::try_from(self.varint()?).ok()?;
                self.pass(length)
            }
            9 | 10 => {
                let byte = self.byte()?;
                let count = match byte >> 4 {
                    15 => self.varint()?,
                    few => u64::from(few),
                };
                for _ in 0..count {
                    match byte & 0xf {
                        1 | 2 => self.pass(1)?,
                        kind => self.skip(kind, deeper)?,
                    }
                }
                Some(())
            }
            12 => loop {
                let byte = self.byte()?;
                if byte == 0 {
                    return Some(());
                }
                if byte >> 4 == 0 {
                    self.varint()?;
                }
                self.skip(byte & 0xf, deeper)?;
            },
            // Headers have no maps.
            _ => None,
        }
    }

    fn pass(&mut self, bytes: usize) -> Option<()> {
        let end = self.at.checked_add(bytes)?;
        self.at = (end <= self.bytes.len()).then_some(end)?;
        Some(())
    }

    fn byte(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.at)?;
        self.at += 1;
        Some(byte)
    }

    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    /// Signs are in the lowest bit.
    fn number(&mut self) -> Option<i64> {
        let value = self.varint()?;
        Some((value >> 1) as i64 ^ -((value & 1) as i64))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A page of data: its header and so many bytes.
    fn page(unpacked: &[u8], values: u8, encoding: u8, bytes: usize) -> Vec<u8> {
        let mut page = vec![0x15, 0x00, 0x15];
        page.extend(unpacked);
        page.extend([0x15, bytes as u8 * 2, 0x2c, 0x15, values, 0x15, encoding]);
        // Levels, statistics with a text, and the ends of both structs.
        page.extend([
            0x15, 0x06, 0x15, 0x06, 0x1c, 0x18, 0x02, b'a', b'b', 0x00, 0x00, 0x00,
        ]);
        page.extend(std::iter::repeat_n(7, bytes));
        page
    }

    #[test]
    fn pages_promise_what_can_be_kept() {
        let good = page(&[40], 20, 0, 16);
        assert_eq!(check(&[good.clone(), good.clone()].concat(), 10), Ok(()));
        let error = |column: &[u8], most| check(column, most).unwrap_err();
        // i32::MAX.
        let large = page(&[0xfe, 0xff, 0xff, 0xff, 0x0f], 20, 0, 16);
        let said = error(&[good.clone(), large].concat(), 10);
        assert!(
            said.contains("page 2 is to have 2147483647 bytes"),
            "{said}"
        );
        assert!(error(&good, 9).contains("10 values; at most 9"));
        assert!(error(&page(&[40], 20, 10, 16), 10).contains("encoding 5"));
        assert!(error(&good[..30], 10).contains("reach beyond"));
        assert!(error(&good[..9], 10).contains("is damaged"));
        // Values by a dictionary come after it.
        assert!(error(&page(&[40], 20, 16, 16), 10).contains("page 1 needs a dictionary"));
        let dictionary = [
            &[0x15, 4, 0x15, 8, 0x15, 8, 0x4c, 0x15, 4, 0x15, 0, 0, 0][..],
            &[7; 4],
        ]
        .concat();
        let both = [dictionary.clone(), page(&[40], 20, 16, 16)].concat();
        assert_eq!(check(&both, 10), Ok(()));
        assert!(
            error(&[good.clone(), dictionary].concat(), 10).contains("page 2 is no page of data")
        );
        // Lists in lists.
        let deep: Vec<u8> = [0x19].into_iter().chain([0x19; 100]).collect();
        assert!(error(&deep, 10).contains("is damaged"));
    }
}
