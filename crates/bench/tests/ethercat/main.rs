//! The gateway to an EtherCAT segment: over SubDevices in memory, over their recording, over a
//! recording of real terminals, and over a raw socket.
#![cfg(all(feature = "ethercat", target_os = "linux"))]
#![allow(clippy::print_stdout, unreachable_pub)]

mod recording;
mod segment;

use std::path::PathBuf;
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use bench::gateway::ethercat::{EthercatGateway, RawSocket, Wire};
use bench::gateway::{Address, End, Gateway, ProcessData, Site, open};
use bench::packet::{Header, Kind, MAX_BYTES, Status, decode, encode};

use recording::{Progress, Replay, exchanges, frames_of};
use segment::{MemoryWire, Ring, SubDevice};

/// Two channels of an EL4132-like and an EL3102-like terminal behind a coupler.
const DATA: &str = "heartbeat = 0.2\nenable = { device = 1, byte = 4, bit = 2 }\n\
    powered = { device = 2, byte = 8, bit = 0 }\n\
    [[channel]]\noutput = { device = 1, byte = 0, type = \"i16\", scale = 0.005 }\n\
    input = { device = 2, byte = 0, type = \"i32\", scale = 1e-4, bias = -1.0 }\n\
    [[channel]]\noutput = { device = 1, byte = 2, type = \"i16\", scale = 0.005 }\n\
    input = { device = 2, byte = 4, type = \"f32\" }\n";

fn data() -> ProcessData {
    toml::from_str(DATA).unwrap()
}

fn devices() -> Vec<SubDevice> {
    vec![
        SubDevice::new("EK1100", 0, 0),
        SubDevice::new("EL4132", 5, 0),
        SubDevice::new("EL3102", 0, 9),
    ]
}

/// Positions are a tenth of the volts, in um.
fn follow(devices: &mut [SubDevice]) {
    let outputs = devices[1].outputs().to_vec();
    let volts = |at: usize| f64::from(i16::from_le_bytes([outputs[at], outputs[at + 1]])) * 0.005;
    let inputs = devices[2].inputs();
    inputs[..4].copy_from_slice(&(((0.1 * volts(0) + 1.0) / 1e-4).round() as i32).to_le_bytes());
    inputs[4..8].copy_from_slice(&((0.1 * volts(2)) as f32).to_le_bytes());
    inputs[8] = 1;
}

fn wire() -> MemoryWire {
    MemoryWire::new(devices(), Box::new(follow))
}

fn gateway(wire: impl Wire + 'static) -> EthercatGateway {
    EthercatGateway::over(Box::new(wire), "test", &data(), &[0.0; 2]).unwrap()
}

/// The runner's side of one exchange.
struct Runner {
    gateway: EthercatGateway,
    sequence: u32,
}

impl Runner {
    fn new(gateway: EthercatGateway) -> Self {
        Runner { gateway, sequence: 100 }
    }

    fn say(&mut self, status: Status, values: &[f64]) -> u32 {
        self.sequence += 1;
        let header = Header {
            kind: Kind::Command,
            channels: values.len() as u16,
            sequence: self.sequence,
            status,
            time_ns: u64::from(self.sequence),
            echo_sequence: 0,
            state: 0,
            reason: 0,
            echo_time_ns: 0,
        };
        let mut bytes = [0; MAX_BYTES];
        let length = encode(&header, values, &mut bytes);
        assert!(self.gateway.send(&bytes[..length]));
        self.sequence
    }

    /// The answer to this command; none after a second.
    fn answer(&mut self, sequence: u32, channels: usize) -> Option<(Header, Vec<f64>)> {
        let begin = Instant::now();
        let (mut bytes, mut values) = ([0; MAX_BYTES], vec![0.0; channels]);
        while begin.elapsed() < Duration::from_secs(5) {
            self.gateway.wait(Duration::from_millis(50));
            while let Some(length) = self.gateway.receive(&mut bytes) {
                let header = decode(&bytes[..length], Kind::Measurement, &mut values).unwrap();
                if header.echo_sequence == sequence {
                    return Some((header, values));
                }
            }
        }
        None
    }

    fn exchange(&mut self, status: Status, values: &[f64]) -> (Header, Vec<f64>) {
        let sequence = self.say(status, values);
        self.answer(sequence, values.len()).expect("an answer")
    }
}

const RESTS: Status = Status(0);
const DRIVES: Status = Status::ENABLE;

