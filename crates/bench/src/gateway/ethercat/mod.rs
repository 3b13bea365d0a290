//! EtherCAT: a segment of SubDevices as the machine, over [ethercrab](https://docs.rs/ethercrab).
//!
//! Its thread is that of [`DeviceGateway`]: each command becomes one frame (LRW), each answer holds the
//! positions of that frame.

mod segment;
mod wire;

use std::sync::mpsc;
use std::time::Duration;

pub use wire::{RawSocket, Wire};

use self::segment::Segment;
use super::csp::{Drive, MODE};
use super::device::{Device, DeviceGateway, Exchanged};
use super::process_data::{DeviceData, ProcessData};
use super::{Gateway, GatewayError};

/// The runner's end of the bridge to a segment.
#[derive(Debug)]
pub struct EthercatGateway {
    bridge: DeviceGateway,
    devices: Vec<DeviceData>,
}

impl EthercatGateway {
    /// Brings the segment at an interface into the state OP. `safe`: commands before the first.
    ///
    /// # Errors
    /// The interface cannot be opened, the SubDevices do not come up, or do not have what the
    /// process data say.
    pub fn open(interface: &str, data: &ProcessData, safe: &[f64]) -> Result<Self, GatewayError> {
        Self::over(Box::new(RawSocket::open(interface)?), interface, data, safe)
    }

    /// Finds the SubDevices on any wire; `name` is what messages call it.
    ///
    /// # Errors
    /// [`GatewayError::Open`] where the SubDevices do not come up or do not fit the process data.
    pub fn over(
        wire: Box<dyn Wire>,
        name: &str,
        data: &ProcessData,
        safe: &[f64],
    ) -> Result<Self, GatewayError> {
        let data = data.clone();
        let heartbeat = heartbeat(&data);
        let (sender, receiver) = mpsc::channel();
        let bridge = DeviceGateway::open(
            &format!("ethercat://{name}"),
            "check cable, power and [ethercat] in the plan",
            safe,
            heartbeat,
            move || -> Result<Box<dyn Device>, String> {
                let device = SegmentDevice::open(wire, data)?;
                let devices = device.segment.as_ref().map(|segment| segment.devices().to_vec());
                let _ = sender.send(devices.unwrap_or_default());
                Ok(Box::new(device))
            },
        )?;
        let devices = receiver.try_recv().unwrap_or_default();
        Ok(EthercatGateway { bridge, devices })
    }

    /// The SubDevices, in the order of the segment.
    #[must_use]
    pub fn devices(&self) -> &[DeviceData] {
        &self.devices
    }
}

impl Gateway for EthercatGateway {
    fn send(&mut self, packet: &[u8]) -> bool {
        self.bridge.send(packet)
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        self.bridge.receive(buffer)
    }

    fn wait(&mut self, timeout: Duration) {
        self.bridge.wait(timeout);
    }
}

fn heartbeat(data: &ProcessData) -> Duration {
    Duration::from_secs_f64(data.heartbeat.unwrap_or(0.1))
}

/// A segment and where its channels stand.
struct SegmentDevice {
    /// None once it is closed.
    segment: Option<Segment>,
    data: ProcessData,
    /// One for each channel, and where it was when it began to follow; those that are no drives stay as they are.
    drives: Vec<(Drive, f64)>,
}

impl SegmentDevice {
    fn open(wire: Box<dyn Wire>, data: ProcessData) -> Result<Self, String> {
        let segment = Segment::open(wire)?;
        let missing = data.missing(segment.devices());
        if !missing.is_empty() {
            segment.close();
            return Err(missing.join("; "));
        }
        let drives = vec![(Drive::default(), 0.0); data.channels.len()];
        Ok(SegmentDevice { segment: Some(segment), data, drives })
    }
}

impl Device for SegmentDevice {
    fn exchange(&mut self, enabled: bool, commands: &[f64], positions: &mut [f64]) -> Exchanged {
        let Some(segment) = &mut self.segment else { return Exchanged::Nothing };
        let mut are_on = true;
        let channels = self.data.channels.iter().zip(&mut self.drives);
        for ((channel, (drive, start)), command) in channels.zip(commands) {
            let output = &channel.output;
            let mut target = *command;
            if let Some(csp) = &channel.csp {
                // As the last exchange brought them.
                let (status, mode, position) = segment
                    .inputs(channel.input.device, |bytes| {
                        let word = bytes.get(csp.statusword..).and_then(|b| b.first_chunk::<2>());
                        let status = word.map_or(0, |word| u16::from_le_bytes(*word));
                        let mode = csp.mode_display.map(|at| bytes.get(at).map_or(0, |b| *b as i8));
                        (status, mode, channel.input.read(bytes))
                    })
                    .unwrap_or_default();
                let turn = drive.turn(enabled, status, mode);
                are_on &= turn.powered;
                if !turn.follows {
                    *start = position.unwrap_or(*command);
                }
                target = *start + turn.share * (command - *start);
                segment.outputs(output.device, |bytes| {
                    let word = bytes.get_mut(csp.controlword..).and_then(|b| b.first_chunk_mut());
                    if let Some(word) = word {
                        *word = turn.controlword.to_le_bytes();
                    }
                    if let Some(byte) = csp.mode.and_then(|at| bytes.get_mut(at)) {
                        *byte = MODE as u8;
                    }
                });
            }
            segment.outputs(output.device, |bytes| output.write(target, bytes));
        }
        if let Some(enable) = &self.data.enable {
            segment.outputs(enable.device, |bytes| enable.write(enabled, bytes));
        }
        // A frame that does not come back is a sample that is lost; the next one must not wait long.
        let limit = heartbeat(&self.data) / 4;
        let Ok(exchanged) = segment.exchange(limit) else { return Exchanged::Nothing };
        let mut valid = exchanged.complete;
        for (channel, position) in self.data.channels.iter().zip(positions) {
            let input = &channel.input;
            let found = segment.inputs(input.device, |bytes| input.read(bytes)).flatten();
            valid &= found.is_some();
            *position = found.unwrap_or(*position);
        }
        let is_on = |bit: super::process_data::Bit| {
            segment.inputs(bit.device, |bytes| bit.read(bytes)).unwrap_or(false)
        };
        let powered = self.data.powered.is_none_or(is_on);
        Exchanged::Sample { valid, powered: powered && are_on && exchanged.operational }
    }

    fn close(&mut self) {
        if let Some(segment) = self.segment.take() {
            segment.close();
        }
    }
}
