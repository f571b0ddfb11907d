//! Images of questions, each kept once under the hash of its bytes.

use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rusqlite::{Connection, OptionalExtension, params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::record::RecordError;
use super::{NewRun, Store, StoreError};
use nearmiss_record::Record;

/// The form of their lines in exports.
pub(super) const FORM: u32 = 1;

/// An image that a question shows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct StoredImage {
    /// SHA-256 of its bytes, hexadecimal, by which messages name it.
    pub sha256: String,
    /// Media type, such as image/png.
    pub media_type: String,
    /// Pixels from left to right.
    pub width: u32,
    /// Pixels from top to bottom.
    pub height: u32,
    /// Its bytes in base64.
    #[serde(rename = "base64", with = "base64_bytes")]
    #[schemars(with = "String")]
    pub bytes: Arc<[u8]>,
}

/// Bytes as text.
mod base64_bytes {
    use super::{Arc, Deserialize, Engine, STANDARD};
    use serde::{Deserializer, Serializer, de::Error};

    pub fn serialize<S: Serializer>(bytes: &Arc<[u8]>, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&STANDARD.encode(bytes))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Arc<[u8]>, D::Error> {
        let text = String::deserialize(from)?;
        let bytes = STANDARD.decode(&text);
        bytes.map(Into::into).map_err(Error::custom)
    }
}

/// An image as it is exported.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ImageRecord<'i> {
    /// Marks an image, with the version of its format.
    nearmiss_image: u32,
    /// The image.
    #[serde(flatten)]
    image: &'i StoredImage,
}

impl Record for ImageRecord<'_> {
    const NAME: &'static str = "image";
    const TITLE: &'static str = "`runs export`: one image that questions show";
}

impl StoredImage {
    /// The image as it is exported.
    #[must_use]
    pub fn to_record(&self) -> ImageRecord<'_> {
        ImageRecord {
            nearmiss_image: FORM,
            image: self,
        }
    }

    /// Reads a line that [`StoredImage::to_record`] wrote.
    pub(super) fn from_record(line: &str) -> Result<Self, RecordError> {
        let image: Self = serde_json::from_str(line)?;
        let digest = Sha256::digest(&image.bytes);
        let sha256: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        if sha256 == image.sha256 {
            Ok(image)
        } else {
            Err(RecordError::Image)
        }
    }
}

impl NewRun {
    /// The hashes of the images in its messages, in their order.
    #[must_use]
    pub fn image_hashes(&self) -> Vec<String> {
        if !self.messages.contains("\"images\"") {
            return Vec::new();
        }
        let messages: Value = serde_json::from_str(&self.messages).unwrap_or_default();
        let messages = messages.as_array().into_iter().flatten();
        let images = messages.filter_map(|message| message.get("images")?.as_array());
        let hash = |image: &Value| Some(image.get("sha256")?.as_str()?.to_string());
        images.flatten().filter_map(hash).collect()
    }
}

impl Store {
    /// The image with this hash; `None` if the store does not have it.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn image(&self, sha256: &str) -> Result<Option<StoredImage>, StoreError> {
        let connection = self.lock();
        let sql = "SELECT media_type, width, height, bytes FROM images WHERE sha256 = ?1";
        let found = connection.prepare_cached(sql)?.query_row([sha256], |row| {
            let bytes: Vec<u8> = row.get(3)?;
            Ok(StoredImage {
                sha256: sha256.to_string(),
                media_type: row.get(0)?,
                width: row.get(1)?,
                height: row.get(2)?,
                bytes: bytes.into(),
            })
        });
        Ok(found.optional()?)
    }

    /// Keeps an image; one that is there stays as it is.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn keep_image(&self, image: &StoredImage) -> Result<(), StoreError> {
        self.durably(|transaction| keep(transaction, image))
    }

    /// The hashes of all images.
    pub(super) fn image_hashes(&self) -> Result<Vec<String>, StoreError> {
        let sql = "SELECT sha256 FROM images ORDER BY sha256";
        self.rows(sql, [], |row| row.get(0))
    }
}

/// Keeps an image in a transaction.
pub(super) fn keep(connection: &Connection, image: &StoredImage) -> Result<(), StoreError> {
    let sql = "INSERT OR IGNORE INTO images (sha256, media_type, width, height, bytes) VALUES (?1, ?2, ?3, ?4, ?5)";
    connection.prepare_cached(sql)?.execute(params![
        image.sha256,
        image.media_type,
        image.width,
        image.height,
        &image.bytes[..],
    ])?;
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::tests::question;
    use super::super::{Claim, Record, RecordIntake};
    use super::{NewRun, RecordError, Store, StoredImage};
    use serde_json::json;

    fn image() -> StoredImage {
        StoredImage {
            sha256: "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad".into(),
            media_type: "image/png".into(),
            width: 2,
            height: 1,
            bytes: b"abc".to_vec().into(),
        }
    }

    fn with_image() -> NewRun {
        let messages =
            json!([{"role": "user", "content": "?", "images": [{"sha256": image().sha256}]}]);
        NewRun {
            messages: messages.to_string(),
            images: vec![image()],
            ..question()
        }
    }

    #[test]
    fn an_image_is_kept_once_with_the_runs_that_show_it() {
        let store = Store::in_memory().unwrap();
        for _ in 0..2 {
            let Claim::Granted(id) = store.claim(&with_image(), true).unwrap() else {
                panic!("it is asked afresh");
            };
            let run = store.run(id).unwrap().unwrap();
            assert_eq!(run.question.image_hashes(), [image().sha256]);
        }
        assert_eq!(store.image(&image().sha256).unwrap(), Some(image()));
        assert_eq!(store.image_hashes().unwrap().len(), 1);
        assert_eq!(question().image_hashes(), [""; 0]);
    }

    #[test]
    fn the_key_of_a_request_knows_the_image() {
        let other = NewRun {
            messages: with_image().messages.replace("ba78", "ba79"),
            ..with_image()
        };
        assert_ne!(with_image().key(), other.key());
    }

    #[test]
    fn lines_and_merges_carry_it_and_damage_is_found() {
        let line = nearmiss_record::json_line(&image().to_record()).unwrap();
        let Record::Image(read) = Record::from_line(&line).unwrap() else {
            panic!("it is an image");
        };
        assert_eq!(*read, image());
        let damaged = line.replace("YWJj", "YWJk");
        assert!(Record::from_line(&damaged).is_err());
        let newer = line.replace("\"nearmiss_image\":1", "\"nearmiss_image\":2");
        assert!(matches!(
            Record::from_line(&newer),
            Err(RecordError::Newer(2, 1))
        ));

        let (here, there) = (Store::in_memory().unwrap(), Store::in_memory().unwrap());
        let mut intake = RecordIntake::new(&there);
        intake.take(Record::Image(read), line.len()).unwrap();
        intake.finish().unwrap();
        here.merge(&there).unwrap();
        assert_eq!(here.image(&image().sha256).unwrap(), Some(image()));
    }
}