#[test]
fn commands_reach_their_outputs_and_positions_come_from_their_inputs() {
    let wire = wire();
    let ring = Arc::clone(&wire.ring);
    let gateway = gateway(wire);
    let names: Vec<&str> = gateway.devices().iter().map(|device| device.name.as_str()).collect();
    assert_eq!(names, ["EK1100", "EL4132", "EL3102"]);
    assert_eq!((gateway.devices()[1].outputs, gateway.devices()[2].inputs), (5, 9));
    let mut runner = Runner::new(gateway);
    runner.exchange(RESTS, &[1.0, 2.0]);
    for (first, second) in [(10.0, -20.0), (55.5, 100.0), (0.005, 0.0)] {
        runner.exchange(DRIVES, &[first, second]);
        // The frame that takes the outputs brings the inputs of before.
        let (header, values) = runner.exchange(DRIVES, &[first, second]);
        assert!((values[0] - 0.1 * first).abs() < 1e-4 && (values[1] - 0.1 * second).abs() < 1e-5);
        assert!(header.status.has(Status::POWERED.with(Status::VALID)));
        assert!(!header.status.has(Status::SAFE));
        assert_eq!(header.echo_time_ns, u64::from(header.echo_sequence));
        assert_eq!(ring.lock().unwrap().devices[1].outputs()[4], 1 << 2, "enable");
    }
    drop(runner);
    let ring = ring.lock().unwrap();
    let volts = i16::from_le_bytes([ring.devices[1].outputs()[0], ring.devices[1].outputs()[1]]);
    assert_eq!((volts, ring.devices[1].outputs()[4]), (200, 0), "1 V, the safe value");
    assert!(ring.devices.iter().all(|device| !device.is_operational()));
}

#[test]
fn a_silent_runner_leaves_safe_outputs_until_it_acknowledges() {
    let wire = wire();
    let ring = Arc::clone(&wire.ring);
    let mut runner = Runner::new(gateway(wire));
    runner.exchange(RESTS, &[0.0, 0.0]);
    runner.exchange(DRIVES, &[50.0, 50.0]);
    let volts = |ring: &Mutex<Ring>| ring.lock().unwrap().devices[1].outputs()[0..2].to_vec();
    assert_ne!(volts(&ring), [0, 0]);
    let begin = Instant::now();
    while volts(&ring) != [0, 0] {
        assert!(begin.elapsed() < Duration::from_secs(10), "it never stopped");
        std::thread::sleep(Duration::from_millis(10));
    }
    let (header, _) = runner.exchange(DRIVES, &[50.0, 50.0]);
    assert!(header.status.has(Status::SAFE));
    assert_eq!(volts(&ring), [0, 0], "latched");
    assert!(!runner.exchange(RESTS, &[0.0, 0.0]).0.status.has(Status::SAFE));
    runner.exchange(DRIVES, &[50.0, 50.0]);
    assert_ne!(volts(&ring), [0, 0]);
}

#[test]
fn a_device_that_falls_out_of_op_and_power_that_goes_are_reported() {
    let wire = wire();
    let ring = Arc::clone(&wire.ring);
    let mut runner = Runner::new(gateway(wire));
    assert!(runner.exchange(RESTS, &[0.0, 0.0]).0.status.has(Status::POWERED));
    ring.lock().unwrap().behaviour = Box::new(|devices| {
        follow(devices);
        devices[2].inputs()[8] = 0;
    });
    runner.exchange(RESTS, &[0.0, 0.0]);
    assert!(!runner.exchange(RESTS, &[0.0, 0.0]).0.status.has(Status::POWERED));
    ring.lock().unwrap().behaviour = Box::new(follow);
    ring.lock().unwrap().devices[1].fall();
    runner.exchange(RESTS, &[0.0, 0.0]);
    assert!(!runner.exchange(RESTS, &[0.0, 0.0]).0.status.has(Status::POWERED));
    // A SubDevice that is gone: the working counter is short.
    ring.lock().unwrap().devices.truncate(2);
    ring.lock().unwrap().behaviour = Box::new(|_| {});
    assert!(!runner.exchange(RESTS, &[0.0, 0.0]).0.status.has(Status::VALID));
}

