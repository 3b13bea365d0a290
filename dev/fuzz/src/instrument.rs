//! What instruments, drivers and records of the bench say.

use std::cell::OnceCell;
use std::collections::VecDeque;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use bench::cycle::Driver;
use bench::gateway::device::{Device, Exchanged};
use bench::gateway::gcs::GcsDevice;
use bench::gateway::line::{Line, Options};
use bench::gateway::nv200::Nv200Device;
use bench::gateway::{Address, C_HEADER, PluginDevice};
use bench::record::Recording;
use bench::replay::{Recipe, replay};

/// Stands between what is read one after the other: the sign that separates records.
const BETWEEN: u8 = 0x1e;
const PERIOD: f64 = 1e-3;
/// Exchanges with one machine.
const EXCHANGES: usize = 12;

/// Answers one after the other, whatever was asked; an empty one comes too late, and when all are told, the
/// line is gone.
#[derive(Debug)]
struct Answers(VecDeque<Vec<u8>>);

impl Line for Answers {
    fn open(&mut self, _: Duration) -> Result<(), String> {
        match self.0.is_empty() {
            true => Err("nobody listens".to_owned()),
            false => Ok(()),
        }
    }

    fn write(&mut self, _: &[u8]) -> Result<(), String> {
        Ok(())
    }

    fn read(&mut self, bytes: &mut [u8], _: Duration) -> Result<usize, String> {
        let Some(mut answer) = self.0.pop_front() else {
            return Err("the line is gone".to_owned());
        };
        let length = answer.len().min(bytes.len());
        bytes[..length].copy_from_slice(&answer[..length]);
        if length < answer.len() {
            answer.drain(..length);
            self.0.push_front(answer);
        }
        Ok(length)
    }

    fn close(&mut self) {}
}

/// The options behind an address, which stand in the first line, and the answers.
fn conversation(input: &[u8]) -> Result<(Options, Answers), String> {
    let end = input.iter().position(|byte| *byte == b'\n').unwrap_or(input.len());
    let (first, rest) = input.split_at(end);
    let text = String::from_utf8_lossy(first);
    let options = match text.parse::<Address>() {
        Ok(Address::Instrument { options, .. }) => options,
        Ok(other) => return Err(format!("is the address {other}")),
        Err(error) => return Err(error.to_string()),
    };
    let answers = rest.get(1..).unwrap_or_default().split(|byte| *byte == BETWEEN);
    Ok((Options::parse(&options, PERIOD)?, Answers(answers.map(<[u8]>::to_vec).collect())))
}

/// Plays a run with a device. What a sample of an `instrument` has are numbers; of a driver the runner looks
/// at them.
fn play(mut device: impl Device, axes: usize, is_instrument: bool) -> String {
    let mut described = device.describe().unwrap_or_default();
    for exchange in 0..EXCHANGES {
        let mut positions = vec![f64::NAN; axes];
        let commands: Vec<f64> = (0..axes).map(|axis| (exchange + axis) as f64).collect();
        let exchanged = device.exchange(exchange > 1, &commands, &mut positions);
        let is_sample = matches!(exchanged, Exchanged::Sample { .. });
        let is_finite = positions.iter().all(|position| position.is_finite());
        assert!(!is_instrument || is_finite == is_sample, "{positions:?}");
        match exchanged {
            Exchanged::Sample { valid: true, powered: true } => described += " sample ",
            Exchanged::Sample { .. } => described += " flagged ",
            Exchanged::Nothing => described += " nothing ",
            Exchanged::Failed(text) => described += &text,
        }
    }
    device.close();
    described
}

pub(crate) fn gcs(input: &[u8], _: &Path) -> String {
    let read = conversation(input).and_then(|(options, answers)| {
        let axes = options.axes.len().clamp(1, 4);
        Ok(play(GcsDevice::open(Box::new(answers), options, &vec![0.0; axes])?, axes, true))
    });
    read.unwrap_or_else(|why| why)
}

pub(crate) fn nv200(input: &[u8], _: &Path) -> String {
    let read = conversation(input).and_then(|(options, answers)| {
        Ok(play(Nv200Device::open(Box::new(answers), options, &[0.0])?, 1, true))
    });
    read.unwrap_or_else(|why| why)
}

