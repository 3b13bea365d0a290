//! Initialization: what inputs and outputs are when the slaves leave it.

use std::sync::{Arc, Mutex};

use crate::common::real;
use cosim::{
    Algorithm, Diagram, Error, Experiment, GaussSeidel, Iteration, IterationSettings, Jacobi,
    Points, Run, Selection, Signals, Slave, StepResult, System, Value,
};
use modeldescription::description::CoSimulation;
use modeldescription::structure::Unknown;
use modeldescription::variable::Causality;
use modeldescription::{FmiVersion, ModelDescription};

/// `y = offset + Σ gain·u`, in initialization and at rest. It notes with which inputs it leaves the
/// initialization, and how often they were set until then.
struct Linear {
    name: String,
    description: ModelDescription,
    offset: f64,
    gains: Vec<f64>,
    inputs: Vec<f64>,
    left_with: Noted,
    sets: usize,
}

type Noted = Arc<Mutex<(Vec<f64>, usize)>>;

impl Linear {
    /// `dependencies` are the positions of the inputs from 1; `None`: not stated.
    fn new(name: &str, offset: f64, gains: &[f64], dependencies: Option<&[u32]>) -> Self {
        let mut description = ModelDescription::new(FmiVersion::V2, name, name);
        description.co_simulation = Some(CoSimulation::new(name));
        for (number, _) in (0..).zip(gains) {
            let input = real(&format!("u[{}]", number + 1), number, Causality::Input, None);
            description.variables.push(input);
        }
        let output = gains.len() as u32;
        description.variables.push(real("y", output, Causality::Output, None));
        let dependencies = dependencies.map(<[u32]>::to_vec);
        description.structure.outputs.push(Unknown::new(output + 1));
        let initial = Unknown { dependencies, ..Unknown::new(output + 1) };
        description.structure.initial_unknowns.push(initial);
        Linear {
            name: name.to_owned(),
            description,
            offset,
            gains: gains.to_vec(),
            inputs: vec![0.0; gains.len()],
            left_with: Noted::default(),
            sets: 0,
        }
    }
}

impl Slave for Linear {
    fn name(&self) -> &str {
        &self.name
    }

    fn description(&self) -> &ModelDescription {
        &self.description
    }

    fn setup(&mut self, _: &Experiment) -> Result<(), Error> {
        Ok(())
    }

    fn enter_initialization(&mut self) -> Result<(), Error> {
        Ok(())
    }

    fn exit_initialization(&mut self) -> Result<(), Error> {
        *self.left_with.lock().unwrap() = (self.inputs.clone(), self.sets);
        Ok(())
    }

    fn set_start(&mut self, _: &str, _: &Value) -> Result<(), Error> {
        Ok(())
    }

    fn value(&mut self, _: &str) -> Result<Value, Error> {
        Ok(Value::Real(0.0))
    }

    fn set(&mut self, selection: &Selection, values: &[f64]) -> Result<(), Error> {
        self.sets += 1;
        for (reference, value) in selection.references().iter().zip(values) {
            self.inputs[*reference as usize] = *value;
        }
        Ok(())
    }

    fn get(&mut self, _: &Selection, values: &mut [f64]) -> Result<(), Error> {
        let terms = self.gains.iter().zip(&self.inputs).map(|(gain, u)| gain * u);
        values.fill(self.offset + terms.sum::<f64>());
        Ok(())
    }

    fn step(&mut self, _: f64, _: f64) -> Result<StepResult, Error> {
        Ok(StepResult::Completed)
    }

