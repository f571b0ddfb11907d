//! A small cache of recent results: many questions share a scene, and many samples share a question.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// The results that were wanted last; what is wanted by several at once is made once.
pub struct Recent<K, V> {
    most: usize,
    kept: Mutex<VecDeque<(K, Arc<OnceLock<V>>)>>,
}

impl<K: PartialEq + Clone, V: Clone> Recent<K, V> {
    /// Keeps at most `most` results.
    pub fn new(most: usize) -> Self {
        Self {
            most,
            kept: Mutex::default(),
        }
    }

    /// The result for `key`, made by `make` where it is not there; others who want the same wait for it.
    pub fn get(&self, key: &K, make: impl FnOnce() -> V) -> V {
        let place = {
            let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            match kept.iter().position(|(known, _)| known == key) {
                Some(at) => Arc::clone(&kept[at].1),
                None => {
                    let place = Arc::new(OnceLock::new());
                    kept.push_back((key.clone(), Arc::clone(&place)));
                    if kept.len() > self.most {
                        kept.pop_front();
                    }
                    place
                }
            }
        };
        place.get_or_init(make).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_wanted_lately_is_made_once() {
        let recent = Recent::new(2);
        let made = std::cell::Cell::new(0);
        let get = |key: u8| {
            recent.get(&key, || {
                made.set(made.get() + 1);
                key * 10
            })
        };
        assert_eq!([get(1), get(2), get(1)], [10, 20, 10]);
        assert_eq!(made.get(), 2);
        assert_eq!(
            [get(3), get(1)],
            [30, 10],
            "1 was there longest, and is gone"
        );
        assert_eq!(made.get(), 4);
    }
}
