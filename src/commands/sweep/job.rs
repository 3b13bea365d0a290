//! A sweep that is ready to run: its design, its columns, and who does the work.

use sweep::{About, Cell, Column, ColumnKind, Design, Kind, Row, Worker};

use super::campaign::CampaignRuns;
use super::materials::Materials;
use super::signals::SignalRuns;

/// A sweep that is ready to run.
pub(super) struct Job {
    pub(super) design: Design,
    pub(super) columns: Vec<Column>,
    pub(super) fingerprint: String,
    text: String,
    runs: Runs,
}

enum Runs {
    Signals(Box<SignalRuns>),
    Campaign(Box<CampaignRuns>),
}

impl Job {
    /// Sets everything up once and says what is wrong. With an isolation each FMU runs in a process
    /// of its own.
    pub(super) fn new(
        materials: &Materials,
        isolation: Option<cosim::Worker>,
    ) -> anyhow::Result<Self> {
        let plan = materials.plan()?;
        let stage = materials.lay()?;
        let text = plan.text.clone();
        let (runs, design) = match plan.kind {
            Kind::Loop(_) | Kind::System(_) => {
                let runs = SignalRuns::new(stage, plan.clone(), isolation)?;
                let design = Design::new(&plan, &runs.targets()?)?;
                (Runs::Signals(Box::new(runs)), design)
            }
            Kind::Identify(_) | Kind::Diagnose(_) => {
                let runs = CampaignRuns::new(stage, plan.clone())?;
                let design = Design::new(&plan, &runs.targets()?)?;
                (Runs::Campaign(Box::new(runs)), design)
            }
        };
        let results = match &runs {
            Runs::Signals(signals) => signals.columns(&design)?,
            Runs::Campaign(campaign) => campaign.columns(),
        };
        let mut columns = design.columns();
        columns.extend(results);
        columns.push(Column::new("error", ColumnKind::Text, None));
        let taken = |at: usize| columns[..at].iter().any(|other| other.name == columns[at].name);
        if let Some(at) = (0..columns.len()).find(|&at| columns[at].name == "run" || taken(at)) {
            anyhow::bail!(
                "{}: two columns of the results would be called \"{}\"; give the figure another name",
                plan.origin.display(),
                columns[at].name
            );
        }
        let fingerprint = materials.fingerprint()?;
        Ok(Job { design, columns, fingerprint, text, runs })
    }

    /// What the table of these runs says about itself.
    pub(super) fn about(&self, part: &std::ops::Range<u64>) -> About {
        About {
            fingerprint: self.fingerprint.clone(),
            runs: self.design.runs(),
            first: part.start,
            end: part.end,
            plan: self.text.clone(),
            tool: format!("Piezoloop {}", crate::VERSION),
            columns: self.columns.clone(),
            varied: self.design.variables().len(),
        }
    }

    /// A worker for one thread.
    pub(super) fn hire(&self) -> anyhow::Result<Box<dyn Worker + '_>> {
        Ok(match &self.runs {
            Runs::Signals(runs) => Box::new(runs.hire(&self.design)?),
            Runs::Campaign(runs) => Box::new(runs.hire(&self.design)),
        })
    }

    /// A row of another program, if it has the shape of this sweep's.
    pub(super) fn takes(&self, row: &Row) -> bool {
        let fits =
            |(cell, column): (&Cell, &Column)| cell.kind().is_none_or(|kind| kind == column.kind);
        row.run < self.design.runs()
            && row.cells.len() == self.columns.len()
            && row.cells.iter().zip(&self.columns).all(fits)
    }
}
