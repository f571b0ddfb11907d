//! A small protobuf encoder, independent of the one that reads: numbers of fields stand here a second time.

/// A message being written.
#[derive(Debug, Clone, Default)]
pub struct Bytes(pub Vec<u8>);

/// An empty message.
pub fn message() -> Bytes {
    Bytes::default()
}

impl Bytes {
    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
    }

    /// A whole number, a truth value or a value of an enumeration.
    pub fn whole(mut self, number: u32, value: i64) -> Self {
        self.varint(u64::from(number) << 3);
        self.varint(value as u64);
        self
    }

    pub fn double(mut self, number: u32, value: f64) -> Self {
        self.varint(u64::from(number) << 3 | 1);
        self.0.extend(value.to_le_bytes());
        self
    }

    fn bytes(mut self, number: u32, value: &[u8]) -> Self {
        self.varint(u64::from(number) << 3 | 2);
        self.varint(value.len() as u64);
        self.0.extend(value);
        self
    }

    pub fn text(self, number: u32, value: &str) -> Self {
        self.bytes(number, value.as_bytes())
    }

    pub fn inner(self, number: u32, value: Bytes) -> Self {
        self.bytes(number, &value.0)
    }

    /// `next` for each of the items in turn.
    pub fn each<T>(
        self,
        items: impl IntoIterator<Item = T>,
        next: impl FnMut(Self, T) -> Self,
    ) -> Self {
        items.into_iter().fold(self, next)
    }

    pub fn wholes(self, number: u32, values: &[i64]) -> Self {
        self.each(values, |out, value| out.whole(number, *value))
    }
}

/// x and y.
pub fn point(x: f64, y: f64) -> Bytes {
    message().double(1, x).double(2, y)
}
