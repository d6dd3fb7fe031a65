//! The thread pool, which is the only state of the module.

use std::sync::{Arc, PoisonError, RwLock};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::errors::value_error;
use crate::scalars::Whole;

/// The pool that was requested. `None`: one thread per core, including the thread that loaded the module.
static POOL: RwLock<Option<Arc<ThreadPool>>> = RwLock::new(None);
/// An upper limit for the number of threads.
const THREAD_LIMIT: i64 = 1024;

/// Makes this thread, which loads the module and requests most frames, a member of the pool. Otherwise it
/// would sleep and be woken in every frame, while one more thread than cores would run. Other threads share
/// rayon's global pool.
pub fn enlist_this_thread() {
    if rayon::current_thread_index().is_some() {
        return; // loaded again
    }
    // if no threads can be started, this thread waits for rayon's global pool as others do
    if let Ok(pool) = ThreadPoolBuilder::new().use_current_thread().build() {
        std::mem::forget(pool);
    }
}

/// Sets the number of threads of the pool; 0 for one per core. Results have the same bits for any number.
#[pyfunction]
pub fn set_thread_count(py: Python<'_>, count: Whole) -> PyResult<()> {
    let count: i64 = count.named("count")?;
    let threads = usize::try_from(count).ok().filter(|_| count <= THREAD_LIMIT);
    let threads =
        threads.ok_or_else(|| value_error(format!("count: expected 0 to {THREAD_LIMIT}, got {count}")))?;
    let pool = if threads == 0 {
        None
    } else {
        Some(pool_of(threads)?)
    };
    let former = std::mem::replace(&mut *POOL.write().unwrap_or_else(PoisonError::into_inner), pool);
    py.detach(|| drop(former));
    Ok(())
}

/// Runs `work` in the pool, without the GIL.
pub fn in_pool<R: Send>(py: Python<'_>, work: impl FnOnce() -> R + Send) -> R {
    let pool = POOL.read().unwrap_or_else(PoisonError::into_inner).clone();
    py.detach(|| match pool {
        Some(pool) => pool.install(work),
        None => work(),
    })
}

fn pool_of(threads: usize) -> PyResult<Arc<ThreadPool>> {
    let built = ThreadPoolBuilder::new().num_threads(threads).build();
    built
        .map(Arc::new)
        .map_err(|error| value_error(format!("count: {threads} threads cannot be started: {error}")))
}
