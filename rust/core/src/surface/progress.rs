//! How far a long computation is, seen and stopped from another thread.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

use crate::error::{Error, Result};

/// The part done of a computation, and whether it shall go on.
#[derive(Debug, Default)]
pub struct Progress {
    /// The part done, in millionths.
    millionths: AtomicU32,
    is_cancelled: AtomicBool,
}

impl Progress {
    /// The part done, 0..1.
    pub fn done(&self) -> f64 {
        f64::from(self.millionths.load(Relaxed)) * 1e-6
    }

    /// Ends the computation soon, with [`Error::Cancelled`].
    pub fn cancel(&self) {
        self.is_cancelled.store(true, Relaxed);
    }

    /// True once it shall end.
    pub(super) fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Relaxed)
    }

    /// Tells that `done` of it, 0..1, is done.
    ///
    /// # Errors
    /// [`Error::Cancelled`] where it shall not go on.
    pub(super) fn reach(&self, done: f64) -> Result<()> {
        self.millionths.store((done * 1e6) as u32, Relaxed);
        if self.is_cancelled() {
            Err(Error::Cancelled)
        } else {
            Ok(())
        }
    }
}
