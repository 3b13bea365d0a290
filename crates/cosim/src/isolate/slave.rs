//! A slave in another process.

use std::ffi::OsString;
use std::io;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use fmi_bindings::import::{Experiment, HOST, Message, Status, StepResult};
use modeldescription::{FmiVersion, ModelDescription, Package};

use super::protocol::{Answer, Request, receive, received, send};
use crate::error::Error;
use crate::slave::{Selection, Settings, Slave, StateId, Value};

#[cfg(unix)]
type Socket = std::os::unix::net::UnixStream;
#[cfg(not(unix))]
type Socket = std::net::TcpStream;

/// How long a worker may take to free its FMU, besides its timeout.
const LONGEST_END: Duration = Duration::from_secs(5);

/// How workers are started.
#[derive(Clone, Debug)]
pub struct Worker {
    /// The program, which must come to [`serve`](super::serve) when it is started with the arguments.
    pub program: PathBuf,
    /// The worker's arguments.
    pub arguments: Vec<OsString>,
    /// A call that takes longer ends the process.
    pub timeout: Duration,
    /// Most memory for data that a process may have, in bytes; none: as much as there is. An FMU that asks
    /// for more gets none, upon which most crash.
    pub memory: Option<u64>,
}

impl Worker {
    /// This program, with this argument.
    ///
    /// # Errors
    /// If the operating system does not tell which program this is.
    pub fn this_program(argument: &str, timeout: Duration) -> std::io::Result<Self> {
        let program = std::env::current_exe()?;
        Ok(Worker { program, arguments: vec![argument.into()], timeout, memory: None })
    }
}

/// A slave whose FMU runs in a worker.
pub(crate) struct IsolatedSlave {
    settings: Settings,
    description: Arc<ModelDescription>,
    socket: Option<Socket>,
    child: Child,
    timeout: Duration,
    memory: Option<u64>,
    /// Selections that the worker knows, by their numbers.
    selections: Vec<Selection>,
    /// Why nothing can be asked any more.
    ended: Option<String>,
    /// The worker reads the unpacked folder.
    _package: Arc<Package>,
}

impl IsolatedSlave {
    pub(crate) fn new(
        worker: &Worker,
        description: Arc<ModelDescription>,
        package: Arc<Package>,
        settings: Settings,
    ) -> Result<Self, Error> {
        let failed = |error: io::Error| Error::NoProcess {
            fmu: settings.name.clone(),
            program: worker.program.clone(),
            error: numerics::threads::refused(error),
        };
        let (socket, child) = start(worker).map_err(failed)?;
        let folder = package.folder().to_string_lossy().into_owned();
        let Settings { name, visible, logging_on, structure, .. } = settings.clone();
        let memory = worker.memory;
        let mut slave = IsolatedSlave {
            settings,
            description,
            socket: Some(socket),
            child,
            timeout: worker.timeout,
            memory,
            selections: Vec::new(),
            ended: None,
            _package: package,
        };
        let open = Request::Open { folder, name, visible, logging_on, structure, memory };
        slave.done("Instantiate", &open)?;
        Ok(slave)
    }

    /// Name of a call as the standard has it.
    fn call_name(&self, call: &str) -> String {
        match (self.description.fmi_version, call) {
            (FmiVersion::V2, call) => format!("fmi2{call}"),
            (FmiVersion::V3, "Instantiate") => "fmi3InstantiateCoSimulation".to_owned(),
            (FmiVersion::V3, call) => format!("fmi3{call}"),
        }
    }

    fn ended(&self, what: &str) -> Error {
        Error::Lost(format!("FMU `{}`: {what}", self.settings.name))
    }

    fn ask(&mut self, call: &str, request: &Request) -> Result<Answer, Error> {
        self.post(call, request)?;
        let begin = Instant::now();
        let mut is_shorter = false;
        loop {
            let Some(socket) = &mut self.socket else { return Err(self.gone(call, None)) };
            match receive(socket) {
                Ok(Answer::Message { status, category, text }) => {
                    if let Some(on_message) = &self.settings.on_message {
                        on_message(&received(status, category, text));
                    }
                    // However much it says meanwhile, the call has its time and no more.
                    let left = self.timeout.saturating_sub(begin.elapsed());
                    is_shorter = true;
                    if left.is_zero() || socket.set_read_timeout(Some(left)).is_err() {
                        return Err(self.gone(call, Some(io::ErrorKind::TimedOut.into())));
                    }
                }
                Ok(answer) => {
                    if is_shorter {
                        // Sockets that cannot be set have just been refused.
                        let _ = socket.set_read_timeout(Some(self.timeout));
                    }
                    match answer {
                        Answer::Failed(text) => return Err(Error::Worker(text)),
                        answer => return Ok(answer),
                    }
                }
                Err(error) => return Err(self.gone(call, Some(error))),
            }
        }
    }

