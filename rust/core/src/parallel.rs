//! The pool's threads, kept awake through a frame.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::{Scope, Yield};

/// Vertices of which it is known together whether they are to be written.
pub(crate) const OUTPUT_CHUNK: usize = 128;
/// Most chunks that one thread takes at a time: of many it passes over those that are not, and the others wait for what it has left.
pub(crate) const OUTPUT_CHUNKS_PER_TASK: usize = 4;
/// Vertices of which it is known together whether any moves.
pub(crate) const RELAXATION_CHUNK: usize = 256;
/// Most chunks that one thread takes at a time: of many it passes over those that do not move, and the others wait for what it has left.
pub(crate) const RELAXATION_CHUNKS_PER_TASK: usize = 2;
/// Vertices that one thread gives out at a time.
pub(crate) const REORDER_CHUNK: usize = 4096;
/// Most threads that are kept awake beside the one that a frame begins on: more find too little in one to pay for looking.
const MOST_KEPT: usize = 7;

/// Runs `work` on the pool, whose other threads look for parts of it until it ends. A frame is some forty parallel loops, with pauses
/// between them as short as they are: a thread that fell asleep in each had to be woken by the system, which took it as long as its
/// part of the loop.
pub(crate) fn with_hot_pool<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    let ends = AtomicBool::new(false);
    rayon::scope(|scope| {
        let _end = End(&ends); // where `work` panics, too, or the scope would wait for ever
        keep_others_awake(scope, &ends);
        work()
    })
}

fn keep_others_awake<'scope>(scope: &Scope<'scope>, ends: &'scope AtomicBool) {
    let first = rayon::current_thread_index();
    for _ in 0..MOST_KEPT.min(rayon::current_num_threads() - 1) {
        scope.spawn(move |_| {
            // on the thread that `work` runs on, it would wait for itself
            while rayon::current_thread_index() != first && !ends.load(Ordering::Acquire) {
                if rayon::yield_now() != Some(Yield::Executed) {
                    // else, where other processes leave it no core of its own, it would take the time of the thread that it waits for
                    std::thread::yield_now();
                }
            }
        });
    }
}

/// Sets its flag when it goes.
struct End<'a>(&'a AtomicBool);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}
