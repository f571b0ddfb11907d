//! Texts that many answers share, such as prompts, kept once: found by their hashes.

use std::collections::HashMap;

use sha2::{Digest, Sha256};

/// Texts of a page, each once, in the order in which they came.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Texts {
    all: Vec<String>,
    places: HashMap<[u8; 32], usize>,
}

impl Texts {
    /// The place of a text, which is added if it is new.
    pub fn place(&mut self, text: &str) -> usize {
        let next = self.all.len();
        let place = *(self.places)
            .entry(Sha256::digest(text.as_bytes()).into())
            .or_insert(next);
        if place == next {
            self.all.push(text.to_string());
        }
        place
    }

    /// All texts in blocks of about this many bytes, with the place of the first text of each.
    pub fn blocks(&self, bytes: usize) -> Vec<(usize, &[String])> {
        let mut blocks = Vec::new();
        let (mut first, mut size) = (0, 0);
        for (place, text) in self.all.iter().enumerate() {
            size += text.len();
            if size >= bytes || place + 1 == self.all.len() {
                blocks.push((first, &self.all[first..=place]));
                (first, size) = (place + 1, 0);
            }
        }
        blocks
    }
}
