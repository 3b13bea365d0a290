//! The timed side of the operators in `dev/benches/peers.py`: identifies a dynamic Prandtl–Ishlinskii model, as
//! `piezoloop identify` does, once per line of standard input, and answers with one line of JSON.
//!
//! `operator FILE` where FILE holds little-endian doubles: samples n, sample time, plays, then n commands and n
//! positions. Each answer: seconds, and the root mean square error in simulation over all samples.

use std::io::{BufRead, Write};
use std::time::Instant;

use data::AxisBlueprint;
use identify::{Columns, Dynamics, Methods, Record, Settings, Silent, Target, identify, simulate};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let file = std::env::args().nth(1).ok_or("usage: operator FILE < jobs")?;
    let numbers: Vec<f64> = std::fs::read(file)?
        .chunks_exact(8)
        .map(|b| f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]))
        .collect();
    let (n, period, plays) = (numbers[0] as usize, numbers[1], numbers[2] as usize);
    let (input, output) = numbers[3..].split_at(n);
    let time: Vec<f64> = (0..n).map(|k| k as f64 * period).collect();
    let columns =
        Columns { name: "peer", time: &time, input_name: "u", input, output_name: "y", output };
    let record = Record::new(columns).map_err(|problems| format!("{problems:?}"))?;
    let axis = AxisBlueprint::new("x", "V", "um");
    let target = Target { model: "peer".to_owned(), source: String::new(), axis };
    let range = |f: fn(f64, f64) -> f64| input.iter().copied().reduce(f).unwrap_or(0.0);
    let half = 0.5 * (range(f64::max) - range(f64::min));
    let settings = Settings {
        thresholds: Some((0..plays).map(|k| k as f64 * half / plays as f64).collect()),
        dynamics: Dynamics::Static,
        methods: Methods::Named(vec!["dynamic-prandtl-ishlinskii".to_owned()]),
        longest_delay: Some(0.0),
        hold_out: 0.1,
        ..Settings::default()
    };
    let mut out = std::io::stdout().lock();
    for _ in std::io::stdin().lock().lines() {
        let start = Instant::now();
        let found = identify(std::slice::from_ref(&record), &target, &settings, &mut Silent)?;
        let seconds = start.elapsed().as_secs_f64();
        let simulated = simulate(&found.plant, &record)?;
        let squares = simulated.iter().zip(output).map(|(s, y)| (s - y).powi(2)).sum::<f64>();
        let rmse = (squares / n as f64).sqrt();
        writeln!(out, "{{\"seconds\":{seconds:e},\"rmse\":{rmse:e}}}")?;
        out.flush()?;
    }
    Ok(())
}
