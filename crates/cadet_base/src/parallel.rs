//! Where work is spread over threads.
//!
//! A forked process inherits the record of rayon's global pool but none of its threads: work handed to it would wait for
//! ever. Everything that uses rayon goes through [`run`].

use std::cell::RefCell;
use std::sync::atomic::{AtomicU32, Ordering};

use rayon::ThreadPool;

/// The process whose threads the global pool has; 0 before the first use.
static OWNER: AtomicU32 = AtomicU32::new(0);

thread_local! {
    /// A forked process's own pool, and the process that made it.
    static OWN: RefCell<Option<(u32, ThreadPool)>> = const { RefCell::new(None) };
}

/// Runs `work`, whose parallel iterators find living threads: those of the global pool, or, in a process that was forked
/// after the pool's first use, those of a pool of its own. Where no thread can be started, one does it all.
pub fn run<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    let process = std::process::id();
    // Inside a pool the threads are there.
    if rayon::current_thread_index().is_some() {
        return work();
    }
    match OWNER.compare_exchange(0, process, Ordering::Relaxed, Ordering::Relaxed) {
        Ok(_) => work(),
        Err(owner) if owner == process => work(),
        Err(_) => OWN.with_borrow_mut(|own| {
            if own.as_ref().is_none_or(|(maker, _)| *maker != process) {
                // Dropping a pool calls its threads, and those stayed in the process that was forked.
                std::mem::forget(own.take());
                let pool = rayon::ThreadPoolBuilder::new().build();
                *own = pool.ok().map(|pool| (process, pool));
            }
            match own {
                Some((_, pool)) => pool.install(work),
                None => alone(work),
            }
        }),
    }
}

/// Runs `work` in this thread alone.
fn alone<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
    match pool {
        Ok(pool) => pool.install(work),
        Err(error) => panic!("no thread for parallel work: {error}"),
    }
}
