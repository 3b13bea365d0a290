//! Steps allocate nothing: a run of any length takes as many allocations as a short one.
#![allow(clippy::print_stdout)]

mod common;

use common::instance;
use cosim::{
    Coupling, CsvRecorder, Loop, LoopSettings, Memory, Points, Recorder, Run, Signals, Wiring,
};
use counting::Counting;

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn the_number_of_allocations_does_not_grow_with_the_number_of_steps() {
    let fmus = fmus_or_skip!();
    let (controller, plant) = (fmus.controller(), fmus.integrator());
    let time: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.01).collect();
    let reference: Vec<f64> = time.iter().map(|t| t.sin()).collect();
    for coupling in [Coupling::ControllerFirst, Coupling::SideBySide] {
        let (c, p) = (instance(&controller, "controller"), instance(&plant, "plant"));
        let wiring = Wiring::by_name(&*c, &*p, &["reference[1]"]).unwrap();
        // An integer and a boolean take part.
        let record = ["steps", "enabled"].map(|name| ("plant".to_owned(), name.to_owned())).into();
        let settings = LoopSettings { wiring, coupling, record, ..LoopSettings::default() };
        let mut closed = Loop::new(c, p, &settings).unwrap();
        let signals = Signals::new(&time).with("reference[1]", &reference);
        let mut count = |steps: u32, recorder: &mut dyn Recorder| {
            let points = Points::uniform(0.0, f64::from(steps) * 1e-3, 1e-3).unwrap();
            let run = Run::new(points, &signals);
            let before = counting::calls();
            closed.run(&run, recorder).unwrap();
            counting::calls() - before
        };
        count(10, &mut ());
        assert_eq!(count(10, &mut ()), count(1000, &mut ()));
        let in_memory = |steps, count: &mut dyn FnMut(u32, &mut dyn Recorder) -> u64| {
            count(steps, &mut Memory::new())
        };
        assert_eq!(in_memory(10, &mut count), in_memory(1000, &mut count));
        let as_csv = |steps, count: &mut dyn FnMut(u32, &mut dyn Recorder) -> u64| {
            count(steps, &mut CsvRecorder::new(std::io::sink()))
        };
        assert_eq!(as_csv(10, &mut count), as_csv(1000, &mut count));
    }
}
