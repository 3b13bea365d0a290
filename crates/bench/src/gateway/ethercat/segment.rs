//! A segment of SubDevices, brought into the state OP and exchanged with, over ethercrab.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};
use std::time::{Duration, Instant};

use ethercrab::error::Error;
use ethercrab::subdevice_group::Op;
use ethercrab::{
    DefaultLock, MainDevice, MainDeviceConfig, PduRx, PduStorage, PduTx, SubDeviceGroup,
    SubDeviceState, Timeouts,
};

use super::super::process_data::DeviceData;
use super::wire::{MAX_FRAME, Wire};

/// Most SubDevices of a segment; ethercrab wants a power of two.
const MOST_DEVICES: usize = 64;
/// Most bytes of process data: one frame.
const MOST_DATA: usize = 1100;
/// Frames at once.
const FRAMES: usize = 16;
/// Longest bring-up, and longest way back.
const BRING_UP: Duration = Duration::from_secs(60);
/// Longest sleep between two looks at timers.
const LOOK: Duration = Duration::from_millis(1);

type Storage = PduStorage<FRAMES, { PduStorage::element_size(MOST_DATA) }>;
type Group = SubDeviceGroup<MOST_DEVICES, MOST_DATA, DefaultLock, Op>;

/// The wire and ethercrab's ends of it.
struct Link {
    tx: PduTx<'static>,
    rx: PduRx<'static>,
    wire: Box<dyn Wire>,
    frame: [u8; MAX_FRAME],
}

/// A segment in the state OP.
pub(super) struct Segment {
    link: Link,
    main: &'static MainDevice<'static>,
    group: Group,
    devices: Vec<DeviceData>,
    /// Sum of the working counters when every SubDevice takes part.
    expected: u16,
}

/// What came of one exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Exchanged {
    /// Every SubDevice took part.
    pub(super) complete: bool,
    /// Every SubDevice is in the state OP.
    pub(super) operational: bool,
}

impl Link {
    /// Runs a future of ethercrab to its end, and carries its frames meanwhile; gives it up after
    /// `limit`.
    fn run<T>(
        &mut self,
        future: impl Future<Output = Result<T, Error>>,
        limit: Duration,
    ) -> Result<T, String> {
        let mut future = pin!(future);
        let mut context = Context::from_waker(Waker::noop());
        let begin = Instant::now();
        while begin.elapsed() < limit {
            if let Poll::Ready(done) = future.as_mut().poll(&mut context) {
                return done.map_err(|error| error.to_string());
            }
            let sent = self.send()?;
            let wait = if sent { LOOK } else { LOOK / 10 };
            let received = self.wire.receive(&mut self.frame, wait);
            if let Some(length) = received.map_err(|error| error.to_string())? {
                // A frame that nobody waits for any more, or that is none of EtherCAT.
                let _ = self.rx.receive_frame(&self.frame[..length]);
            }
        }
        Err(format!("no answer within {} ms", limit.as_millis()))
    }

    fn send(&mut self) -> Result<bool, String> {
        let mut sent = false;
        while let Some(frame) = self.tx.next_sendable_frame() {
            let wire = &mut self.wire;
            let mut trouble = None;
            let done = frame.send_blocking(|bytes| match wire.send(bytes) {
                Ok(()) => Ok(bytes.len()),
                Err(error) => {
                    trouble = Some(error.to_string());
                    Err(Error::SendFrame)
                }
            });
            if let Err(error) = done {
                return Err(trouble.unwrap_or_else(|| error.to_string()));
            }
            sent = true;
        }
        Ok(sent)
    }
}

impl Segment {
    /// Finds the SubDevices and brings them into the state OP.
    ///
    /// # Errors
    /// In words: nobody answers, or a SubDevice does not do as it is told.
    pub(super) fn open(wire: Box<dyn Wire>) -> Result<Self, String> {
        // ethercrab borrows both for as long as frames may come: for good.
        let storage: &'static Storage = Box::leak(Box::new(Storage::new()));
        let (tx, rx, pdus) =
            storage.try_split().map_err(|()| "the frames' storage is taken".to_owned())?;
        // Distributed clocks are not used: the runner's clock is the only one.
        let config = MainDeviceConfig { dc_static_sync_iterations: 0, ..Default::default() };
        // Generous: bring-up has time, and an exchange has its own limit.
        let timeouts = Timeouts {
            pdu: Duration::from_millis(500),
            eeprom: Duration::from_secs(5),
            wait_loop_delay: LOOK,
            ..Timeouts::default()
        };
        let main: &'static MainDevice<'static> =
            Box::leak(Box::new(MainDevice::new(pdus, timeouts, config)));
        let mut link = Link { tx, rx, wire, frame: [0; MAX_FRAME] };
        let group = link
            .run(main.init_single_group::<MOST_DEVICES, MOST_DATA>(|| 0), BRING_UP)
            .map_err(|error| format!("finding the SubDevices: {error}"))?;
        if group.is_empty() {
            return Err("no SubDevice answers; check cable and power".to_owned());
        }
        let group = link
            .run(group.into_op(main), BRING_UP)
            .map_err(|error| format!("going to the state OP: {error}"))?;
        let devices: Vec<DeviceData> = group
            .iter(main)
            .map(|device| DeviceData {
                name: device.name().to_owned(),
                outputs: device.io_raw().outputs().len(),
                inputs: device.io_raw().inputs().len(),
            })
            .collect();
        // ETG.1000.4: a logical read-write counts 1 for a read and 2 for a write.
        let counts =
            |device: &DeviceData| u16::from(device.inputs > 0) + 2 * u16::from(device.outputs > 0);
        let expected = devices.iter().map(counts).sum();
        Ok(Segment { link, main, group, devices, expected })
    }

    /// The SubDevices in the order of the segment.
    pub(super) fn devices(&self) -> &[DeviceData] {
        &self.devices
    }

    /// Works on the outputs of a SubDevice; they leave with the next exchange.
    pub(super) fn outputs(&self, device: usize, write: impl FnOnce(&mut [u8])) {
        if let Ok(device) = self.group.subdevice(self.main, device) {
            write(&mut device.outputs_raw_mut());
        }
    }

    /// Looks at the inputs of a SubDevice as the last exchange brought them.
    pub(super) fn inputs<T>(&self, device: usize, read: impl FnOnce(&[u8]) -> T) -> Option<T> {
        let device = self.group.subdevice(self.main, device).ok()?;
        Some(read(&device.inputs_raw()))
    }

    /// Sends all outputs, and takes all inputs.
    ///
    /// # Errors
    /// In words: the frame did not leave, or did not come back within `limit`.
    pub(super) fn exchange(&mut self, limit: Duration) -> Result<Exchanged, String> {
        let answer = self.link.run(self.group.tx_rx(self.main), limit)?;
        let is_op = |state: &SubDeviceState| *state == SubDeviceState::Op;
        Ok(Exchanged {
            complete: answer.working_counter == self.expected,
            operational: answer.subdevice_states.iter().all(is_op),
        })
    }

    /// Leaves the state OP, so that every SubDevice goes to its own safe outputs.
    pub(super) fn close(mut self) {
        // What does not answer any more has its own watchdog.
        let _ = self.link.run(self.group.into_safe_op(self.main), BRING_UP);
    }
}
