//! Work on all cores whose results come in order, a bounded number ahead.

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
                        // Nobody listens any more after an early end.
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
                    Ok(result) if !stopped() => break result,
                    Err(RecvTimeoutError::Timeout) if !stopped() => {}
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
