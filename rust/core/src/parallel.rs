//! Sizes of parallel tasks, and a thread pool that stays awake during a frame.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::{Scope, Yield};

/// Vertices per chunk of the output. A chunk is written or skipped as a whole.
pub(crate) const OUTPUT_CHUNK: usize = 128;
/// Largest rayon task when the output is written, in chunks. Many chunks are skipped, so larger tasks would
/// not balance.
pub(crate) const OUTPUT_CHUNKS_PER_TASK: usize = 4;
/// Vertices per chunk of the relaxation. A chunk is computed or skipped as a whole.
pub(crate) const RELAXATION_CHUNK: usize = 256;
/// Largest rayon task in the relaxation, in chunks. Most chunks are skipped, so larger tasks would not
/// balance.
pub(crate) const RELAXATION_CHUNKS_PER_TASK: usize = 2;
/// Vertices per task when the output is copied from sorted order to mesh order.
pub(crate) const REORDER_CHUNK: usize = 4096;
/// Most threads that are kept awake besides the one that starts the frame. More would find too little work in
/// a frame.
const MOST_KEPT: usize = 7;

/// Runs `work` on the pool. Up to [`MOST_KEPT`] other threads of the pool spin until it ends.
///
/// A frame has about 40 parallel loops with pauses between them that are as short as the loops. Waking a
/// sleeping thread takes the system as long as the thread's part of a loop.
pub(crate) fn with_hot_pool<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    let ends = AtomicBool::new(false);
    rayon::scope(|scope| {
        let _end = End(&ends); // also if `work` panics; otherwise the scope would wait for ever
        keep_others_awake(scope, &ends);
        work()
    })
}

fn keep_others_awake<'scope>(scope: &Scope<'scope>, ends: &'scope AtomicBool) {
    let first = rayon::current_thread_index();
    for _ in 0..MOST_KEPT.min(rayon::current_num_threads() - 1) {
        scope.spawn(move |_| {
            // on the thread that runs `work`, this task would wait for itself
            while rayon::current_thread_index() != first && !ends.load(Ordering::Acquire) {
                if rayon::yield_now() != Some(Yield::Executed) {
                    // if other processes occupy the cores, give way to the thread that this one waits for
                    std::thread::yield_now();
                }
            }
        });
    }
}

/// Sets its flag when it is dropped.
struct End<'a>(&'a AtomicBool);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}
