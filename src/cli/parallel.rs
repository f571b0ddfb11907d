//! Parallel work on all cores with results in input order, a bounded number ahead.

use std::collections::VecDeque;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

/// How soon an interrupt is noticed while nothing is finished.
const PATIENCE: Duration = Duration::from_millis(50);

/// Does `work` for `0..count` on rayon's threads and hands the results to `take` on this one, in order.
///
/// Ends early when `take` breaks or `stop` becomes true; what is being worked on then is finished and dropped.
pub fn in_order<T: Send>(
    count: usize,
    stop: &AtomicBool,
    work: impl Fn(usize) -> T + Sync,
    take: impl FnMut(T) -> ControlFlow<()>,
) {
    ordered(count, stop, false, work, take);
}

/// The same for work that takes so long that nothing finished may be lost: when `stop` becomes true, what is being
/// worked on is waited for, and all results are handed out that there are. Some before them may be missing then.
pub fn in_order_and_kept<T: Send>(
    count: usize,
    stop: &AtomicBool,
    work: impl Fn(usize) -> T + Sync,
    take: impl FnMut(T) -> ControlFlow<()>,
) {
    ordered(count, stop, true, work, take);
}

fn ordered<T: Send>(
    count: usize,
    stop: &AtomicBool,
    keep: bool,
    work: impl Fn(usize) -> T + Sync,
    mut take: impl FnMut(T) -> ControlFlow<()>,
) {
    let ahead = 2 * rayon::current_num_threads() + 2;
    let (work, given_up) = (&work, &AtomicBool::new(false));
    let stopped = move || stop.load(Ordering::Relaxed) || given_up.load(Ordering::Relaxed);
    rayon::in_place_scope(|scope| {
        let mut waiting = VecDeque::new();
        let mut next = 0..count;
        loop {
            while waiting.len() < ahead
                && let Some(i) = next.next()
            {
                let (sender, receiver) = sync_channel(1);
                scope.spawn(move |_| {
                    if !stopped() {
                        // The receiver is gone after an early end.
                        let _ = sender.send(work(i));
                    }
                });
                waiting.push_back(receiver);
            }
            let Some(first) = waiting.pop_front() else {
                return;
            };
            let result = loop {
                match first.recv_timeout(PATIENCE) {
                    Ok(result) if keep || !stopped() => break result,
                    Err(RecvTimeoutError::Timeout) if !stopped() => {}
                    _ if keep => {
                        let left = std::iter::once(first).chain(waiting);
                        // Those that were not begun hang up.
                        let finished = left.filter_map(|one| one.recv().ok());
                        let _ = finished.map(&mut take).find(ControlFlow::is_break);
                        return;
                    }
                    _ => return,
                }
            };
            if take(result).is_break() {
                given_up.store(true, Ordering::Relaxed);
                return;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    #[test]
    fn results_come_in_order_and_not_too_far_ahead() {
        let (begun, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
        let mut taken = Vec::new();
        let work = |i: usize| {
            begun.fetch_add(1, Ordering::SeqCst);
            // Later ones are faster.
            std::thread::sleep(Duration::from_micros(500 - 2 * i as u64));
            i
        };
        let ahead = 2 * rayon::current_num_threads() + 2;
        in_order(200, &stop, work, |i| {
            taken.push(i);
            assert!(begun.load(Ordering::SeqCst) <= i + 1 + ahead);
            ControlFlow::Continue(())
        });
        assert_eq!(taken, (0..200).collect::<Vec<_>>());
        in_order(0, &stop, |i| i, |_| unreachable!("there is nothing to do"));
    }

    #[test]
    fn what_is_finished_when_it_is_stopped_is_kept_if_that_is_wanted() {
        let stop = AtomicBool::new(false);
        let finished = AtomicUsize::new(0);
        let work = |i: usize| {
            if i == 1 {
                std::thread::sleep(Duration::from_millis(20));
                stop.store(true, Ordering::SeqCst);
            }
            finished.fetch_add(1, Ordering::SeqCst);
            i
        };
        let mut taken = Vec::new();
        in_order_and_kept(1000, &stop, work, |i| {
            taken.push(i);
            ControlFlow::Continue(())
        });
        assert_eq!(taken.len(), finished.load(Ordering::SeqCst));
        assert!(taken.contains(&1) && taken.is_sorted() && taken.len() < 1000);
    }

    #[test]
    fn ends_early_when_told_to() {
        let begun = AtomicUsize::new(0);
        let work = |i| {
            begun.fetch_add(1, Ordering::SeqCst);
            i
        };
        let mut taken = 0;
        in_order(100_000, &AtomicBool::new(false), work, |_| {
            taken += 1;
            match taken {
                3 => ControlFlow::Break(()),
                _ => ControlFlow::Continue(()),
            }
        });
        assert_eq!(taken, 3);
        assert!(begun.load(Ordering::SeqCst) < 100_000);
        in_order(9, &AtomicBool::new(true), work, |_| {
            unreachable!("it was stopped before it began")
        });
    }
}
