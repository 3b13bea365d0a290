//! `piezoloop bench run`: the controller FMU in real time.

use std::io::{self, Write};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use bench::clock::Realtime;
use bench::gateway::{Address, End, Refused, Site};
use bench::live::{Dashboard, Terminal, Web};
use bench::plan::{AxisPlan, Plan, Prepared, Step};
use bench::record::{About, Converted, Format, Journal, Recorder, convert};
use bench::runner::{Outcome, Percentiles, SharedOrders};
use clap::Args;
use cli::{Answer, PageOptions, Screen};
use report::Report;
use serde::Serialize;

use super::{KeyOptions, journal_of};
use crate::pages::{self, Rows};
use crate::{fmus, ranges};

/// Runs a controller FMU in real time with a machine, and records it
///
/// The machine answers over the gateway. Ctrl-C, SIGTERM and every fault ramp the command to its safe value; the
/// third Ctrl-C ends the run immediately. Exit code 0: the plan has ended or the run was stopped; 1: a fault.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop bench run controller.fmu --gateway udp://10.0.0.2:9000 --bind 10.0.0.1:9001 --rate 10k --reference ref.csv --record run.parquet\n  piezoloop bench run --plan bench.toml --live\n  piezoloop bench run --plan identify.toml --record measured.csv --web 8000"
)]
pub(crate) struct Run {
    /// The controller FMU [default: the plan's; without one, the plan's sequence is the command]
    controller: Option<PathBuf>,
    /// A bench plan (TOML); options on the command line override it
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    #[arg(long, value_name = "ADDRESS", value_parser = super::address, help = gateway_help())]
    gateway: Option<Address>,
    /// Own address, for a machine on another computer [default: 127.0.0.1 and the next port]
    #[arg(long, value_name = "IP:PORT")]
    bind: Option<SocketAddr>,
    #[command(flatten)]
    key: KeyOptions,
    /// Cycles per second, as in 10k
    #[arg(long, value_name = "HZ", value_parser = ranges::rate())]
    rate: Option<f64>,
    /// A log with the columns reference[i] to follow, after the plan's sequence
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
    /// Record of the run: .parquet, .csv or .mf4
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Limits of all commands that have none in the plan
    #[arg(long, value_name = "MIN..MAX", value_parser = ranges::limits())]
    command_limits: Option<[f64; 2]>,
    /// Show the run on the terminal
    #[arg(long)]
    live: bool,
    /// Show the run on a page at 127.0.0.1:PORT; 0: a free port
    #[arg(long, value_name = "PORT", value_parser = ranges::integers(0, u16::MAX))]
    web: Option<u16>,
    /// Processor for the cycle's thread [default: any]
    #[arg(long, value_name = "N", value_parser = ranges::count(0, 1023))]
    cpu: Option<usize>,
    #[command(flatten)]
    page: PageOptions,
}

/// Newest rows that a page shows.
const PAGE_ROWS: usize = 1_000_000;

/// Rows that wait for the recorder: this many seconds.
const RING_SECONDS: f64 = 2.0;

/// What came of it.
#[derive(Serialize)]
struct Ran {
    #[serde(flatten)]
    outcome: Outcome,
    realtime: Realtime,
    /// What the machine's driver says about itself.
    machine: Option<String>,
    record: Option<Converted>,
    notes: Vec<String>,
    /// What the page shows.
    #[serde(skip)]
    rows: Option<Rows>,
}

/// The help of `--gateway`.
fn gateway_help() -> String {
    format!("Address of the machine: {}", super::alternatives(&Address::forms(End::Runner)))
}

