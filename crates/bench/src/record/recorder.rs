//! The thread behind the ring buffer.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use rtrb::{Consumer, Producer, RingBuffer};

use super::journal::{Journal, JournalError};

/// How often the ring is emptied.
const INTERVAL: Duration = Duration::from_millis(20);

/// The latest rows, for a live view.
#[derive(Clone, Debug, Default)]
pub struct Latest {
    /// The newest row; empty before the first.
    pub row: Vec<f64>,
    /// Number of rows so far.
    pub rows: u64,
    /// Least and greatest value of each column since the batch before.
    pub range: Vec<(f64, f64)>,
    /// Nothing more will come.
    pub ended: bool,
}

/// A window on the latest rows; the cycle never touches it.
#[derive(Clone, Debug, Default)]
pub struct View(Arc<Mutex<Latest>>);

impl View {
    /// What there is now.
    #[must_use]
    pub fn latest(&self) -> Latest {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn update(&self, batch: &[f64], width: usize) {
        let mut latest = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let rows = batch.chunks_exact(width);
        latest.rows += rows.len() as u64;
        let nothing = (f64::INFINITY, f64::NEG_INFINITY);
        latest.range = vec![nothing; width];
        for row in rows {
            for ((least, greatest), value) in latest.range.iter_mut().zip(row) {
                (*least, *greatest) = (least.min(*value), greatest.max(*value));
            }
            latest.row.clear();
            latest.row.extend_from_slice(row);
        }
    }

    fn end(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).ended = true;
    }
}

/// Empties the ring into the journal and the view.
#[derive(Debug)]
pub struct Recorder {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Result<Recorded, JournalError>>,
    view: View,
}

/// What was recorded.
#[derive(Debug)]
pub struct Recorded {
    /// Rows.
    pub rows: u64,
    /// The journal, if there is one.
    pub journal: Option<std::path::PathBuf>,
}

impl Recorder {
    /// Starts the thread. `width`: values of a row; `depth`: rows that the ring holds. The other
    /// end of the ring is for the cycle.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(
        journal: Option<Journal>,
        width: usize,
        depth: usize,
    ) -> io::Result<(Self, Producer<f64>)> {
        let (producer, consumer) = RingBuffer::new(width.max(1) * depth.max(1));
        let stop = Arc::new(AtomicBool::new(false));
        let view = View::default();
        let (flag, window) = (Arc::clone(&stop), view.clone());
        let thread = std::thread::Builder::new()
            .spawn(move || empty(consumer, journal, width.max(1), &flag, &window))?;
        Ok((Recorder { stop, thread, view }, producer))
    }

    /// The window on the latest rows.
    #[must_use]
    pub fn view(&self) -> &View {
        &self.view
    }

    /// Takes what is left in the ring, and ends.
    ///
    /// # Errors
    /// The journal could not be written.
    pub fn finish(self) -> Result<Recorded, JournalError> {
        self.stop.store(true, Ordering::Release);
        self.thread.join().unwrap_or(Ok(Recorded { rows: 0, journal: None }))
    }
}

fn empty(
    mut ring: Consumer<f64>,
    mut journal: Option<Journal>,
    width: usize,
    stop: &AtomicBool,
    view: &View,
) -> Result<Recorded, JournalError> {
    let mut batch = Vec::new();
    let mut rows = 0;
    let mut trouble = None;
    loop {
        let last = stop.load(Ordering::Acquire);
        let waiting = ring.slots() / width * width;
        batch.clear();
        if let Ok(chunk) = ring.read_chunk(waiting) {
            batch.extend(chunk);
        }
        if !batch.is_empty() {
            rows += (batch.len() / width) as u64;
            view.update(&batch, width);
            let written = journal.as_mut().filter(|_| trouble.is_none());
            trouble = written.and_then(|journal| journal.write(&batch).err()).or(trouble);
        }
        if last {
            break;
        }
        std::thread::sleep(INTERVAL);
    }
    view.end();
    match trouble {
        Some(error) => Err(error),
        None => Ok(Recorded { rows, journal: journal.map(Journal::finish).transpose()? }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_arrives_in_order() {
        let (recorder, mut ring) = Recorder::start(None, 2, 100_000).unwrap();
        for k in 0..10_000 {
            ring.push(f64::from(k)).unwrap();
            ring.push(-f64::from(k)).unwrap();
        }
        let view = recorder.view().clone();
        assert_eq!(recorder.finish().unwrap().rows, 10_000);
        let latest = view.latest();
        assert_eq!((latest.row, latest.rows), (vec![9999.0, -9999.0], 10_000));
        assert!(latest.ended);
    }
}
