//! The 256 colours of an animation or a sixel image: by median cut over what its frames show.

use std::collections::BTreeMap;

/// Colours of an animation, and the nearest of them for any other.
pub struct Colors {
    entries: Vec<[u8; 3]>,
    /// Those already looked up.
    known: BTreeMap<[u8; 3], u8>,
    /// The last one: most pixels are as the one before.
    last: Option<([u8; 3], u8)>,
}

/// Colours that a GIF holds.
const MOST: usize = 256;

/// A box of colours: each with how often it occurs.
type Crate = Vec<([u8; 3], u64)>;

impl Colors {
    /// Colours for frames of these pixels, red, green and blue each.
    pub fn from_frames<'a>(frames: impl Iterator<Item = &'a [u8]>) -> Self {
        let mut counts: BTreeMap<[u8; 3], u64> = BTreeMap::new();
        for frame in frames {
            let pixels = frame.as_chunks::<3>().0;
            for same in pixels.chunk_by(|a, b| a == b) {
                *counts.entry(same[0]).or_default() += same.len() as u64;
            }
        }
        // A colour that fills the ground shall not push out those of the vehicles.
        let soft = counts.into_iter().map(|(c, n)| (c, n.isqrt() + 1));
        let mut crates: Vec<Crate> = vec![soft.collect()];
        while crates.len() < MOST {
            let widest = (0..crates.len())
                .filter(|&i| crates[i].len() > 1)
                .max_by_key(|&i| weight(&crates[i]));
            let Some(widest) = widest else { break };
            let (low, high) = cut(crates.swap_remove(widest));
            crates.extend([low, high]);
        }
        let entries = crates.iter().filter(|c| !c.is_empty()).map(mean).collect();
        Self {
            entries,
            known: BTreeMap::new(),
            last: None,
        }
    }

    /// All of them, red, green and blue each.
    pub fn table(&self) -> Vec<u8> {
        self.entries.concat()
    }

    /// The place of the nearest colour.
    pub fn place(&mut self, color: [u8; 3]) -> u8 {
        match self.last {
            Some((last, place)) if last == color => place,
            _ => {
                let place = self.find(color);
                self.last = Some((color, place));
                place
            }
        }
    }

    fn find(&mut self, color: [u8; 3]) -> u8 {
        if let Some(place) = self.known.get(&color) {
            return *place;
        }
        let off = |entry: &[u8; 3]| -> u32 {
            let pairs = entry.iter().zip(&color);
            // Eyes see green best.
            pairs
                .zip([3, 4, 2])
                .map(|((a, b), w)| w * u32::from(a.abs_diff(*b)).pow(2))
                .sum()
        };
        let places = 0..self.entries.len();
        let nearest = places.min_by_key(|&i| off(&self.entries[i])).unwrap_or(0);
        let nearest = u8::try_from(nearest).unwrap_or(u8::MAX);
        self.known.insert(color, nearest);
        nearest
    }
}

/// The channel along which colours differ most, and by how much.
fn spread(colors: &Crate) -> (usize, u8) {
    let range = |channel: usize| {
        let values = || colors.iter().map(|(c, _)| c[channel]);
        values().max().unwrap_or(0) - values().min().unwrap_or(0)
    };
    (0..3)
        .map(|channel| (channel, range(channel)))
        .max_by_key(|(_, r)| *r)
        .unwrap_or((0, 0))
}

fn weight(colors: &Crate) -> u64 {
    let count: u64 = colors.iter().map(|(_, n)| n).sum();
    count * u64::from(spread(colors).1).pow(2)
}

/// In two, so that both are shown about as often.
fn cut(mut colors: Crate) -> (Crate, Crate) {
    let (channel, _) = spread(&colors);
    colors.sort_by_key(|(c, _)| (c[channel], *c));
    let all: u64 = colors.iter().map(|(_, n)| n).sum();
    let mut sum = 0;
    let half = colors.iter().position(|(_, n)| {
        sum += n;
        2 * sum >= all
    });
    let at = half.unwrap_or(0) + 1;
    let high = colors.split_off(at.min(colors.len() - 1).max(1));
    (colors, high)
}

fn mean(colors: &Crate) -> [u8; 3] {
    let count: u64 = colors.iter().map(|(_, n)| n).sum();
    let channel = |i: usize| {
        let sum: u64 = colors.iter().map(|(c, n)| u64::from(c[i]) * n).sum();
        u8::try_from((sum + count / 2) / count.max(1)).unwrap_or(u8::MAX)
    };
    [channel(0), channel(1), channel(2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_are_kept_exactly() {
        let frame: Vec<u8> = (0..200_u8).flat_map(|i| [i, 255 - i, 7]).collect();
        let mut colors = Colors::from_frames(std::iter::once(&frame[..]));
        let table = colors.table();
        for pixel in frame.chunks_exact(3) {
            let place = usize::from(colors.place([pixel[0], pixel[1], pixel[2]]));
            assert_eq!(&table[3 * place..3 * place + 3], pixel);
        }
    }

    #[test]
    fn many_colours_become_near_ones() {
        let all = (0..64_u8).flat_map(|r| (0..64_u8).map(move |g| [4 * r, 4 * g, 128]));
        let frame: Vec<u8> = all.flatten().collect();
        let mut colors = Colors::from_frames(std::iter::once(&frame[..]));
        let table = colors.table();
        assert_eq!(table.len(), 3 * MOST);
        for pixel in frame.chunks_exact(3) {
            let place = usize::from(colors.place([pixel[0], pixel[1], pixel[2]]));
            let found = &table[3 * place..3 * place + 3];
            let off = pixel.iter().zip(found).map(|(a, b)| a.abs_diff(*b)).max();
            assert!(off <= Some(24), "{pixel:?} {found:?}");
        }
    }
}
