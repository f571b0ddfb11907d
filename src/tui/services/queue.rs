//! A queue of scenarios processed on all cores, visible ones first.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::request::{Replies, Request};
use nearmiss_formats::Entry;

/// The work done for a scenario, by its place in the list.
type Work<R> = Arc<dyn Fn(usize, &Entry) -> <R as Request>::Reply + Send + Sync>;

/// The work, and where its replies go.
type Assignment<R> = (Work<R>, Replies<R>);

/// A queue; its clones are the same queue.
pub struct Queue<R: Request> {
    waiting: Arc<Mutex<Waiting<R>>>,
}

struct Waiting<R: Request> {
    /// By their places, which is the order in which they are taken.
    entries: BTreeMap<usize, Entry>,
    /// Places that are taken before the others.
    first: Vec<usize>,
    work: Option<Assignment<R>>,
    /// Raised whenever everything is asked for anew: what is on its way then is of no use.
    asked: u64,
    /// How many are at work.
    at_work: usize,
}

impl<R: Request> Default for Queue<R> {
    fn default() -> Self {
        Self {
            waiting: Arc::new(Mutex::new(Waiting {
                entries: BTreeMap::new(),
                first: Vec::new(),
                work: None,
                asked: 0,
                at_work: 0,
            })),
        }
    }
}

impl<R: Request> Clone for Queue<R> {
    fn clone(&self) -> Self {
        Self {
            waiting: Arc::clone(&self.waiting),
        }
    }
}

impl<R: Request> Queue<R> {
    /// Replaces the queue: does this work with these scenarios and replies, and drops earlier entries.
    pub fn replace(
        &self,
        entries: Vec<(usize, Entry)>,
        replies: Replies<R>,
        work: impl Fn(usize, &Entry) -> R::Reply + Send + Sync + 'static,
    ) {
        let mut waiting = self.lock();
        waiting.asked += 1;
        waiting.entries.clear();
        waiting.first.clear();
        waiting.work = Some((Arc::new(work), replies));
        drop(waiting);
        self.add(entries);
    }

    /// Empties the queue; results still on their way are dropped.
    pub fn stop(&self) {
        let mut waiting = self.lock();
        waiting.asked += 1;
        waiting.entries.clear();
        waiting.first.clear();
    }

    /// Does the same with these too.
    pub fn add(&self, entries: Vec<(usize, Entry)>) {
        let mut waiting = self.lock();
        waiting.entries.extend(entries);
        let wanted = waiting.entries.len().min(rayon::current_num_threads());
        let new = wanted.saturating_sub(waiting.at_work);
        waiting.at_work += new;
        drop(waiting);
        (0..new).for_each(|_| self.clone().go_on());
    }

    /// Takes these before the others.
    pub fn first(&self, places: Vec<usize>) {
        self.lock().first = places;
    }

    /// Works on one scenario, then queues up again behind whatever else wants the cores meanwhile.
    fn go_on(self) {
        rayon::spawn_fifo(move || {
            let Some((place, entry, (work, replies), asked)) = self.take() else {
                return;
            };
            // A scenario that makes a measure panic must not hold up the others.
            let result =
                std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| work(place, &entry)));
            let of_use = self.lock().asked == asked;
            if let Ok(reply) = result
                && of_use
                && !replies.send(reply)
            {
                // The loop has ended.
                self.lock().entries.clear();
            }
            self.go_on();
        });
    }

    fn take(&self) -> Option<(usize, Entry, Assignment<R>, u64)> {
        let mut waiting = self.lock();
        let mut first = std::mem::take(&mut waiting.first).into_iter();
        let urgent = first.find_map(|place| waiting.entries.remove_entry(&place));
        waiting.first = first.collect();
        let next = urgent.or_else(|| waiting.entries.pop_first());
        match (next, waiting.work.clone()) {
            (Some((place, entry)), Some(work)) => Some((place, entry, work, waiting.asked)),
            _ => {
                waiting.at_work -= 1;
                None
            }
        }
    }

    fn lock(&self) -> MutexGuard<'_, Waiting<R>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::collections::HashSet;
    use std::path::Path;
    use std::sync::Barrier;

    use super::*;
    use crate::services::Services;

    /// Its replies are places in the list.
    #[derive(Debug)]
    struct Place;

    impl Request for Place {
        type Reply = usize;

        fn perform(self, _: &mut Services, _: Replies<Self>) {}
    }

    fn entries(count: usize) -> Vec<(usize, Entry)> {
        (0..count)
            .map(|place| (place, Entry::of_file(Path::new("a.xml"))))
            .collect()
    }

    #[test]
    fn what_is_wanted_first_comes_first_and_everything_comes_once() {
        let (sender, mut receiver) = tokio::sync::mpsc::unbounded_channel();
        let queue = Queue::<Place>::default();
        let threads = rayon::current_num_threads();
        // Workers wait until the order is set.
        let gate = Arc::new(Barrier::new(threads + 1));
        let held = gate.clone();
        let count = threads + 40;
        queue.replace(entries(count), Replies::new(sender), move |place, _| {
            if place < threads {
                held.wait();
            }
            place
        });
        queue.first(vec![threads + 30, threads + 20]);
        gate.wait();
        let mut places = Vec::new();
        while places.len() < count {
            let reply = receiver.blocking_recv().unwrap();
            places.push(reply.into_reply::<Place>().unwrap());
        }
        let at = |place: usize| places.iter().position(|&p| p == place).unwrap();
        let ordinary = at(threads + 39);
        assert!(at(threads + 30) < ordinary && at(threads + 20) < ordinary);
        let unique: HashSet<usize> = places.iter().copied().collect();
        assert_eq!(unique.len(), count);
    }
}
