//! The terminal display.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use ratatui::Frame;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyModifiers};
use ratatui::layout::{Constraint, Layout};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::Line;
use ratatui::widgets::{Block, Paragraph, Row, Table};

use super::dashboard::Dashboard;
use crate::record::{Latest, View};
use crate::runner::SharedOrders;
use crate::safety::State;

/// Time between two pictures.
const INTERVAL: Duration = Duration::from_millis(100);

/// The display on its own thread; it ends with the run.
#[derive(Debug)]
pub struct Terminal {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<io::Result<()>>,
}

impl Terminal {
    /// Takes over the terminal. `q` and Ctrl-C stop the run, the space bar starts it at once.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(dashboard: Dashboard, view: View, orders: SharedOrders) -> io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let thread =
            std::thread::Builder::new().spawn(move || show(&dashboard, &view, &orders, &flag))?;
        Ok(Terminal { stop, thread })
    }

    /// Gives the terminal back.
    pub fn finish(self) {
        self.stop.store(true, Ordering::Relaxed);
        // A display that failed takes nothing from the run.
        let _ = self.thread.join();
    }
}

fn show(
    dashboard: &Dashboard,
    view: &View,
    orders: &SharedOrders,
    stop: &AtomicBool,
) -> io::Result<()> {
    let mut terminal = ratatui::try_init()?;
    let shown = loop {
        let latest = view.latest();
        if let Err(error) = terminal.draw(|frame| draw(frame, dashboard, &latest)) {
            break Err(error);
        }
        if stop.load(Ordering::Relaxed) {
            break Ok(());
        }
        if event::poll(INTERVAL)?
            && let Event::Key(key) = event::read()?
        {
            let control = key.modifiers.contains(KeyModifiers::CONTROL);
            match key.code {
                KeyCode::Char('q') => orders.stop(),
                KeyCode::Char('c') if control => orders.interrupt(),
                KeyCode::Char(' ') => orders.start(),
                _ => {}
            }
        }
    };
    ratatui::restore();
    shown
}

/// One picture.
pub fn draw(frame: &mut Frame<'_>, dashboard: &Dashboard, latest: &Latest) {
    let axes = dashboard.axes(latest);
    let height = u16::try_from(axes.len()).unwrap_or(u16::MAX).saturating_add(3);
    let parts = Layout::vertical([
        Constraint::Length(3),
        Constraint::Length(height),
        Constraint::Length(6),
        Constraint::Min(0),
    ])
    .split(frame.area());
    frame.render_widget(headline(dashboard, latest), parts[0]);
    let header = Row::new(["axis", "reference", "position", "error", "command"])
        .style(Style::new().add_modifier(Modifier::BOLD));
    let rows = axes.iter().map(|axis| {
        let number = |value: f64, unit: &str| match value.is_nan() {
            true => "-".to_owned(),
            false => format!("{value:.4} {unit}"),
        };
        Row::new([
            axis.name.clone(),
            number(axis.reference, &axis.unit),
            number(axis.position, &axis.unit),
            number(axis.reference - axis.position, &axis.unit),
            number(axis.command, &axis.command_unit),
        ])
    });
    let table = Table::new(rows, [Constraint::Fill(1); 5]).header(header);
    frame.render_widget(table.block(Block::bordered().title("axes")), parts[1]);
    frame.render_widget(link(dashboard, latest), parts[2]);
}

fn headline<'a>(dashboard: &Dashboard, latest: &Latest) -> Paragraph<'a> {
    let Some((state, reason)) = dashboard.state(latest) else {
        return Paragraph::new("waiting for the machine")
            .block(Block::bordered().title("bench (q: stop)"));
    };
    let colour = match state {
        State::Running => Color::Green,
        State::Hold | State::Idle => Color::Yellow,
        State::Fault => Color::Red,
        State::Ready | State::Safe => Color::Cyan,
    };
    let time = latest.row.first().copied().unwrap_or_default();
    let text = format!("{} - {reason}   {time:.2} s", state.name().to_uppercase());
    Paragraph::new(Line::styled(text, Style::new().fg(colour)))
        .block(Block::bordered().title("bench (q: stop, space: start)"))
}

fn link<'a>(dashboard: &Dashboard, latest: &Latest) -> Paragraph<'a> {
    let own = |name: &str| dashboard.own(latest, name);
    let most = |name: &str| dashboard.greatest(latest, name);
    let lines = vec![
        Line::from(format!(
            "latest   wake-up {:.1} us   work {:.1} us   round trip {:.1} us",
            own("wake"),
            own("work"),
            own("round_trip")
        )),
        Line::from(format!(
            "greatest wake-up {:.1} us   work {:.1} us   skipped {:.0}",
            most("wake"),
            most("work"),
            most("skipped")
        )),
        Line::from(format!(
            "samples  lost {:.0}  late {:.0}  duplicate {:.0}",
            own("lost"),
            own("late"),
            own("duplicate"),
        )),
        Line::from(format!(
            "         reordered {:.0}  corrupt {:.0}",
            own("reordered"),
            own("corrupt")
        )),
    ];
    Paragraph::new(lines).block(Block::bordered().title("gateway"))
}

#[cfg(test)]
mod tests {
    use ratatui::backend::TestBackend;

    use super::*;
    use crate::cycle::columns;

    #[test]
    fn the_picture_says_what_matters() {
        let named = |word: &str, unit: &str| {
            [1, 2].map(|axis| (format!("{word}[{axis}]"), Some(unit.to_owned())))
        };
        let [reference, position] = ["reference", "position"].map(|word| named(word, "um"));
        let columns = columns(&reference, &position, &named("command", "V"), true);
        let mut row = vec![0.0; columns.len()];
        row[0] = 12.5;
        row[1..7].copy_from_slice(&[1.5, 2.5, 1.25, 2.0, 60.0, 70.0]);
        let state = columns.iter().position(|c| c.name == "bench.state").unwrap();
        (row[state], row[state + 1]) = (5.0, 8.0);
        let latest = Latest { row, rows: 1, range: Vec::new(), ended: false };
        let backend = TestBackend::new(100, 16);
        let mut terminal = ratatui::Terminal::new(backend).unwrap();
        let dashboard = Dashboard::new(&columns);
        terminal.draw(|frame| draw(frame, &dashboard, &latest)).unwrap();
        let screen = terminal.backend().to_string();
        for word in
            ["FAULT", "outside its limits", "12.50 s", "position[2]", "0.2500 um", "70.0000 V"]
        {
            assert!(screen.contains(word), "{word} in\n{screen}");
        }
        terminal.draw(|frame| draw(frame, &dashboard, &Latest::default())).unwrap();
        assert!(terminal.backend().to_string().contains("waiting for the machine"));
    }
}
