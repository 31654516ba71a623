//! What is made once, by whoever asks first, where tasks of the pool ask for it.

use std::sync::OnceLock;

/// What a cell holds; made now if nothing was yet.
///
/// Nobody waits for another to make it, as [`OnceLock::get_or_init`] would: a thread of the pool that makes it could take up a task that asks
/// for it and wait for itself, or wait for threads that all wait for it. Two may make it; the first one's is kept.
pub(crate) fn once<T>(cell: &OnceLock<T>, make: impl FnOnce() -> T) -> &T {
    if let Some(made) = cell.get() {
        return made;
    }
    let made = make();
    cell.get_or_init(|| made)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;
    use std::sync::mpsc::channel;
    use std::time::Duration;

    /// Tasks that all ask for it at once, while it takes tasks itself to make it: none waits for itself.
    #[test]
    fn tasks_that_ask_for_it_do_not_wait_for_themselves() {
        let (done, when) = channel();
        std::thread::spawn(move || {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
            for round in 0..50u32 {
                let cell = OnceLock::new();
                let make = || (0..2000u32).into_par_iter().with_max_len(1).map(|n| n ^ round).sum::<u32>();
                let ask = || (0..64).into_par_iter().with_max_len(1).map(|_| *once(&cell, make)).max();
                assert_eq!(pool.install(ask), Some((0..2000u32).map(|n| n ^ round).sum()));
            }
            done.send(()).unwrap();
        });
        assert!(when.recv_timeout(Duration::from_secs(60)).is_ok(), "tasks wait for each other");
    }

    /// One thread beside the pool makes it while all of the pool's wait for it.
    #[test]
    fn what_a_thread_beside_the_pool_makes_the_pool_may_wait_for() {
        let (done, when) = channel();
        std::thread::spawn(move || {
            for _ in 0..50 {
                let cell = OnceLock::new();
                let make = || (0..2000u32).into_par_iter().with_max_len(1).sum::<u32>();
                rayon::in_place_scope(|beside| {
                    beside.spawn(|_| {
                        (0..64).into_par_iter().with_max_len(1).for_each(|_| assert_eq!(*once(&cell, make), 1_999_000))
                    });
                    assert_eq!(*once(&cell, make), 1_999_000);
                });
            }
            done.send(()).unwrap();
        });
        assert!(when.recv_timeout(Duration::from_secs(60)).is_ok(), "the pool and the thread wait for each other");
    }
}
