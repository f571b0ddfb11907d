//! Fragments included by a template, and a hash over it and them.

use std::collections::{BTreeMap, BTreeSet};

use sha2::{Digest, Sha256};

/// The names of the fragments that `source` includes, and that those include.
///
/// A fragment counts as included where its name stands in quotes; [`super::render()`] offers no other, so that the
/// hash covers all that can be in a message.
pub(super) fn included<'f>(
    source: &str,
    fragments: &'f BTreeMap<String, String>,
) -> BTreeSet<&'f str> {
    let mut found = BTreeSet::new();
    let mut look = vec![source];
    while let Some(text) = look.pop() {
        for (name, fragment) in fragments {
            let named = [format!("\"{name}\""), format!("'{name}'")];
            if named.iter().any(|n| text.contains(n.as_str())) && found.insert(name.as_str()) {
                look.push(fragment);
            }
        }
    }
    found
}

impl super::Library {
    /// The names of the fragments that a text includes, and that those include.
    #[must_use]
    pub fn included(&self, source: &str) -> BTreeSet<&str> {
        included(source, self.fragments())
    }
}

/// SHA-256, hexadecimal, of a template and the fragments that it includes.
#[must_use]
pub fn hash(source: &str, fragments: &BTreeMap<String, String>) -> String {
    let mut digest = Sha256::new();
    let mut add = |text: &str| {
        // With its length, so that no two sets of texts are alike one after the other.
        digest.update((text.len() as u64).to_le_bytes());
        digest.update(text.as_bytes());
    };
    add(source);
    for name in included(source, fragments) {
        add(name);
        add(&fragments[name]);
    }
    digest
        .finalize()
        .iter()
        .map(|b| format!("{b:02x}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_covers_what_is_included_and_nothing_else() {
        let with = |b: &str, c: &str| {
            BTreeMap::from([
                ("_a.md".to_string(), "{% include '_b.md' %}".to_string()),
                ("_b.md".to_string(), b.to_string()),
                ("_c.md".to_string(), c.to_string()),
            ])
        };
        let source = "x {% include \"_a.md\" %}";
        let found = with("1", "1");
        assert_eq!(included(source, &found), BTreeSet::from(["_a.md", "_b.md"]));
        let now = hash(source, &with("1", "1"));
        assert_eq!(now, hash(source, &with("1", "2")));
        assert_ne!(now, hash(source, &with("2", "1")));
        assert_ne!(now, hash("y {% include \"_a.md\" %}", &with("1", "1")));
    }
}
