//! A device that is lost: drivers give one up when a frame hangs, when they are updated, when the card is taken away.
//!
//! wgpu tells it to a callback, and panics in some calls afterwards. Whoever draws looks before and after such calls ([`Loss::expect_none`]), and
//! [`crate::run`] says of whatever comes of a lost device that it is lost: one message, one exit code.

use crate::{Error, Result};
use std::cell::RefCell;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};

thread_local! {
    /// Of the device that this thread opened last.
    static LATEST: RefCell<Option<Loss>> = const { RefCell::new(None) };
}

/// Whether a device is lost, and after how many frames.
#[derive(Debug, Clone)]
pub struct Loss(Arc<Watched>);

#[derive(Debug)]
struct Watched {
    adapter: String,
    why: OnceLock<String>,
    frames: AtomicU32,
}

impl Loss {
    /// Watches a device. `adapter`: its name.
    pub fn watch(device: &wgpu::Device, adapter: String) -> Self {
        let loss = Self(Arc::new(Watched { adapter, why: OnceLock::new(), frames: AtomicU32::new(0) }));
        let watched = loss.clone();
        device.set_device_lost_callback(move |_, why| {
            // It is told once.
            let _ = watched.0.why.set(why);
        });
        let watched = loss.clone();
        device.on_uncaptured_error(Arc::new(move |error| {
            // What a lost device makes is invalid, and every use of it an error of its own.
            assert!(watched.is_lost(), "wgpu error: {error}");
        }));
        LATEST.set(Some(loss.clone()));
        loss
    }

    /// Whether it is.
    pub fn is_lost(&self) -> bool {
        self.0.why.get().is_some()
    }

    /// A frame is done.
    pub fn count_frame(&self) {
        if !self.is_lost() {
            self.0.frames.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// # Errors
    /// [`Error::Lost`] when the device is lost.
    pub fn expect_none(&self) -> Result<()> {
        self.error().map_or(Ok(()), Err)
    }

    fn error(&self) -> Option<Error> {
        let Watched { adapter, why, frames } = &*self.0;
        let why = why.get()?.trim_end_matches('.').to_owned();
        Some(Error::Lost { adapter: adapter.clone(), frames: frames.load(Ordering::Relaxed), why })
    }
}

/// That the device which this thread opened last is lost.
pub fn latest() -> Option<Error> {
    // Also asked by the panic hook, and there at the thread's end.
    LATEST.try_with(|latest| latest.try_borrow().ok()?.as_ref()?.error()).ok().flatten()
}

/// What devices of former runs in this thread came to is no news.
pub fn forget() {
    LATEST.set(None);
}

/// Lets nothing be said of panics that follow from a lost device: they end in [`crate::run`], which says what happened.
pub fn quiet_panics() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if latest().is_none() {
            usual(panic);
        }
    }));
}