impl Run {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        self.page.can_write()?;
        let ran = self.execute(screen)?;
        self.page.finish(screen, &ran, || self.report(&ran))
    }

    fn report(&self, ran: &Ran) -> anyhow::Result<Report> {
        let files = [
            ("controller", &self.controller),
            ("plan", &self.plan),
            ("reference", &self.reference),
        ];
        let read: Vec<(&str, &Path)> = files
            .iter()
            .filter_map(|(role, file)| Some((*role, file.as_deref()?)))
            .filter(|(_, file)| file.exists())
            .collect();
        let provenance = pages::provenance(&read)?.remark("clock", ran.realtime.line.to_string());
        let rows = ran.rows.as_ref().context("no row was recorded")?;
        Ok(pages::bench_run(&ran.outcome, rows, provenance))
    }

    fn execute(&self, screen: &Screen) -> anyhow::Result<Ran> {
        let orders = SharedOrders::default();
        let given = orders.clone();
        cli::interrupt::hand_over(move |_| given.interrupt())?;
        let plan = self.plan()?;
        let address = self.address(&plan)?;
        let record = self.record.clone().or_else(|| plan.record.as_ref().map(|f| plan.beside(f)));
        let format = record.as_deref().map(Format::of).transpose().map_err(anyhow::Error::msg)?;
        let file = self
            .controller
            .clone()
            .or_else(|| plan.controller.as_ref().map(|file| plan.beside(file)));
        let opened = file.as_deref().map(fmus::open).transpose()?;
        let packed = file.as_deref().filter(|file| file.exists());
        let mut prepared = plan.prepare(opened.as_ref().map(|opened| &opened.fmu), packed)?;
        for note in &prepared.notes {
            screen.say(&format!("note: {note}"));
        }
        // Without a record the page has a journal of its own.
        let folder = match (self.page.is_asked(), &record) {
            (true, None) => Some(tempfile::tempdir().context("no temporary folder can be made")?),
            _ => None,
        };
        let own = folder.as_ref().map(|folder| folder.path().join("run"));
        let journal = self.journal(&prepared, record.as_deref().or(own.as_deref()))?;
        let mut without_rows = WithoutRows(record.as_deref().map(journal_of));
        let depth = (RING_SECONDS * 1e9 / prepared.settings.period_ns as f64).max(16.0) as usize;
        let (recorder, mut ring) = Recorder::start(journal, prepared.columns.len(), depth)
            .map_err(numerics::threads::refused)?;
        let dashboard = Dashboard::new(&prepared.columns);
        let web = match self.web {
            Some(port) => Some(Web::start(dashboard.clone(), recorder.view().clone(), port)?),
            None => None,
        };
        let terminal = (self.live && !screen.json && !screen.quiet)
            .then(|| Terminal::start(dashboard, recorder.view().clone(), orders.clone()))
            .transpose()
            .map_err(numerics::threads::refused)?;
        let site = Site {
            safe: prepared.cycle.limits().iter().map(|axis| axis.safe).collect(),
            period: prepared.settings.period_ns as f64 / 1e9,
            ethercat: plan.ethercat.as_ref(),
        };
        let gateway = bench::gateway::open(&address, End::Runner, self.bind.or(plan.bind), &site)?;
        let machine = gateway.describe();
        let (mut gateway, keyed) =
            self.key.protect(gateway, &address, End::Runner, prepared.cycle.axes())?;
        // Last of all: threads that are started later would inherit it.
        let realtime = bench::clock::become_realtime();
        if let Some(cpu) = self.cpu {
            bench::clock::pin(cpu)
                .with_context(|| format!("--cpu {cpu}: there is no such processor"))?;
        }
        if terminal.is_none() {
            keyed.iter().for_each(|line| screen.say(line));
            machine.iter().for_each(|line| screen.say(&format!("at {address}: {line}")));
            say_what_begins(screen, &address, &prepared, &realtime, web.as_ref());
        }
        without_rows.0 = None;
        let Prepared { cycle, settings, .. } = &mut prepared;
        let outcome = bench::runner::run(cycle, &mut *gateway, &orders, settings, &mut ring);
        if let Some(terminal) = terminal {
            terminal.finish();
        }
        let recorded = recorder.finish()?;
        let mut notes = prepared.notes;
        notes.extend(outcome.notes());
        let rows = match &recorded.journal {
            Some(journal) if self.page.is_asked() => Some(Rows::newest(journal, PAGE_ROWS)?),
            _ => None,
        };
        let record = match (recorded.journal, record, format) {
            (Some(journal), Some(record), Some(format)) => {
                let more = serde_json::json!({
                    "outcome": outcome,
                    "realtime": realtime,
                    "machine": machine,
                    "notes": notes,
                });
                Some(keep(&journal, &record, format, more)?)
            }
            _ => None,
        };
        if let Some(web) = web {
            web.finish();
        }
        Ok(Ran { outcome, realtime, machine, record, notes, rows })
    }

    /// The plan with what the command line says.
    fn plan(&self) -> anyhow::Result<Plan> {
        let mut plan = match &self.plan {
            Some(file) => Plan::read(file)?,
            None => Plan::default(),
        };
        plan.rate = self.rate.or(plan.rate);
        if let Some(reference) = &self.reference {
            // Given here, it is relative to here.
            let file = std::path::absolute(reference)
                .with_context(|| format!("{}: is no path", reference.display()))?;
            plan.sequence.push(Step::Log { file });
        }
        if let Some(limits) = self.command_limits {
            plan.axes.iter_mut().for_each(|axis| {
                axis.command_limits.get_or_insert(limits);
            });
            plan.other_axes = AxisPlan { command_limits: Some(limits), ..AxisPlan::default() };
        }
        if let Some(address) = &self.gateway {
            plan.gateway = Some(address.to_string());
        }
        Ok(plan)
    }

    fn address(&self, plan: &Plan) -> anyhow::Result<Address> {
        match (&self.gateway, &plan.gateway) {
            (Some(address), _) => Ok(address.clone()),
            (None, Some(text)) => Ok(text.parse()?),
            (None, None) => bail!(
                "no gateway is given; say where the machine is with --gateway udp://IP:PORT or gateway = \"…\" in the plan"
            ),
        }
    }

    fn journal(
        &self,
        prepared: &Prepared,
        record: Option<&Path>,
    ) -> anyhow::Result<Option<Journal>> {
        let Some(record) = record else { return Ok(None) };
        cli::can_write(record)?;
        let path = journal_of(record);
        if path.exists() {
            bail!(
                "{} is there: an earlier run was killed; make a log of it with `piezoloop bench recover {}`, or delete it",
                path.display(),
                path.display()
            );
        }
        let columns = prepared.columns.clone();
        let about = About { columns, provenance: prepared.provenance.clone() };
        Ok(Some(Journal::create(&path, &about)?))
    }
}