#[test]
fn a_frame_that_is_lost_is_a_sample_that_is_lost() {
    let wire = wire();
    let swallow = Arc::clone(&wire.swallow);
    let mut runner = Runner::new(gateway(wire));
    let (before, _) = runner.exchange(RESTS, &[0.0, 0.0]);
    *swallow.lock().unwrap() = 1;
    let lost = runner.say(RESTS, &[0.0, 0.0]);
    while *swallow.lock().unwrap() > 0 {
        std::thread::sleep(Duration::from_millis(1));
    }
    // Longer than ethercrab waits for a frame.
    std::thread::sleep(Duration::from_millis(100));
    let (after, _) = runner.exchange(RESTS, &[0.0, 0.0]);
    assert!(after.sequence >= before.sequence + 2, "a gap in the sequence");
    assert!(after.echo_sequence > lost);
}

#[test]
fn what_the_segment_does_not_have_is_reported() {
    let open = |wire: MemoryWire, text: &str| {
        let data: ProcessData = toml::from_str(text).unwrap();
        EthercatGateway::over(Box::new(wire), "eth9", &data, &[0.0; 2]).unwrap_err().to_string()
    };
    let message = open(wire(), &DATA.replace("byte = 2, type", "byte = 4, type"));
    for word in ["ethercat://eth9", "channel 2", "EL4132", "5 bytes"] {
        assert!(message.contains(word), "{word}: {message}");
    }
    let message = open(MemoryWire::new(Vec::new(), Box::new(|_| {})), DATA);
    assert!(message.contains("no SubDevice"), "{message}");
    let address: Address = "ethercat://no-such-nic".parse().unwrap();
    let message = |data: Option<&ProcessData>, end: End| {
        open_at(&address, end, data).err().expect("no such interface").to_string()
    };
    assert!(message(Some(&data()), End::Runner).contains("lo"));
    assert!(message(None, End::Runner).contains("[ethercat]"));
    assert!(message(Some(&data()), End::Machine).contains("udp://"));
}

/// A drive that follows CiA 402: controlword, target, mode; statusword, position, mode.
const DRIVE: &str = "[[channel]]\noutput = { device = 0, byte = 2, type = \"i32\", scale = 1e-3 }\n\
    input = { device = 0, byte = 2, type = \"i32\", scale = 1e-3 }\n\
    csp = { controlword = 0, mode = 6, statusword = 0, mode_display = 6 }\n";

/// The drive's state machine as the standard draws it, and every statusword that it told.
fn obeys(controlwords: Arc<Mutex<Vec<u16>>>) -> impl FnMut(&mut [SubDevice]) + Send {
    let (mut status, mut position, mut last) = (0x0250_u16, 5000_i32, 0_u16);
    move |devices| {
        let outputs = devices[0].outputs().to_vec();
        let control = u16::from_le_bytes([outputs[0], outputs[1]]);
        let target = i32::from_le_bytes([outputs[2], outputs[3], outputs[4], outputs[5]]);
        status = match (status & 0x6f, control) {
            (0x28 | 0x08, c) if c & 0x80 != 0 && last & 0x80 == 0 => 0x0250,
            (0x28 | 0x08, _) => status,
            (_, c) if c & 0x02 == 0 => 0x0250,
            (0x50 | 0x40, c) if c & 0x87 == 0x06 => 0x0231,
            (0x21, c) if c & 0x0f == 0x07 => 0x0233,
            (0x23, c) if c & 0x0f == 0x0f => 0x0237,
            (0x27 | 0x23, c) if c & 0x0f == 0x06 => 0x0231,
            _ => status,
        };
        if status == 0x0237 {
            // A drive of this class refuses a jump: following error.
            if (target - position).abs() > 200 {
                status = 0x0218;
            } else {
                position = target;
            }
        }
        last = control;
        controlwords.lock().unwrap().push(status);
        let inputs = devices[0].inputs();
        inputs[..2].copy_from_slice(&status.to_le_bytes());
        inputs[2..6].copy_from_slice(&position.to_le_bytes());
        inputs[6] = outputs[6];
    }
}