    fn terminate(&mut self) -> Result<(), Error> {
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Error> {
        self.inputs.fill(0.0);
        self.sets = 0;
        Ok(())
    }
}

/// The slaves connected by `(source, target, input from 1)`, and what each leaves with.
fn system(slaves: Vec<Linear>, wires: &[(&str, &str, usize)]) -> (System, Vec<Noted>) {
    let noted = slaves.iter().map(|slave| Arc::clone(&slave.left_with)).collect();
    let mut diagram = Diagram::new();
    for slave in slaves {
        diagram.add(Box::new(slave));
    }
    for (source, target, input) in wires {
        diagram.connect((*source, "y"), (*target, format!("u[{input}]").as_str()));
    }
    (diagram.build().unwrap(), noted)
}

fn begin(system: &mut System, algorithm: &dyn Algorithm) -> Result<(), Error> {
    let signals = Signals::default();
    let points = Points::uniform(0.0, 1.0, 1.0).unwrap();
    let run = Run::new(points, &signals);
    system.run(&run, algorithm, &mut ()).map(|_| ())
}

fn inputs(noted: &Noted) -> Vec<f64> {
    noted.lock().unwrap().0.clone()
}

/// Makes an algorithm for a system and the order of its FMUs.
type Make = fn(&System, &[&str]) -> Box<dyn Algorithm>;

/// A controller at rest under its reference gives a command, whatever it measures; the plant turns it
/// into a position. The controller must leave the initialization with that position as measured,
/// not with the plant's output at a command of zero: else it sees a jump in its first step.
#[test]
fn the_controller_begins_with_the_position_that_the_plant_begins_with() {
    for order in [["controller", "plant"], ["plant", "controller"]] {
        let built = || {
            let mut slaves = vec![
                Linear::new("controller", 3.0, &[0.0], Some(&[])),
                Linear::new("plant", 0.5, &[2.0], Some(&[1])),
            ];
            if order[0] == "plant" {
                slaves.reverse();
            }
            system(slaves, &[("controller", "plant", 1), ("plant", "controller", 1)])
        };
        let algorithms: [Make; 2] = [
            |_, _| Box::new(Jacobi),
            |system, order| Box::new(GaussSeidel::in_order(system, order).unwrap()),
        ];
        for algorithm in algorithms {
            let (mut system, noted) = built();
            let algorithm = algorithm(&system, &order);
            begin(&mut system, &*algorithm).unwrap();
            let at = |name: &str| &noted[order.iter().position(|there| *there == name).unwrap()];
            assert_eq!(inputs(at("plant")), [3.0]);
            assert_eq!(inputs(at("controller")), [6.5], "{order:?}");
            assert_eq!(system.unsolved(), [""; 0]);
        }
    }
}

/// `d → c → b → a`, added in the order a, b, c, d: all inputs are final, whoever comes first.
#[test]
fn a_chain_against_the_order_is_passed_on_to_its_end() {
    let link = |name: &str| Linear::new(name, 1.0, &[2.0], None);
    let slaves = vec![link("a"), link("b"), link("c"), Linear::new("d", 1.0, &[], None)];
    let wires = [("d", "c", 1), ("c", "b", 1), ("b", "a", 1)];
    let (mut system, noted) = system(slaves, &wires);
    for _ in 0..2 {
        // The second time after a reset.
        begin(&mut system, &Jacobi).unwrap();
        assert_eq!(
            noted.iter().map(inputs).collect::<Vec<_>>(),
            [vec![7.0], vec![3.0], vec![1.0], vec![]]
        );
        // Once in its turn and once at the end.
        assert!(noted.iter().all(|noted| noted.lock().unwrap().1 <= 3), "{noted:?}");
    }
}

/// `x = 1 + 2y`, `y = −3x` has the solution `x = 1/7`, from which substitution runs away.
#[test]
fn a_circle_is_solved_by_every_algorithm() {
    let built = || {
        let slaves =
            vec![Linear::new("x", 1.0, &[2.0], None), Linear::new("y", 0.0, &[-3.0], Some(&[1]))];
        system(slaves, &[("y", "x", 1), ("x", "y", 1)])
    };
    let (mut jacobi, noted) = built();
    begin(&mut jacobi, &Jacobi).unwrap();
    assert_eq!(jacobi.unsolved(), [""; 0]);
    assert!((inputs(&noted[0])[0] + 3.0 / 7.0).abs() < 1e-9, "{noted:?}");
    assert!((inputs(&noted[1])[0] - 1.0 / 7.0).abs() < 1e-9, "{noted:?}");
    let (mut seidel, noted) = built();
    let algorithm = GaussSeidel::by_dependency(&seidel);
    begin(&mut seidel, &algorithm).unwrap();
    assert!((inputs(&noted[1])[0] - 1.0 / 7.0).abs() < 1e-9, "{noted:?}");
}

/// `x = 1 + y`, `y = x` has none: those who solve circles in steps refuse, the others begin with one
/// pass and say so.
#[test]
fn a_circle_without_a_solution_is_reported() {
    let built = || {
        let mut slaves =
            vec![Linear::new("x", 1.0, &[1.0], None), Linear::new("y", 0.0, &[1.0], None)];
        for slave in &mut slaves {
            let co_simulation = slave.description.co_simulation.as_mut().unwrap();
            co_simulation.common.can_get_and_set_fmu_state = true;
        }
        system(slaves, &[("y", "x", 1), ("x", "y", 1)])
    };
    let (mut jacobi, noted) = built();
    begin(&mut jacobi, &Jacobi).unwrap();
    assert_eq!(jacobi.unsolved().len(), 1);
    assert!(jacobi.unsolved()[0].contains("`y` of FMU `y`"), "{:?}", jacobi.unsolved());
    assert!(noted.iter().flat_map(inputs).all(|input| input.abs() <= 2.0), "{noted:?}");
    let (mut iterated, _) = built();
    let algorithm = Iteration::new(&iterated, IterationSettings::default()).unwrap();
    let error = begin(&mut iterated, &algorithm).unwrap_err().to_string();
    assert!(error.contains("of FMU"), "{error}");
}
