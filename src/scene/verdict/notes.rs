//! Describes the repairs made while parsing an answer.

use super::ParseQuality;
use super::lenient::{End, JsonPiece};

/// Notes, each once; a hostile answer does not make them endless.
#[derive(Debug, Default)]
pub(super) struct Notes {
    notes: Vec<String>,
    more: usize,
}

const MOST: usize = 20;
const LONGEST: usize = 160;

impl Notes {
    pub(super) fn add(&mut self, note: impl Into<String>) {
        // The store keeps them in one line, apart by semicolons.
        let mut note = note.into().replace(';', ",").replace(['\n', '\r'], " ");
        if let Some((end, _)) = note.char_indices().nth(LONGEST) {
            note.truncate(end);
            note.push('…');
        }
        if self.notes.contains(&note) {
        } else if self.notes.len() < MOST {
            self.notes.push(note);
        } else {
            self.more += 1;
        }
    }

    /// How the text of a piece departed from JSON.
    pub(super) fn note_repairs(&mut self, piece: &JsonPiece) {
        for repair in &piece.repairs {
            self.add(repair.to_string());
        }
        match piece.end {
            End::Whole => {}
            End::CutOff => {
                self.add("the answer breaks off inside its JSON; the part before was read")
            }
            End::Broken => self.add("the JSON is broken; the part before was read"),
        }
    }

    pub(super) fn how(mut self) -> ParseQuality {
        if self.more > 0 {
            self.notes.push(format!("and {} more", self.more));
        }
        if self.notes.is_empty() {
            ParseQuality::Strict
        } else {
            ParseQuality::Repaired(self.notes)
        }
    }
}
