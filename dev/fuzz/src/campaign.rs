//! Many mutated inputs in this process, on any compiler: what makes a reader say something new is
//! kept and mutated further, the shorter the likelier.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};

use crate::mutate::mutate;
use crate::{Random, Target, corpus};

/// Most memory that reading an input of [`crate::mutate::LONGEST`] bytes may take.
pub const MOST_BYTES: usize = 64 << 20;
/// Longest time of a processor that it may take.
pub const LONGEST: Duration = Duration::from_secs(10);
/// Longest time on the clock, of one that waits for something; a busy machine may let it wait, too.
const LONGEST_WAIT: Duration = Duration::from_secs(600);
/// Inputs that are kept.
const POOL: usize = 4096;

/// What a campaign did.
#[derive(Clone, Debug, Default)]
pub struct Figures {
    /// Inputs that were read.
    pub executions: u64,
    /// Inputs that were accepted.
    pub accepted: u64,
    /// Different behaviours: texts without their numbers and quotations.
    pub behaviours: usize,
    /// Most memory one took, in bytes.
    pub most_bytes: usize,
    /// Longest time of a processor that one took.
    pub longest: Duration,
    /// Time of the campaign.
    pub time: Duration,
}

/// An input that broke the rules.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The input.
    pub input: Vec<u8>,
    /// What happened.
    pub what: String,
}

/// Reads the target's corpus and then mutated inputs, `executions` together; stops at the first
/// that panics or takes more memory than [`MOST_BYTES`]. One that takes longer than [`LONGEST`] ends
/// the program with its input left in the scratch file, since nothing else could stop it.
///
/// The memory is only measured in a program whose allocator is `counting::Counting`.
///
/// # Errors
/// The corpus cannot be read, or the scratch file in `folder` cannot be written.
pub fn run(
    target: &Target,
    executions: u64,
    seed: u64,
    folder: &Path,
) -> io::Result<Result<Figures, Box<Finding>>> {
    let scratch = target.scratch(folder)?;
    let seeds = corpus(target)?;
    let mut pool = Pool::new(seeds.clone());
    let mut random = Random::new(seed);
    let mut figures = Figures::default();
    let mut watch = Watch::new(&target.name, scratch.path());
    let begin = Instant::now();
    while figures.executions < executions {
        let input = match seeds.get(figures.executions as usize) {
            Some(seed) => seed.clone(),
            None => {
                let mut input = pool.draw(&mut random).clone();
                mutate(target.kind, &mut input, pool.draw(&mut random), &mut random);
                input
            }
        };
        let before = counting::reset_peak();
        let started = processor_time(ClockId::ThreadCPUTime);
        watch.begin();
        let message = catch_unwind(AssertUnwindSafe(|| target.run(&input, &scratch)));
        watch.end();
        let took = processor_time(ClockId::ThreadCPUTime).saturating_sub(started);
        let bytes = counting::peak().saturating_sub(before);
        figures.executions += 1;
        figures.longest = figures.longest.max(took);
        figures.most_bytes = figures.most_bytes.max(bytes);
        let message = match message {
            Ok(message) => message?,
            Err(payload) => {
                let text = payload.downcast_ref::<String>().map(String::as_str);
                let text = text.or_else(|| payload.downcast_ref::<&str>().copied());
                let what = format!("panics: {}", text.unwrap_or("without a text"));
                return Ok(Err(Box::new(Finding { input, what })));
            }
        };
        if bytes > MOST_BYTES {
            let what = format!("takes {bytes} bytes, more than {MOST_BYTES}");
            return Ok(Err(Box::new(Finding { input, what })));
        }
        figures.accepted += u64::from(message.is_empty());
        pool.offer(input, behaviour(&message));
    }
    figures.behaviours = pool.seen.len();
    figures.time = begin.elapsed();
    Ok(Ok(figures))
}

/// Inputs that made a reader say something new, the short ones preferred: they are read faster, and a
/// mutation of one is likelier to matter.
struct Pool {
    inputs: Vec<Vec<u8>>,
    /// Where the input of each behaviour is; none where there was no room.
    seen: HashMap<u64, Option<usize>>,
}

impl Pool {
    fn new(inputs: Vec<Vec<u8>>) -> Self {
        Self { inputs, seen: HashMap::new() }
    }

    /// Half of the time any one, else the shorter of two: short inputs are read faster, but only long ones
    /// reach everything; archives that have become short are mostly broken.
    fn draw(&self, random: &mut Random) -> &Vec<u8> {
        let (one, other) = (random.of(&self.inputs), random.of(&self.inputs));
        let is_shorter = other.len() < one.len();
        if is_shorter && random.one_in(2) { other } else { one }
    }

    /// Keeps an input of a new behaviour, or in place of one that is twice as long.
    fn offer(&mut self, input: Vec<u8>, behaviour: u64) {
        match self.seen.entry(behaviour) {
            Entry::Vacant(entry) if self.inputs.len() < POOL => {
                entry.insert(Some(self.inputs.len()));
                self.inputs.push(input);
            }
            Entry::Vacant(entry) => drop(entry.insert(None)),
            Entry::Occupied(entry) => {
                if let Some(at) = *entry.get()
                    && 2 * input.len() <= self.inputs[at].len()
                {
                    self.inputs[at] = input;
                }
            }
        }
    }
}

/// The beginning of a text as a number, without quotations, numbers and names: only what stands between
/// blanks and is all small letters counts.
fn behaviour(message: &str) -> u64 {
    let mut hasher = DefaultHasher::new();
    let outside = message.split('"').step_by(2).flat_map(|part| part.split_ascii_whitespace());
    let is_word = |word: &&str| word.bytes().all(|byte| byte.is_ascii_lowercase());
    outside.filter(is_word).take(60).for_each(|word| word.hash(&mut hasher));
    hasher.finish()
}

/// Time that this thread or this process has had a processor.
fn processor_time(of: ClockId) -> Duration {
    let time = clock_gettime(of);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec.unsigned_abs() as u32)
}

/// Ends the program where one input takes too long.
struct Watch {
    /// Number of the present input from 1; 0: none.
    present: Arc<AtomicU64>,
    count: u64,
}

impl Watch {
    fn new(name: &str, input: &Path) -> Self {
        let present = Arc::new(AtomicU64::new(0));
        let (shared, input) = (Arc::downgrade(&present), input.to_path_buf());
        let name = name.to_owned();
        std::thread::spawn(move || {
            let now = || (processor_time(ClockId::ProcessCPUTime), Instant::now());
            let (mut seen, mut since) = (0, now());
            while let Some(present) = shared.upgrade() {
                let number = present.load(Ordering::Relaxed);
                if number != seen {
                    (seen, since) = (number, now());
                }
                let worked = processor_time(ClockId::ProcessCPUTime).saturating_sub(since.0);
                if seen != 0 && (worked > LONGEST || since.1.elapsed() > LONGEST_WAIT) {
                    // The file goes with its folder where the program ends well, not here.
                    eprintln_hang(&name, &input);
                    std::process::abort();
                }
                drop(present);
                std::thread::sleep(Duration::from_millis(200));
            }
        });
        Self { present, count: 0 }
    }

    fn begin(&mut self) {
        self.count += 1;
        self.present.store(self.count, Ordering::Relaxed);
    }

    fn end(&self) {
        self.present.store(0, Ordering::Relaxed);
    }
}

#[allow(clippy::print_stderr, reason = "the last words of a program that hangs")]
fn eprintln_hang(name: &str, input: &Path) {
    eprintln!("{name}: {} takes longer than {LONGEST:?} of a processor, or waits", input.display());
}
