//! An EtherCAT segment in memory: SubDevices after ETG.1000.4 (registers, SII EEPROM, sync managers,
//! FMMUs), as far as terminals without a mailbox need it.

use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use bench::gateway::ethercat::Wire;

const AL_CONTROL: usize = 0x120;
const AL_STATUS: usize = 0x130;
const SII_CONTROL: usize = 0x502;
const SII_DATA: usize = 0x508;
const FMMU: usize = 0x600;
const OUTPUTS: usize = 0x1100;
const INPUTS: usize = 0x1180;
const OP: u8 = 8;

/// One SubDevice.
#[derive(Clone, Debug)]
pub struct SubDevice {
    memory: Vec<u8>,
    eeprom: Vec<u8>,
    outputs: usize,
    inputs: usize,
}

fn category(kind: u16, mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.resize(bytes.len().next_multiple_of(2), 0);
    let mut all = kind.to_le_bytes().to_vec();
    all.extend((bytes.len() as u16 / 2).to_le_bytes());
    all.extend(bytes);
    all
}

/// One process data object of this many bytes, for a sync manager.
fn object(index: u16, bytes: usize, sync_manager: u8) -> Vec<u8> {
    let mut all = index.to_le_bytes().to_vec();
    all.extend([bytes as u8, sync_manager, 0, 0, 0, 0]);
    for byte in 0..bytes {
        all.extend([0x00, 0x60, byte as u8, 0, 5, 8, 0, 0]);
    }
    all
}

impl SubDevice {
    /// A SubDevice with so many bytes of outputs and of inputs.
    pub fn new(name: &str, outputs: usize, inputs: usize) -> Self {
        let mut memory = vec![0; 0x1200];
        // FMMUs, sync managers; port 0 has a link.
        (memory[4], memory[5], memory[0x110]) = (2, 2, 0x30);
        memory[AL_STATUS] = 1;
        let mut eeprom = vec![0; 0x80];
        eeprom[0x10..0x14].copy_from_slice(&2u32.to_le_bytes());
        let mut strings = vec![1, name.len() as u8];
        strings.extend(name.bytes());
        let mut general = vec![0; 32];
        general[2] = 1;
        eeprom.extend(category(10, strings));
        eeprom.extend(category(30, general));
        let sync_manager = |start: usize, length: usize, control: u8, kind: u8| {
            let mut all = (start as u16).to_le_bytes().to_vec();
            all.extend((length as u16).to_le_bytes());
            all.extend([control, 0, u8::from(length > 0), kind]);
            all
        };
        eeprom.extend(category(40, vec![1, 2]));
        let mut managers = sync_manager(OUTPUTS, outputs, 0x64, 3);
        managers.extend(sync_manager(INPUTS, inputs, 0x20, 4));
        eeprom.extend(category(41, managers));
        if inputs > 0 {
            eeprom.extend(category(50, object(0x1a00, inputs, 1)));
        }
        if outputs > 0 {
            eeprom.extend(category(51, object(0x1600, outputs, 0)));
        }
        eeprom.extend([0xff, 0xff, 0, 0]);
        SubDevice { memory, eeprom, outputs, inputs }
    }

    pub fn outputs(&self) -> &[u8] {
        &self.memory[OUTPUTS..OUTPUTS + self.outputs]
    }

    pub fn inputs(&mut self) -> &mut [u8] {
        &mut self.memory[INPUTS..INPUTS + self.inputs]
    }

    /// Whether it is in the state OP.
    pub fn is_operational(&self) -> bool {
        self.memory[AL_STATUS] == OP
    }

    /// Falls out of the state OP, as after a broken cable.
    pub fn fall(&mut self) {
        self.memory[AL_STATUS] = 4;
    }

    fn station(&self) -> u16 {
        u16::from_le_bytes([self.memory[0x10], self.memory[0x11]])
    }

    fn read(&self, address: usize, data: &mut [u8], or: bool) {
        for (byte, at) in data.iter_mut().zip(address..) {
            let own = self.memory.get(at).copied().unwrap_or(0);
            *byte = if or { *byte | own } else { own };
        }
    }

    fn write(&mut self, address: usize, data: &[u8]) {
        for (byte, at) in data.iter().zip(address..) {
            if let Some(own) = self.memory.get_mut(at) {
                *own = *byte;
            }
        }
        let touches = |register: usize| (address..address + data.len()).contains(&register);
        if touches(AL_CONTROL) {
            self.memory[AL_STATUS] = self.memory[AL_CONTROL] & 0x0f;
        }
        if touches(SII_CONTROL + 1) && self.memory[SII_CONTROL + 1] & 1 == 1 {
            let word = u16::from_le_bytes([self.memory[0x504], self.memory[0x505]]);
            for byte in 0..4 {
                let at = 2 * usize::from(word) + byte;
                self.memory[SII_DATA + byte] = self.eeprom.get(at).copied().unwrap_or(0xff);
            }
            self.memory[SII_CONTROL..SII_CONTROL + 2].fill(0);
        }
    }

