//! Ids that are unique in a scenario, as CommonRoad wants them, for things that a data set counts apart.

use std::collections::HashSet;

/// Gives out ids: the data set's own where they are positive and free.
#[derive(Default)]
pub struct Ids {
    taken: HashSet<i64>,
    next: i64,
}

/// Ids up to this are counted on from.
const LARGEST: i64 = i64::MAX / 2;

impl Ids {
    /// Where the data set uses these ids.
    pub fn beyond(used: impl IntoIterator<Item = i64>) -> Self {
        let used = used.into_iter().filter(|id| *id < LARGEST);
        Self {
            taken: HashSet::new(),
            next: used.max().unwrap_or(0).max(0) + 1,
        }
    }

    /// Takes an id; whether it was free.
    pub fn take(&mut self, id: i64) -> bool {
        self.taken.insert(id)
    }

    /// This id, or a free one where it is taken or none.
    pub fn keep(&mut self, id: i64) -> i64 {
        if id > 0 && self.taken.insert(id) {
            return id;
        }
        self.fresh()
    }

    /// A free id.
    pub fn fresh(&mut self) -> i64 {
        while !self.taken.insert(self.next) {
            self.next += 1;
        }
        self.next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_kept_where_they_are_free() {
        let mut ids = Ids::beyond([7, 9, 3, i64::MAX]);
        assert!(ids.take(7) && ids.take(9) && !ids.take(9));
        assert_eq!(
            [3, 7, 0, -1, 10].map(|id| ids.keep(id)),
            [3, 10, 11, 12, 13]
        );
        assert_eq!(ids.fresh(), 14);
    }
}
