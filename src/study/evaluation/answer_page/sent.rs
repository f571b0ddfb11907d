//! Pictures that models were sent, each once on a page, as addresses that hold them.

use std::collections::HashMap;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::Serialize;

use nearmiss_store::StoredImage;

/// All of them together have at most so many bytes as they stand on the page; one with more opens slowly.
const MOST: usize = 64 << 20;

/// Media types that a page shows: none of them can hold anything that runs.
const SHOWN: [&str; 4] = ["image/png", "image/jpeg", "image/webp", "image/gif"];

/// Where a picture that a question was sent with stands, or why it does not.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub(super) enum Sent {
    /// Its place among the pictures of the page, and its size in pixels.
    Shown { picture: usize, size: (u32, u32) },
    /// In words.
    Missing { missing: String },
}

/// The pictures of a page.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct SentPictures {
    /// `data:image/png;base64,…`
    pub(super) all: Vec<String>,
    known: HashMap<String, Sent>,
    bytes: usize,
    /// How many did not fit.
    pub(super) left_out: usize,
}

impl SentPictures {
    /// The picture with this hash, if it was looked for before.
    pub(super) fn known(&self, sha256: &str) -> Option<&Sent> {
        self.known.get(sha256)
    }

    /// Takes what was found under a hash.
    pub(super) fn take(&mut self, sha256: &str, found: Option<&StoredImage>) -> Sent {
        let short: String = sha256.chars().take(12).collect();
        let missing = |missing| Sent::Missing { missing };
        let sent = match found {
            None => missing(format!(
                "The store does not have the picture {short}…; import the export or bundle again that has it."
            )),
            Some(picture) if !SHOWN.contains(&picture.media_type.as_str()) => {
                missing(format!("The picture {short}… is of a type that pages do not show."))
            }
            Some(picture) => self.add(picture).unwrap_or_else(|| {
                self.left_out += 1;
                missing(format!(
                    "The page would become too large with the picture {short}…; \"nearmiss runs show\" writes it."
                ))
            }),
        };
        self.known.insert(sha256.to_string(), sent.clone());
        sent
    }

    fn add(&mut self, picture: &StoredImage) -> Option<Sent> {
        let bytes = self.bytes + picture.bytes.len().div_ceil(3) * 4;
        if bytes > MOST {
            return None;
        }
        self.bytes = bytes;
        let base64 = BASE64_STANDARD.encode(&picture.bytes);
        self.all
            .push(format!("data:{};base64,{base64}", picture.media_type));
        let size = (picture.width, picture.height);
        Some(Sent::Shown {
            picture: self.all.len() - 1,
            size,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(bytes: usize) -> StoredImage {
        StoredImage {
            sha256: "ab".into(),
            media_type: "image/png".into(),
            width: 3,
            height: 2,
            bytes: vec![0; bytes].into(),
        }
    }

    fn shown(picture: usize) -> Sent {
        let size = (3, 2);
        Sent::Shown { picture, size }
    }

    #[test]
    fn what_does_not_fit_is_counted_and_smaller_ones_still_fit() {
        let mut all = SentPictures::default();
        let large = picture(MOST / 2);
        assert_eq!(all.take("a", Some(&large)), shown(0));
        let Sent::Missing { missing: why } = all.take("b", Some(&large)) else {
            panic!("it does not fit");
        };
        assert!(why.contains("too large"), "{why}");
        assert_eq!(all.take("c", Some(&picture(1))), shown(1));
        assert_eq!((all.left_out, all.all.len()), (1, 2));
        assert_eq!(all.all[1], "data:image/png;base64,AA==");
        assert_eq!(all.known("a"), Some(&shown(0)));
    }

    #[test]
    fn what_is_not_there_or_no_picture_is_said() {
        let mut all = SentPictures::default();
        let odd = StoredImage {
            media_type: "image/svg+xml".into(),
            ..picture(1)
        };
        for (found, words) in [(None, "does not have"), (Some(&odd), "do not show")] {
            let Sent::Missing { missing: why } = all.take("0123456789abcdef", found) else {
                panic!("nothing is shown");
            };
            assert!(
                why.contains(words) && why.contains("0123456789ab…"),
                "{why}"
            );
        }
        assert!(all.all.is_empty() && all.left_out == 0);
    }
}