#[test]
fn a_drive_in_cyclic_synchronous_position_mode_is_led_and_follows_without_a_jump() {
    let controlwords = Arc::new(Mutex::new(Vec::new()));
    let wire = MemoryWire::new(
        vec![SubDevice::new("E-727", 7, 7)],
        Box::new(obeys(Arc::clone(&controlwords))),
    );
    let ring = Arc::clone(&wire.ring);
    let data: ProcessData = toml::from_str(&format!("heartbeat = 5.0\n{DRIVE}")).unwrap();
    assert!(data.problems(1).is_empty(), "{:?}", data.problems(1));
    let gateway = EthercatGateway::over(Box::new(wire), "test", &data, &[0.0]).unwrap();
    let mut runner = Runner::new(gateway);
    // At rest: ready to switch on, at 5 um.
    for _ in 0..5 {
        let (header, values) = runner.exchange(RESTS, &[0.0]);
        assert!(
            header.status.has(Status::POWERED) && (values[0] - 5.0).abs() < 1e-9
                || values[0] == 0.0
        );
    }
    assert_eq!(*controlwords.lock().unwrap().last().unwrap(), 0x0231, "ready to switch on");
    // Enabled: it comes up, and goes to the command within its take-over.
    let mut positions = Vec::new();
    for _ in 0..160 {
        let (header, values) = runner.exchange(DRIVES, &[12.0]);
        assert!(header.status.has(Status::POWERED.with(Status::VALID)), "{header:?}");
        positions.push(values[0]);
    }
    assert!((positions[159] - 12.0).abs() < 1e-3, "{positions:?}");
    assert!(positions.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.2), "{positions:?}");
    let states: Vec<u16> = {
        let mut all = controlwords.lock().unwrap().clone();
        all.dedup();
        all
    };
    assert!(states.ends_with(&[0x0231, 0x0233, 0x0237]), "{states:x?}");
    assert_eq!(ring.lock().unwrap().devices[0].outputs()[6], 8, "the mode");
    // From there on commands act at once.
    runner.exchange(DRIVES, &[12.1]);
    runner.exchange(DRIVES, &[12.1]);
    assert!((runner.exchange(DRIVES, &[12.1]).1[0] - 12.1).abs() < 1e-3);
    // A jump is a fault of the drive: power is gone until the runner acknowledges without ENABLE.
    for _ in 0..3 {
        runner.exchange(DRIVES, &[50.0]);
    }
    assert!(!runner.exchange(DRIVES, &[50.0]).0.status.has(Status::POWERED));
    for _ in 0..6 {
        runner.exchange(RESTS, &[0.0]);
    }
    assert!(runner.exchange(RESTS, &[0.0]).0.status.has(Status::POWERED), "the fault is reset");
    drop(runner);
    assert!(!ring.lock().unwrap().devices[0].is_operational());
    let bad: ProcessData = toml::from_str(
        &DRIVE.replace("mode = 6", "mode = 3").replace("statusword = 0", "statusword = 6"),
    )
    .unwrap();
    assert!(bad.problems(1)[0].contains("csp mode of channel 1 lies in the output of channel 1"));
    let wire = MemoryWire::new(vec![SubDevice::new("E-727", 7, 7)], Box::new(|_| {}));
    let message =
        EthercatGateway::over(Box::new(wire), "test", &bad, &[0.0]).unwrap_err().to_string();
    assert!(
        message.contains("csp statusword") && message.contains("7 bytes of inputs"),
        "{message}"
    );
}

fn open_at(
    address: &Address,
    end: End,
    data: Option<&ProcessData>,
) -> Result<Box<dyn Gateway>, bench::gateway::GatewayError> {
    open(address, end, None, &Site { ethercat: data, ..Site::default() })
}

/// Commands of a run of 40 cycles; the answers' positions.
fn run(mut runner: Runner) -> Vec<Vec<f64>> {
    runner.exchange(RESTS, &[0.0, 0.0]);
    let drives = (0..40).map(|k| [f64::from(k), 60.0 - f64::from(k)]);
    drives.map(|values| runner.exchange(DRIVES, &values).1).collect()
}

fn replayed(progress: &Mutex<Progress>) -> usize {
    let progress = progress.lock().unwrap();
    assert!(progress.different.is_none(), "{}", progress.different.as_ref().unwrap());
    progress.matched
}

#[test]
fn a_recorded_exchange_is_replayed_by_the_bit() {
    let wire = wire();
    let recording = Arc::clone(&wire.recording);
    let first = run(Runner::new(gateway(wire)));
    let recorded = recording.lock().unwrap().clone();
    let replay = Replay::new(recorded.clone());
    let progress = Arc::clone(&replay.progress);
    assert_eq!(run(Runner::new(gateway(replay))), first);
    // The first segment may have been idle for one frame more or less.
    assert!(replayed(&progress) + 2 >= recorded.len());
    // A recording that differs is noticed.
    let mut other = recorded;
    let outputs = other.iter_mut().rev().find(|(sent, _)| sent[16] == 12).unwrap();
    outputs.0[26] ^= 1;
    let replay = Replay::new(other);
    let progress = Arc::clone(&replay.progress);
    run(Runner::new(gateway(replay)));
    assert!(progress.lock().unwrap().different.is_some());
}

