//! `guided`: the same readers and mutations, led by the code that inputs reach (libFuzzer).
//!
//! `dev/tools/fuzz` builds it with the compiler's counters of edges and runs it; `PIEZOLOOP_FUZZ` names
//! the reader.
#![no_main]

use std::path::Path;
use std::sync::OnceLock;

use counting::Counting;
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};
use piezoloop_fuzz::campaign::MOST_BYTES;
use piezoloop_fuzz::mutate::{LONGEST, mutate};
use piezoloop_fuzz::{Random, Scratch, Target, corpus};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

struct Reader {
    target: Target,
    scratch: Scratch,
    seeds: Vec<Vec<u8>>,
}

fn reader() -> &'static Reader {
    static READER: OnceLock<Reader> = OnceLock::new();
    READER.get_or_init(|| {
        // libFuzzer's hook ends the program at any panic; readers by others may panic inside ours.
        std::panic::set_hook(Box::new(|_| {}));
        counting::set_limit(4 << 30);
        let name = std::env::var("PIEZOLOOP_FUZZ").unwrap_or_default();
        let target = Target::find(&name).expect("PIEZOLOOP_FUZZ names a reader");
        let folder = Path::new("/dev/shm").join(format!("piezoloop-guided-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for the input");
        tempfile::env::override_temp_dir(&folder).ok();
        let scratch = target.scratch(&folder).expect("a file for the input");
        Reader { target, scratch, seeds: corpus(&target).expect("the corpus") }
    })
}

fuzz_target!(|input: &[u8]| {
    let reader = reader();
    let before = counting::reset_peak();
    let message = std::panic::catch_unwind(|| reader.target.run(input, &reader.scratch));
    let bytes = counting::peak().saturating_sub(before);
    // An abort is what libFuzzer keeps the input of.
    if !message.is_ok_and(|message| message.is_ok()) || bytes > MOST_BYTES {
        std::process::abort();
    }
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let mut random = Random::new(u64::from(seed));
    if random.one_in(3) {
        return fuzzer_mutate(data, size, max_size);
    }
    let reader = reader();
    let mut input = data[..size].to_vec();
    let other: &Vec<u8> = random.of(&reader.seeds);
    mutate(reader.target.kind, &mut input, other, &mut random);
    input.truncate(max_size.min(LONGEST));
    data[..input.len()].copy_from_slice(&input);
    input.len()
});
