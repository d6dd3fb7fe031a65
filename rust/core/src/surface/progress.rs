//! Progress of a long computation, read and cancelled from another thread.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

use crate::error::{Error, Result};

/// The completed fraction of a computation, and whether it was cancelled.
#[derive(Debug, Default)]
pub struct Progress {
    /// The completed fraction, in millionths.
    millionths: AtomicU32,
    is_cancelled: AtomicBool,
}

impl Progress {
    /// The completed fraction, 0..1.
    pub fn done(&self) -> f64 {
        f64::from(self.millionths.load(Relaxed)) * 1e-6
    }

    /// Ends the computation soon, with [`Error::Cancelled`].
    pub fn cancel(&self) {
        self.is_cancelled.store(true, Relaxed);
    }

    /// True if the computation was cancelled.
    pub(super) fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Relaxed)
    }

    /// Sets the completed fraction, 0..1.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if the computation was cancelled.
    pub(super) fn reach(&self, done: f64) -> Result<()> {
        self.millionths.store((done * 1e6) as u32, Relaxed);
        if self.is_cancelled() {
            Err(Error::Cancelled)
        } else {
            Ok(())
        }
    }
}
