//! A queue of scenarios processed on all cores, visible ones first.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::mpsc::UnboundedSender;

use super::super::message::Msg;
use nearmiss_formats::Entry;

/// The work done for a scenario, by its place in the list.
pub type Work = Arc<dyn Fn(usize, &Entry) -> Msg + Send + Sync>;

/// A queue; its clones are the same queue.
#[derive(Clone)]
pub struct Queue {
    waiting: Arc<Mutex<Waiting>>,
    sender: UnboundedSender<Msg>,
}

#[derive(Default)]
struct Waiting {
    /// By their places, which is the order in which they are taken.
    entries: BTreeMap<usize, Entry>,
    /// Places that are taken before the others.
    first: Vec<usize>,
    work: Option<Work>,
    /// Raised whenever everything is asked for anew: what is on its way then is of no use.
    asked: u64,
    /// How many are at work.
    at_work: usize,
}

impl Queue {
    /// A queue with nothing in it, whose results go there.
    pub fn new(sender: UnboundedSender<Msg>) -> Self {
        Self {
            waiting: Arc::default(),
            sender,
        }
    }

    /// Replaces the queue: does this work with these scenarios, and drops earlier entries.
    pub fn replace(&self, entries: Vec<(usize, Entry)>, work: Work) {
        let mut waiting = self.lock();
        waiting.asked += 1;
        waiting.entries.clear();
        waiting.first.clear();
        waiting.work = Some(work);
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
            let Some((place, entry, work, asked)) = self.take() else {
                return;
            };
            // A scenario that makes a measure panic must not hold up the others.
            let result =
                std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| work(place, &entry)));
            let of_use = self.lock().asked == asked;
            if let Ok(msg) = result
                && of_use
                && self.sender.send(msg).is_err()
            {
                // The loop has ended.
                self.lock().entries.clear();
            }
            self.go_on();
        });
    }

    fn take(&self) -> Option<(usize, Entry, Work, u64)> {
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

    fn lock(&self) -> MutexGuard<'_, Waiting> {
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

    fn entries(count: usize) -> Vec<(usize, Entry)> {
        (0..count)
            .map(|place| (place, Entry::of_file(Path::new("a.xml"))))
            .collect()
    }

    #[test]
    fn what_is_wanted_first_comes_first_and_everything_comes_once() {
        let (sender, mut receiver) = tokio::sync::mpsc::unbounded_channel();
        let queue = Queue::new(sender);
        let threads = rayon::current_num_threads();
        // Workers wait until the order is set.
        let gate = Arc::new(Barrier::new(threads + 1));
        let held = gate.clone();
        let count = threads + 40;
        queue.replace(
            entries(count),
            Arc::new(move |place, _: &Entry| {
                if place < threads {
                    held.wait();
                }
                Msg::Ranked("risk", place, None)
            }),
        );
        queue.first(vec![threads + 30, threads + 20]);
        gate.wait();
        let mut places = Vec::new();
        while places.len() < count {
            match receiver.blocking_recv().unwrap() {
                Msg::Ranked(_, place, _) => places.push(place),
                other => panic!("{other:?}"),
            }
        }
        let at = |place: usize| places.iter().position(|&p| p == place).unwrap();
        let ordinary = at(threads + 39);
        assert!(at(threads + 30) < ordinary && at(threads + 20) < ordinary);
        let unique: HashSet<usize> = places.iter().copied().collect();
        assert_eq!(unique.len(), count);
    }
}
