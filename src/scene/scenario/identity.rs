//! What a scenario is known by: the hash of its file, and the benchmark id as the reference reader normalises it.

use std::borrow::Cow;
use std::fmt;

use sha2::{Digest, Sha256};

/// The SHA-256 of some contents; prints as 64 hexadecimal digits.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ContentHash([u8; 32]);

impl ContentHash {
    /// The hash of `bytes`.
    #[must_use]
    pub fn digest(bytes: &[u8]) -> Self {
        Self(Sha256::digest(bytes).into())
    }

    /// Its bytes.
    #[must_use]
    pub fn bytes(&self) -> [u8; 32] {
        self.0
    }

    /// The hash of parts one after the other.
    #[must_use]
    pub fn of_parts<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> Self {
        let mut hasher = Sha256::new();
        parts.into_iter().for_each(|part| hasher.update(part));
        Self(hasher.finalize().into())
    }
}

/// Contents that many begin with: hashed once, and gone on from.
#[derive(Debug, Clone)]
pub struct HashedBeginning(Sha256);

impl HashedBeginning {
    /// What they begin with.
    #[must_use]
    pub fn new(bytes: &[u8]) -> Self {
        let mut hasher = Sha256::new();
        hasher.update(bytes);
        Self(hasher)
    }

    /// The same of what is too large for memory.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn read(source: &mut dyn std::io::Read) -> std::io::Result<Self> {
        let mut hasher = Sha256::new();
        let mut block = vec![0; 1 << 18];
        loop {
            match source.read(&mut block) {
                Ok(0) => return Ok(Self(hasher)),
                Ok(count) => hasher.update(&block[..count]),
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// The hash of the beginning with these parts after it.
    #[must_use]
    pub fn with<'a>(&self, parts: impl IntoIterator<Item = &'a [u8]>) -> ContentHash {
        let mut hasher = self.0.clone();
        parts.into_iter().for_each(|part| hasher.update(part));
        ContentHash(hasher.finalize().into())
    }
}

impl fmt::Display for ContentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for ContentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// Whether `id` follows `(C-)?COUNTRY_Map-1(_1(_[STPI](-1)+)?)?`, with numbers from 1.
#[must_use]
pub fn is_valid(id: &str) -> bool {
    let rest = id.strip_prefix("C-").unwrap_or(id);
    let mut parts = rest.split('_');
    let country = parts
        .next()
        .is_some_and(|c| c.len() == 3 && c.bytes().all(|b| b.is_ascii_uppercase()));
    let map = parts
        .next()
        .and_then(|m| m.split_once('-'))
        .is_some_and(|(name, number)| {
            !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric()) && is_number(number)
        });
    let configuration = parts.next().is_none_or(is_number);
    let prediction = parts.next().is_none_or(|p| {
        let mut pieces = p.split('-');
        let kind = pieces
            .next()
            .is_some_and(|k| matches!(k, "S" | "T" | "P" | "I"));
        let numbers: Vec<&str> = pieces.collect();
        kind && !numbers.is_empty() && numbers.into_iter().all(is_number)
    });
    country && map && configuration && prediction && parts.next().is_none()
}

/// The scenarios on the same map, often cut from the same recordings: `DEU_Bremen-7` of `DEU_Bremen-7_12_T-1`. Windows
/// of one long recording, `01_tracks-track-12-34.0s`, show the same traffic and are a family, too; any other name is a
/// family of its own.
#[must_use]
pub fn family(id: &str) -> &str {
    let rest = id.strip_prefix("C-").unwrap_or(id);
    let end = rest
        .match_indices('_')
        .nth(1)
        .map_or(rest.len(), |(at, _)| at);
    if is_valid(&rest[..end]) {
        &rest[..end]
    } else {
        id.rsplit_once("-track-")
            .map_or(id, |(recording, _)| recording)
    }
}

fn is_number(text: &str) -> bool {
    !text.starts_with('0') && !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

/// The id as the reference reader prints it: an invalid one becomes the name of a map in Zamunda.
#[must_use]
pub fn normalized(id: &str) -> Cow<'_, str> {
    if is_valid(id) {
        return Cow::Borrowed(id);
    }
    let letters: String = id.chars().filter(char::is_ascii_alphanumeric).collect();
    Cow::Owned(format!("ZAM_{letters}-1"))
}

