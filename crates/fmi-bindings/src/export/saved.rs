//! Saved states of an instance, in memory and as bytes.

use model::{Context, Past};

use super::phase::Phase;
use super::progress::{Experiment, Progress};

/// Everything of an instance that changes during a simulation.
pub(super) struct Snapshot {
    pub(super) progress: Progress,
    /// Slopes of the inputs in the next step.
    pub(super) slopes: Vec<f64>,
    /// How the present outputs came about.
    pub(super) past: Past,
    pub(super) context: Context,
}

impl Snapshot {
    /// Whether a simulation can go on from here; what was never written by this library need not.
    fn is_consistent(&self, period: f64) -> bool {
        let Progress { phase, time, experiment, .. } = self.progress;
        let is_finite = time.is_finite() && experiment.start.is_finite();
        let steps = matches!(phase, Phase::Step | Phase::Terminated);
        is_finite && (!steps || self.context.is_at(time, period))
    }
}

const MAGIC: &[u8; 8] = b"PZLSTATE";
/// Version of the layout below.
const VERSION: u32 = 4;
/// magic, version, length of all bytes, fingerprint.
const HEAD: usize = 8 + 4 + 8 + 32;
/// phase, flags, time, start. The stop time is the importer's and stays with the instance.
const PROGRESS: usize = 1 + 1 + 8 + 8;
const CHECKSUM: usize = 8;

const STALE: u8 = 1;
const DEFINED: u8 = 2;
const SLOPED: u8 = 4;

/// Number of bytes of a snapshot.
pub(super) fn byte_len(snapshot: &Snapshot) -> usize {
    let numbers = 8 * snapshot.slopes.len();
    let rest = snapshot.past.byte_len() + snapshot.context.byte_len();
    HEAD + PROGRESS + numbers + rest + CHECKSUM
}

/// A snapshot as bytes, little endian, without pointers:
/// magic, version, length, fingerprint, progress, slopes, past, context, checksum.
pub(super) fn to_bytes(snapshot: &Snapshot, fingerprint: &str) -> Vec<u8> {
    let Progress { phase, stale, sloped, time, experiment } = snapshot.progress;
    let length = byte_len(snapshot);
    let mut bytes = Vec::with_capacity(length);
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&(length as u64).to_le_bytes());
    bytes.extend_from_slice(fingerprint.as_bytes());
    let flag = |on: bool, bit: u8| if on { bit } else { 0 };
    let flags = flag(stale, STALE) | flag(experiment.defined, DEFINED) | flag(sloped, SLOPED);
    bytes.extend_from_slice(&[phase as u8, flags]);
    for number in [time, experiment.start].iter().chain(&snapshot.slopes) {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    bytes.extend_from_slice(&snapshot.past.to_bytes());
    bytes.extend_from_slice(&snapshot.context.to_bytes());
    let sum = model::fnv_64(bytes.iter().copied());
    bytes.extend_from_slice(&sum.to_le_bytes());
    bytes
}

/// The snapshot that [`to_bytes`] wrote, of the same model as the one that is given.
///
/// # Errors
/// What is wrong with the bytes, and the way out.
pub(super) fn from_bytes(
    bytes: &[u8],
    like: &Snapshot,
    fingerprint: &str,
    period: f64,
) -> Result<Snapshot, String> {
    let mut reader = Reader { bytes };
    if reader.take(MAGIC.len()) != Some(MAGIC) {
        return Err("these bytes are no serialised state of this FMU; give those that were \
                    written by it"
            .into());
    }
    let version = reader.take(4).map(|b| u32::from_le_bytes(b.try_into().unwrap_or_default()));
    if version != Some(VERSION) {
        return Err(format!(
            "the serialised state has layout version {}, this FMU reads {VERSION}; serialise it \
             with this FMU",
            version.unwrap_or(0)
        ));
    }
    let length = reader.word().unwrap_or(0);
    let complete = usize::try_from(length).ok().and_then(|length| bytes.get(..length));
    let Some((body, sum)) = complete.and_then(|complete| complete.split_last_chunk::<CHECKSUM>())
    else {
        return Err(format!(
            "the serialised state is cut: it had {length} bytes, {} are given",
            bytes.len()
        ));
    };
    if model::fnv_64(body.iter().copied()) != u64::from_le_bytes(*sum) {
        return Err("the serialised state is damaged: its checksum is wrong".into());
    }
    let written = reader.take(fingerprint.len()).unwrap_or_default();
    if written != fingerprint.as_bytes() {
        return Err(format!(
            "the serialised state belongs to another model: its GUID is \"{}\", this FMU's \
             \"{fingerprint}\"",
            String::from_utf8_lossy(written)
        ));
    }
    let end = body.len();
    reader.bytes = &body[end.min(HEAD)..];
    reader
        .snapshot(like)
        .filter(|snapshot| snapshot.is_consistent(period))
        .ok_or_else(|| "the serialised state does not fit this model; it may be damaged".into())
}

struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, tail) = self.bytes.split_at_checked(count)?;
        self.bytes = tail;
        Some(head)
    }

    fn word(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }

    fn number(&mut self) -> Option<f64> {
        self.word().map(f64::from_bits)
    }

    fn snapshot(&mut self, like: &Snapshot) -> Option<Snapshot> {
        let [phase, flags] = *self.take(2)? else { return None };
        let [time, start] = [self.number()?, self.number()?];
        let slopes = like.slopes.iter().map(|_| self.number()).collect::<Option<Vec<_>>>()?;
        let progress = Progress {
            phase: Phase::from_number(phase)?,
            stale: flags & STALE != 0,
            sloped: flags & SLOPED != 0,
            time,
            experiment: Experiment { defined: flags & DEFINED != 0, start, stop: f64::INFINITY },
        };
        let past = like.past.with_bytes(self.take(like.past.byte_len())?)?;
        let context = like.context.with_bytes(self.bytes).ok()?;
        Some(Snapshot { progress, slopes, past, context })
    }
}