    /// Sends without waiting.
    fn post(&mut self, call: &str, request: &Request) -> Result<(), Error> {
        if let Some(why) = &self.ended {
            return Err(self.ended(why));
        }
        let Some(socket) = &mut self.socket else { return Err(self.gone(call, None)) };
        send(socket, request).map_err(|error| self.gone(call, Some(error)))
    }

    fn done(&mut self, call: &str, request: &Request) -> Result<(), Error> {
        match self.ask(call, request)? {
            Answer::Done => Ok(()),
            other => Err(self.odd(call, &other)),
        }
    }

    fn odd(&self, call: &str, answer: &Answer) -> Error {
        let call = self.call_name(call);
        Error::Worker(format!("FMU `{}`: {call} was answered by {answer:?}", self.settings.name))
    }

    /// The worker has crashed, or does not answer.
    #[cold]
    fn gone(&mut self, call: &str, error: Option<io::Error>) -> Error {
        use io::ErrorKind::{TimedOut, WouldBlock};
        self.socket = None;
        let call = self.call_name(call);
        let silent = error.as_ref().is_some_and(|e| matches!(e.kind(), TimedOut | WouldBlock));
        let child = &mut self.child;
        let what = if silent {
            let _ = child.kill();
            let _ = child.wait();
            format!(
                "{call} has not returned within {} s; its process was ended. If the FMU needs \
                 longer, allow it a longer time",
                self.timeout.as_secs_f64()
            )
        } else {
            let status = waited(child, LONGEST_END).map_or_else(
                || "it was ended".to_owned(),
                |status| format!("its process ended with {status}"),
            );
            let limit = self.memory.map_or_else(String::new, |bytes| {
                let megabytes = bytes as f64 / 1e6;
                format!(
                    ". It may have asked for more memory than the {megabytes} MB that it is allowed; \
                     if it needs more, allow it more"
                )
            });
            format!("{call} has not returned, because the FMU crashed: {status}{limit}")
        };
        self.ended = Some(what.clone());
        self.ended(&what)
    }

    /// The number under which the worker knows a selection.
    fn number(&mut self, selection: &Selection) -> Result<u32, Error> {
        if let Some(number) = self.selections.iter().position(|known| known == selection) {
            return Ok(number as u32);
        }
        self.done("GetVersion", &Request::Select(selection.names().to_vec()))?;
        self.selections.push(selection.clone());
        Ok((self.selections.len() - 1) as u32)
    }
}

/// Starts the worker, with one end of a socket pair as its standard input.
#[cfg(unix)]
fn start(worker: &Worker) -> io::Result<(Socket, Child)> {
    use std::os::fd::{AsFd, OwnedFd};
    let (ours, theirs) = Socket::pair()?;
    ours.set_read_timeout(Some(worker.timeout))?;
    ours.set_write_timeout(Some(worker.timeout))?;
    let child = Command::new(&worker.program)
        .args(&worker.arguments)
        .stdin(Stdio::from(OwnedFd::from(theirs)))
        // The record may go to our standard output, so the FMU's chatter does not.
        .stdout(Stdio::from(io::stderr().as_fd().try_clone_to_owned()?))
        .spawn()?;
    Ok((ours, child))
}

#[cfg(not(unix))]
fn start(_: &Worker) -> io::Result<(Socket, Child)> {
    let _ = (Command::new(""), Stdio::null());
    Err(io::Error::other(
        "FMUs in processes of their own need sockets between processes as Unix has them; run them in \
         this process, without isolation",
    ))
}

impl IsolatedSlave {
    /// Asks for nothing more, hears what the FMU says while it is freed, and whether it was.
    fn is_freed(&mut self, longest: Duration) -> bool {
        let begin = Instant::now();
        let Some(socket) = &mut self.socket else { return false };
        if socket.shutdown(std::net::Shutdown::Write).is_err() {
            return false;
        }
        loop {
            let left = longest.saturating_sub(begin.elapsed());
            if left.is_zero() || socket.set_read_timeout(Some(left)).is_err() {
                return false;
            }
            match receive(socket) {
                Ok(Answer::Message { status, category, text }) => {
                    if let Some(on_message) = &self.settings.on_message {
                        on_message(&received(status, category, text));
                    }
                }
                Ok(answer) => return matches!(answer, Answer::Done),
                Err(_) => return false,
            }
        }
    }
}