    /// A logical read, write or both; what it adds to the working counter.
    fn logical(&mut self, address: u32, data: &mut [u8], reads: bool, writes: bool) -> u16 {
        let (mut read, mut wrote) = (false, false);
        for fmmu in 0..2 {
            let entry = &self.memory[FMMU + 16 * fmmu..FMMU + 16 * fmmu + 16];
            let start = u32::from_le_bytes(entry[0..4].try_into().unwrap());
            let length = usize::from(u16::from_le_bytes(entry[4..6].try_into().unwrap()));
            let physical = usize::from(u16::from_le_bytes(entry[8..10].try_into().unwrap()));
            let (kind, enabled) = (entry[11], entry[12] & 1 == 1);
            for offset in (0..length).filter(|_| enabled) {
                let place = (start as usize + offset).checked_sub(address as usize);
                let Some(byte) = place.and_then(|place| data.get_mut(place)) else { continue };
                if kind & 2 != 0 && writes {
                    self.memory[physical + offset] = *byte;
                    wrote = true;
                }
                if kind & 1 != 0 && reads {
                    *byte = self.memory[physical + offset];
                    read = true;
                }
            }
        }
        u16::from(read) + if reads { 2 * u16::from(wrote) } else { u16::from(wrote) }
    }

    /// One datagram passes.
    fn pass(&mut self, command: u8, address: &mut u32, data: &mut [u8], counter: &mut u16) {
        let offset = (*address >> 16) as usize;
        let position = *address as u16;
        let here = match command {
            1..=3 => position == 0,
            4..=6 => position == self.station(),
            7..=9 => true,
            _ => false,
        };
        if matches!(command, 1..=3 | 7..=9) {
            *address = (*address & 0xffff_0000) | u32::from(position.wrapping_add(1));
        }
        match command {
            1 | 4 | 7 if here => {
                self.read(offset, data, command == 7);
                *counter += 1;
            }
            2 | 5 | 8 if here => {
                self.write(offset, data);
                *counter += 1;
            }
            10 => *counter += self.logical(*address, data, true, false),
            11 => *counter += self.logical(*address, data, false, true),
            12 => *counter += self.logical(*address, data, true, true),
            _ => {}
        }
    }
}

/// What the SubDevices do when a frame has passed.
pub type Behaviour = Box<dyn FnMut(&mut [SubDevice]) + Send>;

/// A ring of SubDevices at one wire.
pub struct Ring {
    pub devices: Vec<SubDevice>,
    pub behaviour: Behaviour,
}

impl Ring {
    /// The frame as it comes back.
    pub fn turn(&mut self, sent: &[u8]) -> Vec<u8> {
        let mut frame = sent.to_vec();
        // The first SubDevice marks the frame as one that comes back.
        frame[6] |= 2;
        let end = 16 + (usize::from(u16::from_le_bytes([frame[14], frame[15]])) & 0x7ff);
        let mut at = 16;
        while at + 12 <= end {
            let flags = u16::from_le_bytes([frame[at + 6], frame[at + 7]]);
            let length = usize::from(flags & 0x7ff);
            let command = frame[at];
            let mut address = u32::from_le_bytes(frame[at + 2..at + 6].try_into().unwrap());
            let data = at + 10..at + 10 + length;
            let place = data.end;
            let mut counter = u16::from_le_bytes([frame[place], frame[place + 1]]);
            for device in &mut self.devices {
                device.pass(command, &mut address, &mut frame[data.clone()], &mut counter);
            }
            frame[at + 2..at + 6].copy_from_slice(&address.to_le_bytes());
            frame[place..place + 2].copy_from_slice(&counter.to_le_bytes());
            at = place + 2;
        }
        (self.behaviour)(&mut self.devices);
        frame
    }
}

/// Frames as they were sent and as they came back.
pub type Exchanges = Vec<(Vec<u8>, Vec<u8>)>;

/// A wire to a ring in memory; what goes over it is written down: sent, returned.
#[derive(Clone)]
pub struct MemoryWire {
    pub ring: Arc<Mutex<Ring>>,
    pub recording: Arc<Mutex<Exchanges>>,
    /// Frames that are still to be swallowed.
    pub swallow: Arc<Mutex<u32>>,
    returned: VecDeque<Vec<u8>>,
}

impl MemoryWire {
    pub fn new(devices: Vec<SubDevice>, behaviour: Behaviour) -> Self {
        MemoryWire {
            ring: Arc::new(Mutex::new(Ring { devices, behaviour })),
            recording: Arc::default(),
            swallow: Arc::default(),
            returned: VecDeque::new(),
        }
    }
}

pub fn deliver(
    returned: &mut VecDeque<Vec<u8>>,
    frame: &mut [u8],
    wait: Duration,
) -> Option<usize> {
    let Some(bytes) = returned.pop_front() else {
        std::thread::sleep(wait.min(Duration::from_micros(100)));
        return None;
    };
    frame[..bytes.len()].copy_from_slice(&bytes);
    Some(bytes.len())
}

impl Wire for MemoryWire {
    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        let mut swallow = self.swallow.lock().unwrap();
        if *swallow > 0 {
            *swallow -= 1;
            return Ok(());
        }
        let back = self.ring.lock().unwrap().turn(frame);
        self.recording.lock().unwrap().push((frame.to_vec(), back.clone()));
        self.returned.push_back(back);
        Ok(())
    }

    fn receive(&mut self, frame: &mut [u8], timeout: Duration) -> io::Result<Option<usize>> {
        Ok(deliver(&mut self.returned, frame, timeout))
    }
}
