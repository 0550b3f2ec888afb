//! Work behind the window: a thread that says how far it is, and hands over what it made.

use crate::error::{Error, Result};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex};

/// How far work is; shared with the thread that does it.
pub struct Progress {
    what: Mutex<String>,
    done: AtomicUsize,
    total: AtomicUsize,
    /// Asks the window to look again.
    wake: Box<dyn Fn() + Send + Sync>,
}

impl Progress {
    fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        let (what, done, total) = (Mutex::default(), AtomicUsize::new(0), AtomicUsize::new(1));
        Self { what, done, total, wake: Box::new(wake) }
    }

    /// That of work which nobody watches.
    #[cfg(test)]
    pub fn silent() -> Self {
        Self::new(|| ())
    }

    /// Begins a part of `total` ticks; the function that library calls take as `tick`.
    pub fn begin(&self, what: &str, total: usize) -> impl Fn() + Sync + '_ {
        if let Ok(mut text) = self.what.lock() {
            what.clone_into(&mut text);
        }
        self.done.store(0, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
        (self.wake)();
        || {
            self.done.fetch_add(1, Ordering::Relaxed);
            (self.wake)();
        }
    }

    /// What is being done, and the share of it that is done, 0 to 1.
    pub fn now(&self) -> (String, f32) {
        let what = self.what.lock().map(|text| text.clone()).unwrap_or_default();
        let total = self.total.load(Ordering::Relaxed).max(1);
        (what, (self.done.load(Ordering::Relaxed) as f32 / total as f32).min(1.0))
    }
}

/// Wakes the window when the work ends, however it ends.
struct Waker(Arc<Progress>);

impl Drop for Waker {
    fn drop(&mut self) {
        (self.0.wake)();
    }
}

/// Work under way. Dropped, its result is thrown away when it comes.
pub struct Job<T> {
    progress: Arc<Progress>,
    result: Receiver<Result<T>>,
}

impl<T: Send + 'static> Job<T> {
    /// Starts work in a thread of its own. `wake` is called whenever there is something new to show.
    pub fn start(
        wake: impl Fn() + Send + Sync + 'static,
        work: impl FnOnce(&Progress) -> Result<T> + Send + 'static,
    ) -> Self {
        let progress = Arc::new(Progress::new(wake));
        let (sender, result) = channel();
        let shared = Waker(progress.clone());
        std::thread::spawn(move || {
            // A window that has gone on without it needs no answer.
            let _ = sender.send(work(&shared.0));
            drop(sender);
            drop(shared);
        });
        Self { progress, result }
    }

    /// How far it is.
    pub fn progress(&self) -> (String, f32) {
        self.progress.now()
    }

    /// Until there is a result, which is thrown away.
    pub fn wait(&self) {
        let _ = self.result.recv();
    }

    /// The result, once there is one.
    pub fn poll(&self) -> Option<Result<T>> {
        match self.result.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => None,
            // The thread came to grief.
            Err(TryRecvError::Disconnected) => {
                let (what, _) = self.progress.now();
                Some(Err(Error::unsupported(what, "work in the background", "no result", "a result")))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wait<T: Send + 'static>(job: &Job<T>) -> Result<T> {
        loop {
            if let Some(result) = job.poll() {
                return result;
            }
            std::thread::yield_now();
        }
    }

    #[test]
    fn work_tells_how_far_it_is_and_what_came_of_it() {
        let wakes = Arc::new(AtomicUsize::new(0));
        let counted = wakes.clone();
        let job = Job::start(
            move || {
                counted.fetch_add(1, Ordering::Relaxed);
            },
            |progress| {
                let tick = progress.begin("counting", 4);
                (0..3).for_each(|_| tick());
                Ok(progress.now())
            },
        );
        assert_eq!(wait(&job).unwrap(), ("counting".to_owned(), 0.75));
        assert!(wakes.load(Ordering::Relaxed) >= 4);
    }

    #[test]
    fn work_that_fails_or_panics_is_an_error() {
        let job: Job<()> = Job::start(|| (), |_| Err(Error::invalid("", "number", 1, "2")));
        assert!(wait(&job).unwrap_err().to_string().contains("number"));
        let job: Job<()> = Job::start(|| (), |_| panic!("on purpose"));
        assert!(wait(&job).is_err());
        job.wait();
    }

    #[test]
    fn who_waits_goes_on_when_the_work_is_done() {
        let done = Arc::new(AtomicUsize::new(0));
        let counted = done.clone();
        let job = Job::start(
            || (),
            move |_| {
                std::thread::sleep(std::time::Duration::from_millis(50));
                counted.store(1, Ordering::Relaxed);
                Ok(())
            },
        );
        job.wait();
        assert_eq!(done.load(Ordering::Relaxed), 1);
    }
}
