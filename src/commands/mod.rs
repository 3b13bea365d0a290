//! One file per command.
use cli::Screen;

mod bench;
mod calibrate;
mod check;
pub(crate) mod demo;
mod diagnose;
mod effects_docs;
pub(crate) mod estimate;
pub(crate) mod frequency_response;
mod gap_bench;
pub(crate) mod identify;
pub(crate) mod invert;
mod list;
mod log;
pub(crate) mod pack;
mod shell;
mod signal;
pub(crate) mod simulate;
mod sweep;
pub(crate) mod system;
pub(crate) mod tune;

/// The command by which the tool starts itself for one FMU.
pub(crate) const WORKER: &str = "fmu-worker";

/// What the tool can do.
#[derive(clap::Subcommand, Debug)]
pub(crate) enum Command {
    Identify(identify::Identify),
    Invert(invert::Invert),
    Calibrate(calibrate::Calibrate),
    FrequencyResponse(frequency_response::FrequencyResponse),
    Tune(tune::Tune),
    Pack(pack::Pack),
    Simulate(simulate::Simulate),
    System(system::System),
    Estimate(Box<estimate::Estimate>),
    Sweep(sweep::Sweep),
    Check(check::Check),
    Bench(bench::Bench),
    List(list::List),
    Log(log::Log),
    Signal(signal::Signal),
    Demo(demo::Demo),
    #[command(hide = true)]
    EffectsDocs(effects_docs::EffectsDocs),
    Diagnose(Box<diagnose::Diagnose>),
    GapBench(gap_bench::GapBench),
    Completions(shell::Completions),
    Man(shell::Man),
    /// Runs one FMU for another process of this tool
    #[command(name = WORKER, hide = true)]
    FmuWorker,
}

impl Command {
    /// Runs the command; the number is the exit code.
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        match self {
            Self::Identify(command) => command.run(screen),
            Self::Invert(command) => command.run(screen),
            Self::Calibrate(command) => command.run(screen),
            Self::FrequencyResponse(command) => command.run(screen),
            Self::Tune(command) => command.run(screen),
            Self::Pack(command) => command.run(screen),
            Self::Simulate(command) => command.run(screen),
            Self::System(command) => command.run(screen),
            Self::Estimate(command) => command.run(screen),
            Self::Sweep(command) => command.run(screen),
            Self::FmuWorker => {
                cosim::isolate::serve()?;
                Ok(0)
            }
            Self::Check(command) => command.run(screen),
            Self::Bench(command) => command.run(screen),
            Self::List(command) => command.run(screen),
            Self::Log(command) => command.run(screen),
            Self::Signal(command) => command.run(screen),
            Self::Demo(command) => command.run(screen),
            Self::EffectsDocs(command) => command.run(screen),
            Self::Diagnose(command) => command.run(screen),
            Self::GapBench(command) => command.run(screen),
            Self::Completions(command) => command.run(screen),
            Self::Man(command) => command.run(screen),
        }
    }
}