/// A journal with this description and these numbers, read and replayed; its checksums are right, and
/// sometimes its end is missing.
pub(crate) fn record(input: &[u8], file: &Path) -> String {
    let end = input.iter().position(|byte| *byte == BETWEEN).unwrap_or(input.len());
    let (about, rows) = input.split_at(end);
    let mut bytes = b"PZLJRNL1".to_vec();
    bytes.extend((about.len() as u32).to_le_bytes());
    bytes.extend(about);
    bytes.extend(crc32fast::hash(about).to_le_bytes());
    for block in rows.get(1..).unwrap_or_default().split(|byte| *byte == BETWEEN) {
        let numbers = String::from_utf8_lossy(block);
        let numbers: Vec<f64> =
            numbers.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let mut bare = (numbers.len() as u32).to_le_bytes().to_vec();
        numbers.iter().for_each(|number| bare.extend(number.to_le_bytes()));
        let checksum = crc32fast::hash(&bare);
        bytes.extend(&bare);
        bytes.extend(checksum.to_le_bytes());
    }
    if input.len().is_multiple_of(7) {
        bytes.truncate(bytes.len() - 3);
    }
    if let Err(error) = fs::write(file, &bytes) {
        return error.to_string();
    }
    let recording = match Recording::read(file) {
        Ok(recording) => recording,
        Err(error) => return error.to_string(),
    };
    let Some(text) = recording.about("replay") else { return "has no recipe".into() };
    match Recipe::parse(text).map(|recipe| replay(&recording, &recipe, Driver::Direct)) {
        Ok(Ok(found)) if found.differing == 0 && found.notes.is_empty() => String::new(),
        Ok(Ok(found)) => format!("differs {} {}", found.differing > 0, found.notes.join(" ")),
        Ok(Err(error)) => error.to_string(),
        Err(rule) => rule,
    }
}

/// A driver that does what its options say: `open CODE`, `text TEXT`, then for each exchange `CODE COUNT STATUS`
/// and the positions, each between bars.
const DRIVER: &str = r#"
#include "gateway.h"
#include <stdlib.h>
#include <string.h>
static char script[1 << 15], text[4096]; static char *next; static unsigned n;
static char *part(void) {
    char *at = next, *end = strchr(at, '|');
    if (end) { *end = 0; next = end + 1; } else next = at + strlen(at);
    return at;
}
uint32_t piezoloop_gateway_version(void) { return 1; }
int32_t piezoloop_gateway_open(const char *options, uint32_t channels, double period, void **card) {
    (void)card; (void)period; n = channels;
    strncpy(script, options, sizeof script - 1); next = script;
    long code = strtol(part(), 0, 0);
    strncpy(text, part(), sizeof text - 1);
    return (int32_t)code;
}
int32_t piezoloop_gateway_describe(void *card, char *to, uint32_t size) {
    (void)card; strncpy(to, text, size); return text[0] == '-';
}
int32_t piezoloop_gateway_exchange(void *card, uint32_t enable, const double *commands, double *positions, uint32_t *count, uint32_t *status) {
    (void)card; (void)enable; (void)commands;
    char *at = part();
    long code = strtol(at, &at, 0);
    *count = (uint32_t)strtol(at, &at, 0); *status = (uint32_t)strtol(at, &at, 0);
    for (unsigned i = 0; i < n + 64; i++) {
        char *end; double value = strtod(at, &end);
        if (end == at) break;
        positions[i] = value; at = end;
    }
    return (int32_t)code;
}
const char *piezoloop_gateway_last_error(void *card) { (void)card; return text[0] ? text : 0; }
void piezoloop_gateway_close(void *card) { (void)card; }
"#;

/// The driver, built once; none without a C compiler.
fn library(parent: &Path) -> Option<PathBuf> {
    thread_local! {
        // One that stays open, so that the system keeps the library.
        static HELD: OnceCell<Option<(PathBuf, PluginDevice)>> = const { OnceCell::new() };
    }
    let build = || -> Option<(PathBuf, PluginDevice)> {
        let folder = parent.join("driver");
        fs::create_dir_all(&folder).ok()?;
        fs::write(folder.join("gateway.h"), C_HEADER).ok()?;
        fs::write(folder.join("driver.c"), DRIVER).ok()?;
        let mut compiler = Command::new("cc");
        compiler.args(["-O2", "-shared", "-fPIC", "-o", "driver.so", "driver.c"]);
        compiler.current_dir(&folder).status().ok().filter(|status| status.success())?;
        let library = folder.join("driver.so");
        let held = PluginDevice::open(&library, "0", 1, PERIOD).ok()?;
        Some((library, held))
    };
    HELD.with(|held| held.get_or_init(build).as_ref().map(|(library, _)| library.clone()))
}

/// What is said without a C compiler.
pub const NO_COMPILER: &str = "needs a C compiler `cc`";

pub(crate) fn driver(input: &[u8], file: &Path) -> String {
    let Some(library) = file.parent().and_then(library) else { return NO_COMPILER.into() };
    let options: String = input.iter().map(|byte| *byte as char).collect();
    let axes = 1 + input.len() % 3;
    match PluginDevice::open(&library, &options, axes, PERIOD) {
        Ok(device) => play(device, axes, false),
        Err(why) => why,
    }
}
