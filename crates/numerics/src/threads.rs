//! Threads for work that is shared out, as many as the system gives.

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