/// A capture that ethercrab brings for its own tests: a coupler EK1100 with the digital outputs
/// EL2828, brought into the state OP and exchanged with 64 times. Every frame of the bring-up must
/// be the recorded one.
#[test]
fn real_terminals_are_brought_up_as_they_were_when_they_were_recorded() {
    let Some(folder) = sources_of("ethercrab") else {
        println!("SKIPPED: the sources of ethercrab are not there");
        return;
    };
    let recorded = exchanges(frames_of(&folder.join("tests/replay-issue-255.pcapng")));
    assert!(recorded.len() > 500, "{}", recorded.len());
    let total = recorded.len();
    let replay = Replay::new(recorded);
    let progress = Arc::clone(&replay.progress);
    // The terminals have no inputs; once they are in OP this is told.
    let text = "[[channel]]\noutput = { device = 1, byte = 0, type = \"u16\" }\n\
                input = { device = 1, byte = 0, type = \"u8\" }\n";
    let data: ProcessData = toml::from_str(text).unwrap();
    let described =
        EthercatGateway::over(Box::new(replay), "test", &data, &[0.0; 2]).unwrap_err().to_string();
    println!("{described}; {} of {total} frames", replayed(&progress));
    assert!(described.contains("EL2828") && described.contains("0 bytes of inputs"), "{described}");
    assert_eq!(replayed(&progress) + 64, total, "all but the exchanges");
}

/// Where cargo has the sources of a package.
fn sources_of(package: &str) -> Option<PathBuf> {
    let output = Command::new(std::env::var_os("CARGO")?)
        .args(["metadata", "--format-version", "1", "--offline", "--all-features"])
        .args(["--filter-platform", "x86_64-unknown-linux-gnu"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .ok()?;
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).ok()?;
    let packages = metadata["packages"].as_array()?;
    let found = packages.iter().find(|one| one["name"] == package)?;
    PathBuf::from(found["manifest_path"].as_str()?).parent().map(PathBuf::from)
}

/// A virtual cable, with the SubDevices in memory at its far end.
#[test]
fn frames_go_through_a_raw_socket() {
    let (near, far) = (
        format!("plb{}a", std::process::id() % 9999),
        format!("plb{}b", std::process::id() % 9999),
    );
    let ip = |arguments: &[&str]| {
        Command::new("ip").args(arguments).output().is_ok_and(|output| output.status.success())
    };
    if !ip(&["link", "add", &near, "type", "veth", "peer", "name", &far]) {
        println!("SKIPPED: no privilege to make a virtual cable (ip link add … type veth)");
        return;
    }
    struct Cable(String);
    impl Drop for Cable {
        fn drop(&mut self) {
            let _ = Command::new("ip").args(["link", "del", &self.0]).output();
        }
    }
    let _cable = Cable(near.clone());
    assert!(ip(&["link", "set", &near, "up"]) && ip(&["link", "set", &far, "up"]));
    let ended = Arc::new(Mutex::new(false));
    let flag = Arc::clone(&ended);
    let mut end = RawSocket::open(&far).unwrap();
    let segment = std::thread::spawn(move || {
        let mut ring = Ring { devices: devices(), behaviour: Box::new(follow) };
        let mut frame = [0; 1518];
        while !*flag.lock().unwrap() {
            // The cable goes when the test ends.
            let Ok(got) = end.receive(&mut frame, Duration::from_millis(20)) else { break };
            // What this end sends comes back to it too, and other frames of the system.
            let Some(length) = got.filter(|n| *n > 16 && frame[12..14] == [0x88, 0xa4]) else {
                continue;
            };
            if frame[6] & 2 == 0 {
                let back = ring.turn(&frame[..length]);
                end.send(&back).unwrap();
            }
        }
    });
    let mut runner = Runner::new(EthercatGateway::open(&near, &data(), &[0.0; 2]).unwrap());
    runner.exchange(RESTS, &[0.0, 0.0]);
    runner.exchange(DRIVES, &[30.0, 40.0]);
    let (_, values) = runner.exchange(DRIVES, &[30.0, 40.0]);
    assert!((values[0] - 3.0).abs() < 1e-3 && (values[1] - 4.0).abs() < 1e-3, "{values:?}");
    drop(runner);
    *ended.lock().unwrap() = true;
    segment.join().unwrap();
}