/// The exit status, if the process ends in time; else it is killed.
fn waited(child: &mut Child, longest: Duration) -> Option<std::process::ExitStatus> {
    let begin = Instant::now();
    while begin.elapsed() < longest {
        if let Ok(Some(status)) = child.try_wait() {
            return Some(status);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let _ = child.kill();
    let _ = child.wait();
    None
}

impl Drop for IsolatedSlave {
    /// Hangs up, upon which the worker frees the FMU, says so and ends. One that does not end well is
    /// told of.
    fn drop(&mut self) {
        let longest = LONGEST_END.min(self.timeout);
        let freed = self.is_freed(longest);
        self.socket = None;
        let status = waited(&mut self.child, longest);
        let how = match status {
            Some(status) if status.success() && freed => return,
            Some(status) => format!("crashed: its process ended with {status}"),
            None => format!("has not returned within {} s and was ended", longest.as_secs_f64()),
        };
        if let (None, Some(on_message)) = (&self.ended, &self.settings.on_message) {
            let text = format!("{} {how}", self.call_name("FreeInstance"));
            on_message(&Message { status: Status::Warning, category: HOST.to_owned(), text });
        }
    }
}

impl Slave for IsolatedSlave {
    fn name(&self) -> &str {
        &self.settings.name
    }

    fn description(&self) -> &ModelDescription {
        &self.description
    }

    fn setup(&mut self, experiment: &Experiment) -> Result<(), Error> {
        let Experiment { start, stop, tolerance } = *experiment;
        self.done("SetupExperiment", &Request::Setup { start, stop, tolerance })
    }

    fn enter_initialization(&mut self) -> Result<(), Error> {
        self.done("EnterInitializationMode", &Request::EnterInitialization)
    }

    fn exit_initialization(&mut self) -> Result<(), Error> {
        self.done("ExitInitializationMode", &Request::ExitInitialization)
    }

    fn set_start(&mut self, variable: &str, value: &Value) -> Result<(), Error> {
        self.done("Set…", &Request::SetStart(variable.to_owned(), value.clone()))
    }

    fn value(&mut self, variable: &str) -> Result<Value, Error> {
        match self.ask("Get…", &Request::Value(variable.to_owned()))? {
            Answer::Value(value) => Ok(value),
            other => Err(self.odd("Get…", &other)),
        }
    }

    fn set(&mut self, selection: &Selection, values: &[f64]) -> Result<(), Error> {
        let number = self.number(selection)?;
        self.post("Set…", &Request::Set(number, values.to_vec()))
    }

    fn get(&mut self, selection: &Selection, values: &mut [f64]) -> Result<(), Error> {
        let number = self.number(selection)?;
        match self.ask("Get…", &Request::Get(number))? {
            Answer::Values(found) if found.len() == values.len() => {
                values.copy_from_slice(&found);
                Ok(())
            }
            other => Err(self.odd("Get…", &other)),
        }
    }

    fn step(&mut self, time: f64, step: f64) -> Result<StepResult, Error> {
        match self.ask("DoStep", &Request::Step(time, step))? {
            Answer::Done => Ok(StepResult::Completed),
            Answer::Discarded { reached, terminated } => {
                Ok(StepResult::Discarded { reached, terminated })
            }
            other => Err(self.odd("DoStep", &other)),
        }
    }

    fn terminate(&mut self) -> Result<(), Error> {
        self.done("Terminate", &Request::Terminate)
    }

    fn reset(&mut self) -> Result<(), Error> {
        self.done("Reset", &Request::Reset)
    }

    fn save(&mut self, reuse: Option<StateId>) -> Result<StateId, Error> {
        let reuse = reuse.map(|StateId(state)| state);
        match self.ask("GetFMUState", &Request::Save(reuse))? {
            Answer::State(state) => Ok(StateId(state)),
            other => Err(self.odd("GetFMUState", &other)),
        }
    }

    fn restore(&mut self, StateId(state): StateId) -> Result<(), Error> {
        self.done("SetFMUState", &Request::Restore(state))
    }

    fn forget(&mut self, StateId(state): StateId) -> Result<(), Error> {
        self.done("FreeFMUState", &Request::Forget(state))
    }

    fn serialize(&mut self, StateId(state): StateId) -> Result<Vec<u8>, Error> {
        match self.ask("SerializeFMUState", &Request::Serialize(state))? {
            Answer::Bytes(bytes) => Ok(bytes),
            other => Err(self.odd("SerializeFMUState", &other)),
        }
    }

    fn deserialize(&mut self, bytes: &[u8]) -> Result<StateId, Error> {
        match self.ask("DeserializeFMUState", &Request::Deserialize(bytes.to_vec()))? {
            Answer::State(state) => Ok(StateId(state)),
            other => Err(self.odd("DeserializeFMUState", &other)),
        }
    }
}
