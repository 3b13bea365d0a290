//! Nanopositioning stage: LS-SVM over stop operators against LS-SVM with NARX inputs.

use identify::learned::{Frame, Machine, Recipe, Span, rms_difference};
use learned::features::{Features, Narx, Stops};
use learned::lssvm::{Folds, Settings, Validation};
use learned::tune::{
    Annealing, Best, Simplex, Swarm, coupled_annealing, grid_then_simplex, nelder_mead,
    particle_swarm,
};

use super::figures::{self, Chapter};
use super::{Aim, Order, Reproduction, Response, Row, response};

const ID: &str = "P1";
const RIG: &str = "p1-truth";
/// Greatest command of the paper, in V.
const RANGE: f64 = 8.5;
const STOPS: usize = 55;
/// ln σ² and ln γ.
const BOUNDS: [(f64, f64); 2] = [(0.0, 9.0), (-2.0, 18.0)];

struct Records {
    train: Vec<Response>,
    tests: Vec<Response>,
}

fn records() -> anyhow::Result<Records> {
    let of = |letters: &str| {
        letters.chars().map(|l| response(RIG, &format!("p1-{l}"), &[], 1.0)).collect()
    };
    let (train, tests): (anyhow::Result<_>, anyhow::Result<_>) = (of("abc"), of("defg"));
    Ok(Records { train: train?, tests: tests? })
}

impl Records {
    fn pairs(&self) -> Vec<(&[f64], &[f64])> {
        self.train.iter().map(|r| (&r.command[..], r.after())).collect()
    }

    fn errors(&self, machine: &Machine) -> Vec<f64> {
        let error =
            |r: &Response| rms_difference(&machine.simulate(&r.command, r.position[0]), r.after());
        self.tests.iter().map(error).collect()
    }
}

/// How the two settings are sought, by five-fold cross-validation one step ahead.
#[derive(Clone, Copy)]
pub(super) enum Search {
    Swarm,
    Annealing,
    Default,
}

pub(super) fn tuned(
    frame: Frame,
    pairs: &[(&[f64], &[f64])],
    search: Search,
) -> anyhow::Result<(Machine, Best)> {
    let samples = frame.samples(pairs)?;
    let folds = Folds::interleaved(samples.count(), 5);
    let mut validation = Validation::new(&samples, &folds)?;
    let mut row = |s: f64, gammas: &[f64]| -> Vec<f64> {
        let gammas: Vec<f64> = gammas.iter().map(|g| g.exp()).collect();
        let none = vec![f64::INFINITY; gammas.len()];
        validation.one_step(s.exp(), &gammas).unwrap_or(none)
    };
    let watch: &mut dyn FnMut(usize, f64) -> bool = &mut |_, _| true;
    let best = match search {
        Search::Default => grid_then_simplex(&BOUNDS, &mut row, watch),
        Search::Swarm => {
            let mut one = |p: &[f64]| row(p[0], &p[1..])[0];
            particle_swarm(&BOUNDS, Swarm::default(), &mut one, watch)
        }
        Search::Annealing => {
            let mut one = |p: &[f64]| row(p[0], &p[1..])[0];
            let coarse = coupled_annealing(&BOUNDS, Annealing::default(), &mut one, watch);
            let simplex = Simplex { evaluations: 100, ..Simplex::default() };
            nelder_mead(&BOUNDS, &coarse.point, simplex, &mut one, watch)
        }
    };
    let settings = Settings { sigma2: best.point[0].exp(), gamma: best.point[1].exp() };
    Ok((Machine::train(frame, pairs, settings)?.0, best))
}

/// The test signals, measured and simulated.
fn seen(records: &Records, machines: &[(&str, Machine)]) -> Chapter {
    let text = "The models are simulated from the command alone.";
    let mut chapter = Chapter::new("the models on the test signals", text);
    for (run, letter) in records.tests.iter().zip("DEFG".chars()) {
        let simulated: Vec<(&str, Vec<f64>)> = machines
            .iter()
            .map(|(name, machine)| (*name, machine.simulate(&run.command, run.position[0])))
            .collect();
        let models: Vec<(&str, &[f64])> = simulated.iter().map(|(n, y)| (*n, &y[..])).collect();
        let title = format!("Signal {letter}");
        chapter = chapter.figure(figures::model(title, "um", run.period, run.after(), &models));
    }
    chapter
}

pub(super) fn run(searches: bool, say: &dyn Fn(&str)) -> anyhow::Result<Reproduction> {
    let records = records()?;
    let pairs = records.pairs();
    let mut answer = Reproduction::default();
    let narx = Features::Narx(Narx { commands: 3, outputs: 3 });
    let narx = Frame::new(narx, Span::UNIT, Span::UNIT, Recipe::Standardised, &pairs);
    let stops =
        Stops { count: STOPS, range: RANGE, period: records.train[0].period, rate_scale: 1.0 };
    let stops = Features::Stops(stops);
    let stops = Frame::new(stops, Span::UNIT, Span::UNIT, Recipe::Standardised, &pairs);
    let mut all = Vec::new();
    let mut machines = Vec::new();
    for (name, frame, search, paper, aim) in [
        ("NARX 3, 3", &narx, Search::Default, [0.021, 0.072, 0.025, 0.166], Aim::Baseline),
        ("stops, default", &stops, Search::Default, [0.0106, 0.0109, 0.0123, 0.0126], Aim::Reach),
        (
            "stops, annealing",
            &stops,
            Search::Annealing,
            [0.0193, 0.0316, 0.0176, 0.0330],
            Aim::Told,
        ),
        ("stops, swarm", &stops, Search::Swarm, [0.0106, 0.0109, 0.0123, 0.0126], Aim::Told),
    ] {
        if !searches && !matches!(search, Search::Default) {
            continue;
        }
        say(name);
        let (machine, best) = tuned(frame.clone(), &pairs, search)?;
        let errors = records.errors(&machine);
        for ((error, paper), letter) in errors.iter().zip(paper).zip("DEFG".chars()) {
            let what = format!("{name}, signal {letter}");
            answer.rows.push(Row::new(ID, what, "um", paper, *error, aim));
        }
        answer.remarks.push(format!(
            "{name}: {} evaluations, cross-validated rms {:.4} um, sigma^2 = {:.3}, gamma = {:.3e}",
            best.evaluations,
            best.value.sqrt(),
            best.point[0].exp(),
            best.point[1].exp()
        ));
        all.push(errors);
        machines.push((name, machine));
    }
    answer.chapters.push(seen(&records, &machines));
    for (k, letter) in "DEFG".chars().enumerate() {
        answer.orders.push(Order {
            paper_id: ID,
            what: format!("signal {letter}: stops better than NARX"),
            holds: all[1][k] < all[0][k],
        });
    }
    answer.remarks.push("signals C, F and G stand in: the paper gives their bands only".into());
    Ok(answer)
}
