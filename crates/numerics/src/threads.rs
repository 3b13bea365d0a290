//! Threads for work that is shared out, as many as the system gives.

use std::io;

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// A pool of `count` threads (0: one per processor). Where the system gives no more, in a container or
/// under `ulimit -u`, fewer, in the end only the calling thread: the pool then works while that one
/// waits in `install`.
///
/// # Errors
/// The calling thread belongs to another pool already, and no thread can be started.
pub fn pool(count: usize) -> Result<ThreadPool, ThreadPoolBuildError> {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let mut count = if count == 0 { processors } else { count };
    while count > 0 {
        if let Ok(pool) = ThreadPoolBuilder::new().num_threads(count).build() {
            return Ok(pool);
        }
        count /= 2;
    }
    ThreadPoolBuilder::new().num_threads(1).use_current_thread().build()
}

/// Of an error by which a thread or a process does not start: where the system gives no more of them, that and
/// the way out; any other error stays as it is.
#[must_use]
pub fn refused(error: io::Error) -> io::Error {
    match error.kind() {
        // EAGAIN of fork and pthread_create.
        io::ErrorKind::WouldBlock => io::Error::new(
            io::ErrorKind::WouldBlock,
            "the system gives this program no more threads and processes; allow more \
             (ulimit -u, a container's limit of processes)",
        ),
        _ => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_limit_is_called_one() {
        let limit = refused(io::Error::from(io::ErrorKind::WouldBlock));
        assert!(limit.to_string().contains("ulimit -u"), "{limit}");
        assert_eq!(limit.kind(), io::ErrorKind::WouldBlock);
        let absent = refused(io::Error::from(io::ErrorKind::NotFound));
        assert!(!absent.to_string().contains("ulimit"), "{absent}");
    }
}