/// The id of the `number`th (from 1) other traffic on the same map from the same initial configuration: the last number
/// of the prediction is that much higher, `DEU_Bremen-1_10_T-2` the first after `DEU_Bremen-1_10_T-1`.
///
/// It names trajectories (`T`), whatever `id` names. An id without a configuration or a prediction counts as the first
/// configuration without one; one that breaks the rule is normalised first.
#[must_use]
pub fn other_traffic(id: &str, number: u32) -> String {
    let id = normalized(id);
    let mut parts = id.split('_');
    let (country, map) = (
        parts.next().unwrap_or_default(),
        parts.next().unwrap_or_default(),
    );
    let configuration = parts.next().unwrap_or("1");
    let prediction = parts.next().unwrap_or("T-0");
    // The letter, and the numbers before the last one.
    let (before, last) = prediction.rsplit_once('-').unwrap_or(("T", "0"));
    let before = before.split_once('-').map(|(_, numbers)| numbers);
    // Numbers of any length are valid; one too long to count gets a second number appended.
    let (before, last) = match last.parse::<u64>() {
        Ok(last) => (before.map(str::to_string), last),
        Err(_) => {
            let all = before.map_or(last.to_string(), |b| format!("{b}-{last}"));
            (Some(all), 0)
        }
    };
    let next = last.saturating_add(u64::from(number.max(1)));
    let numbers = before.map_or(next.to_string(), |before| format!("{before}-{next}"));
    format!("{country}_{map}_{configuration}_T-{numbers}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prints_the_known_hash_of_nothing() {
        let text = ContentHash::digest(b"").to_string();
        assert!(text.starts_with("e3b0c44298fc1c14") && text.len() == 64);
    }

    #[test]
    fn parts_have_the_hash_of_the_whole() {
        let parts: [&[u8]; 3] = [b"ma", b"", b"p"];
        assert_eq!(ContentHash::of_parts(parts), ContentHash::digest(b"map"));
        let beginning = HashedBeginning::new(b"ma");
        let [_, rest @ ..] = parts;
        assert_eq!(beginning.with(rest), ContentHash::digest(b"map"));
        assert_eq!(beginning.with([]), ContentHash::digest(b"ma"));
    }

    #[test]
    fn the_rule() {
        for id in [
            "DEU_Bremen-1_10_T-1",
            "C-USA_US101-33_2_S-1-2",
            "ZAM_Tutorial-1",
            "ZAM_A1-2_3",
        ] {
            assert!(is_valid(id), "{id}");
            assert_eq!(normalized(id), id);
        }
        for id in [
            "",
            "ZAM_test_0-1",
            "DEU_A-0_1_T-1",
            "DE_A-1",
            "DEU_A-1_1_X-1",
            "DEU_A-1_1_T",
            "DEU_A-1_1_T-1_2",
        ] {
            assert!(!is_valid(id), "{id}");
        }
        assert_eq!(normalized("ZAM_test_0-1"), "ZAM_ZAMtest01-1");
    }

    #[test]
    fn a_family_is_a_map() {
        for (id, wanted) in [
            ("DEU_Bremen-7_12_T-1", "DEU_Bremen-7"),
            ("C-DEU_Bremen-7_12_T-1", "DEU_Bremen-7"),
            ("DEU_Bremen-7_12_T-1-copy", "DEU_Bremen-7"),
            ("ZAM_Tutorial-1", "ZAM_Tutorial-1"),
            ("my_own_file", "my_own_file"),
            ("01_tracks-track-12-34.0s", "01_tracks"),
            ("01_tracks-track-9", "01_tracks"),
            ("", ""),
        ] {
            assert_eq!(family(id), wanted);
        }
    }

    #[test]
    fn other_traffic_is_counted_on() {
        for (id, number, next) in [
            ("DEU_Bremen-1_10_T-1", 1, "DEU_Bremen-1_10_T-2"),
            ("DEU_Bremen-1_10_T-1", 4, "DEU_Bremen-1_10_T-5"),
            ("C-USA_US101-33_2_S-1-2", 1, "C-USA_US101-33_2_T-1-3"),
            ("ZAM_Tutorial-1", 1, "ZAM_Tutorial-1_1_T-1"),
            ("ZAM_A1-2_3", 2, "ZAM_A1-2_3_T-2"),
            ("ZAM_test_0-1", 1, "ZAM_ZAMtest01-1_1_T-1"),
            (
                "ZAM_A-1_1_T-99999999999999999999999",
                1,
                "ZAM_A-1_1_T-99999999999999999999999-1",
            ),
        ] {
            let found = other_traffic(id, number);
            assert_eq!(found, next);
            assert!(is_valid(&found), "{found}");
        }
    }
}
