//! The worker: loads an FMU and answers the master's requests.

use std::io;

/// Serves the master that started this process, until it hangs up. A program calls this when it is
/// started with the arguments of its [`Worker`](super::Worker).
///
/// # Errors
/// If standard input is no socket of a master, or the connection breaks.
#[cfg(unix)]
pub fn serve() -> io::Result<()> {
    use std::os::fd::AsFd;
    let socket = std::os::unix::net::UnixStream::from(io::stdin().as_fd().try_clone_to_owned()?);
    end_with_parent();
    unix::Server::new(socket)?.run()
}

/// Isolation is offered on Unix only.
///
/// # Errors
/// Always.
#[cfg(not(unix))]
pub fn serve() -> io::Result<()> {
    Err(io::Error::other(
        "FMUs in processes of their own need sockets between processes as Unix has them; run them in \
         the master's process",
    ))
}

/// A worker whose FMU hangs does not outlive a master that was killed.
#[cfg(unix)]
fn end_with_parent() {
    use std::os::unix::process::parent_id;
    let parent = parent_id();
    // Where the system gives no thread for it, the FMU runs all the same; a master that ends hangs up.
    let _ = std::thread::Builder::new().spawn(move || {
        while parent_id() == parent {
            std::thread::sleep(std::time::Duration::from_millis(500));
        }
        std::process::exit(1);
    });
}

#[cfg(unix)]
mod unix {
    use std::io;
    use std::os::unix::net::UnixStream;
    use std::sync::{Arc, Mutex, PoisonError};

    use fmi_bindings::import::{Experiment, Message};

    use crate::error::Error;
    use crate::fmu::{Fmu, InstanceOptions};
    use crate::isolate::protocol::{Answer, Request, receive, send};
    use crate::slave::{Selection, Slave, StateId};

    pub(super) struct Server {
        requests: UnixStream,
        /// Shared with the FMU's logger, which may speak at any time.
        answers: Arc<Mutex<UnixStream>>,
        slave: Option<Box<dyn Slave>>,
        selections: Vec<Selection>,
        /// Of a request that is not answered.
        late: Option<Error>,
    }

    /// Of what this process asks for from now on.
    fn limit(memory: Option<u64>) -> Result<(), Error> {
        use rustix::process::{Resource, Rlimit, setrlimit};
        let Some(memory) = memory else { return Ok(()) };
        // On Linux private memory that can be written; address space that is only reserved does not count.
        let limit = Rlimit { current: Some(memory), maximum: Some(memory) };
        setrlimit(Resource::Data, limit).map_err(|error| {
            Error::Worker(format!("memory cannot be limited to {memory} bytes: {error}"))
        })
    }

    impl Server {
        pub(super) fn new(socket: UnixStream) -> io::Result<Server> {
            Ok(Server {
                requests: socket.try_clone()?,
                answers: Arc::new(Mutex::new(socket)),
                slave: None,
                selections: Vec::new(),
                late: None,
            })
        }

        pub(super) fn run(&mut self) -> io::Result<()> {
            loop {
                let request = match receive(&mut self.requests) {
                    Ok(request) => request,
                    Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                        self.slave = None;
                        let mut answers =
                            self.answers.lock().unwrap_or_else(PoisonError::into_inner);
                        // A master that was killed hears nothing more.
                        let _ = send(&mut *answers, &Answer::Done);
                        return Ok(());
                    }
                    Err(error) => return Err(error),
                };
                if let Request::Set(selection, values) = request {
                    let outcome = self.set(selection, &values);
                    self.late = self.late.take().or(outcome.err());
                    continue;
                }
                let outcome = match self.late.take() {
                    Some(late) => Err(late),
                    None => self.answer(request),
                };
                let answer = outcome.unwrap_or_else(|error| Answer::Failed(error.to_string()));
                let mut answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
                send(&mut *answers, &answer)?;
            }
        }

        fn slave(&mut self) -> Result<&mut dyn Slave, Error> {
            match &mut self.slave {
                Some(slave) => Ok(&mut **slave),
                None => Err(Error::Worker("the worker has not opened an FMU".to_owned())),
            }
        }

        fn selection(&self, number: u32) -> Result<Selection, Error> {
            let found = self.selections.get(number as usize).cloned();
            found.ok_or_else(|| Error::Worker(format!("there is no selection {number}")))
        }

        fn set(&mut self, selection: u32, values: &[f64]) -> Result<(), Error> {
            let selection = self.selection(selection)?;
            self.slave()?.set(&selection, values)
        }

        fn answer(&mut self, request: Request) -> Result<Answer, Error> {
            match request {
                Request::Open { folder, name, visible, logging_on, structure, memory } => {
                    limit(memory)?;
                    let mut fmu = Fmu::open(folder)?;
                    fmu.configure(&structure)?;
                    self.open(&fmu, &name, visible, logging_on)?;
                }
                Request::Setup { start, stop, tolerance } => {
                    self.slave()?.setup(&Experiment { start, stop, tolerance })?;
                }
                Request::EnterInitialization => self.slave()?.enter_initialization()?,
                Request::ExitInitialization => self.slave()?.exit_initialization()?,
                Request::SetStart(variable, value) => self.slave()?.set_start(&variable, &value)?,
                Request::Value(variable) => {
                    return Ok(Answer::Value(self.slave()?.value(&variable)?));
                }
                Request::Select(names) => {
                    let selection = Selection::of(self.slave()?.description(), &names)?;
                    self.selections.push(selection);
                }
                // Not answered, see `run`.
                Request::Set(..) => {}
                Request::Get(selection) => {
                    let selection = self.selection(selection)?;
                    let mut values = vec![0.0; selection.len()];
                    self.slave()?.get(&selection, &mut values)?;
                    return Ok(Answer::Values(values));
                }
                Request::Step(time, step) => {
                    return Ok(Answer::step(self.slave()?.step(time, step)?));
                }
                Request::Terminate => self.slave()?.terminate()?,
                Request::Reset => self.slave()?.reset()?,
                Request::Save(reuse) => {
                    let StateId(state) = self.slave()?.save(reuse.map(StateId))?;
                    return Ok(Answer::State(state));
                }
                Request::Restore(state) => self.slave()?.restore(StateId(state))?,
                Request::Forget(state) => self.slave()?.forget(StateId(state))?,
                Request::Serialize(state) => {
                    return Ok(Answer::Bytes(self.slave()?.serialize(StateId(state))?));
                }
                Request::Deserialize(bytes) => {
                    let StateId(state) = self.slave()?.deserialize(&bytes)?;
                    return Ok(Answer::State(state));
                }
            }
            Ok(Answer::Done)
        }

        fn open(
            &mut self,
            fmu: &Fmu,
            name: &str,
            visible: bool,
            logging_on: bool,
        ) -> Result<(), Error> {
            let answers = Arc::clone(&self.answers);
            let forward = move |message: &Message| {
                let mut answers = answers.lock().unwrap_or_else(PoisonError::into_inner);
                // A master that has gone hears nothing more.
                let _ = send(&mut *answers, &Answer::message(message));
            };
            let on_message: Option<fmi_bindings::import::OnMessage> = Some(Arc::new(forward));
            let options = InstanceOptions { visible, logging_on, on_message };
            self.slave = Some(fmu.instantiate(name, &options)?);
            Ok(())
        }
    }
}
