//! Fallible work on all cores whose outcome, errors included, does not depend on how many there are.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::error::Result;

/// Collects what a fallible function makes of every item.
pub trait TryMap: IndexedParallelIterator {
    /// The results in the order of the items, or the error of the first item that has one: rayon's own way gives that of
    /// whichever thread fails first. Items behind a known error are skipped.
    ///
    /// # Errors
    /// Those of `f`.
    fn try_map<R: Send>(self, f: impl Fn(Self::Item) -> Result<R> + Sync + Send) -> Result<Vec<R>> {
        let failed = AtomicUsize::new(usize::MAX);
        let one = |(k, item)| {
            // Only items in front of all known errors can still be the first: a relaxed look that comes late costs time only.
            (k < failed.load(Ordering::Relaxed))
                .then(|| f(item).inspect_err(|_| _ = failed.fetch_min(k, Ordering::Relaxed)))
        };
        let results: Vec<Option<Result<R>>> = self.enumerate().map(one).collect();
        results.into_iter().flatten().collect()
    }
}

impl<I: IndexedParallelIterator> TryMap for I {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use std::thread::sleep;
    use std::time::Duration;

    /// A later item fails before an earlier one is looked at, whose thread waits for that: rayon's collect would give its error.
    #[test]
    fn the_first_error_is_the_one_reported() {
        let has_failed = AtomicUsize::new(0);
        let item = |k: usize| match k {
            0 => {
                // Not for ever: no law says which thread takes what.
                let waits = || has_failed.load(Ordering::Relaxed) == 0;
                (0..200).take_while(|_| waits()).for_each(|_| sleep(Duration::from_millis(1)));
                sleep(Duration::from_millis(10));
                Ok(k)
            }
            1 | 7 => {
                has_failed.fetch_add(k / 7, Ordering::Relaxed);
                Err(Error::invalid("", "item", k, "another"))
            }
            _ => Ok(k),
        };
        let threads = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let result = threads.install(|| (0..8).into_par_iter().with_max_len(1).try_map(item));
        assert!(result.unwrap_err().to_string().starts_with("item: found 1,"));
    }

    #[test]
    fn results_keep_their_order() {
        assert_eq!((0..1000).into_par_iter().try_map(Ok).unwrap(), (0..1000).collect::<Vec<usize>>());
    }
}