/// The journal of a run that has not begun; dropped, as where the machine is not there, it is removed.
struct WithoutRows(Option<PathBuf>);

impl Drop for WithoutRows {
    fn drop(&mut self) {
        if let Some(journal) = self.0.take() {
            // The next run says that it is there.
            let _ = std::fs::remove_file(journal);
        }
    }
}

/// Makes the record of the journal, and deletes the journal.
fn keep(
    journal: &Path,
    record: &Path,
    format: Format,
    more: serde_json::Value,
) -> anyhow::Result<Converted> {
    let more = more.as_object().cloned().unwrap_or_default();
    let converted = convert(journal, record, format, &more)
        .with_context(|| format!("the rows are safe in {}", journal.display()))?;
    std::fs::remove_file(journal)
        .with_context(|| format!("{} cannot be deleted", journal.display()))?;
    Ok(converted)
}

fn say_what_begins(
    screen: &Screen,
    address: &Address,
    prepared: &Prepared,
    realtime: &Realtime,
    web: Option<&Web>,
) {
    // Periods are whole ns.
    let rate = (1e12 / prepared.settings.period_ns as f64).round() / 1e3;
    screen.say(&realtime.line.to_string());
    screen.say(&format!(
        "machine {address}: {} axes, {rate} cycles per second, {:.3} s are played",
        prepared.cycle.axes(),
        prepared.seconds
    ));
    if let Some(web) = web {
        screen.say(&format!("live page: {}", web.url()));
    }
}

impl Answer for Ran {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let outcome = &self.outcome;
        writeln!(out, "ended in the state {}: {}", outcome.state, outcome.reason)?;
        if !outcome.at_rest {
            let why =
                "the command was not at its safe value yet: a third interruption ended the run";
            writeln!(out, "  {why}")?;
        }
        if let Some(failure) = &outcome.failure {
            writeln!(out, "  the controller said: {failure}")?;
        }
        if let Some(failure) = &outcome.gateway_failure {
            writeln!(out, "  the gateway said: {failure}")?;
        }
        if let Some(refused) = &outcome.refused {
            writeln!(out, "  packets were refused: {refused}")?;
        }
        writeln!(
            out,
            "{} cycles, {} overruns, {} deadlines missed, {} commands limited, {} not sent",
            outcome.cycles, outcome.overruns, outcome.skipped, outcome.clipped, outcome.unsent
        )?;
        let m = &outcome.measurements;
        writeln!(
            out,
            "samples: {} used, {} lost, {} late, {} duplicate, {} reordered, {} corrupt, {} mismatched, {} not finite, {} invalid",
            m.used,
            m.lost,
            m.late,
            m.duplicate,
            m.reordered,
            m.corrupt,
            m.mismatched,
            m.not_finite,
            m.invalid
        )?;
        if let Some(Refused { forged, replayed }) = outcome.keyed {
            writeln!(
                out,
                "key: {forged} packets without a right tag, {replayed} of another run or come before"
            )?;
        }
        writeln!(
            out,
            "{:12}{:>10}{:>10}{:>10}{:>10}{:>10}",
            "us", "p50", "p99", "p99.9", "p99.99", "max"
        )?;
        for (name, p) in [
            ("wake-up", outcome.wake),
            ("work", outcome.work),
            ("processor", outcome.processor),
            ("round trip", outcome.round_trip),
        ] {
            let Percentiles { p50_us, p99_us, p999_us, p9999_us, max_us, .. } = p;
            writeln!(
                out,
                "{name:12}{p50_us:>10.1}{p99_us:>10.1}{p999_us:>10.1}{p9999_us:>10.1}{max_us:>10.1}"
            )?;
        }
        // Those of the plan were said before it ran.
        outcome.notes().iter().try_for_each(|note| writeln!(out, "note: {note}"))?;
        match &self.record {
            Some(record) => {
                writeln!(out, "{}: written, {} rows", record.file.display(), record.rows)
            }
            None => Ok(()),
        }
    }

    fn exit_code(&self) -> u8 {
        u8::from(!self.outcome.is_good())
    }
}
