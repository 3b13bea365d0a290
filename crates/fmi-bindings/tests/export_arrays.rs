//! FMI 3.0: axes and array parameters as arrays.

use std::ffi::{CString, c_char, c_void};
use std::ptr::null;
use std::sync::Mutex;

use crate::support::components::PERIOD;
use crate::support::{Fmu, arrays_plant, controller, plant, resources};
use fmi_bindings::export::{Factory, v3};
use fmi_bindings::fmi2::fmi2OK;
use fmi_bindings::fmi3::*;

/// Value references of the plant with two axes, in the order of its table.
const COMMAND: u32 = 0;
const POSITION: u32 = 2;
const MOVING: u32 = 4;

type Messages = Mutex<Vec<String>>;

unsafe extern "C" fn record(
    environment: *mut c_void,
    _: fmi3Status,
    _: *const c_char,
    message: *const c_char,
) {
    let text = unsafe { std::ffi::CStr::from_ptr(message) }.to_str().unwrap().to_string();
    unsafe { &*environment.cast::<Messages>() }.lock().unwrap().push(text);
}

struct Arrays {
    fmu: fmi3Instance,
    messages: Box<Messages>,
}

impl Arrays {
    fn new(factory: Factory) -> Self {
        let token = factory(resources()).unwrap().variables().fingerprint();
        let (token, path) = (CString::new(token), CString::new(resources().to_str().unwrap()));
        let messages = Box::<Messages>::default();
        let fmu = unsafe {
            v3::fmi3InstantiateCoSimulation(
                factory,
                c"it".as_ptr(),
                token.unwrap().as_ptr(),
                path.unwrap().as_ptr(),
                false,
                true,
                false,
                true,
                null(),
                0,
                (&raw const *messages).cast_mut().cast(),
                Some(record),
                None,
            )
        };
        assert!(!fmu.is_null(), "{messages:?}");
        Self { fmu, messages }
    }

    fn ready(factory: Factory) -> Self {
        let arrays = Self::new(factory);
        arrays.start();
        arrays
    }

    fn start(&self) {
        unsafe {
            let entered = v3::fmi3EnterInitializationMode(self.fmu, false, 0.0, 0.0, false, 0.0);
            assert_eq!(entered, fmi3OK);
            assert_eq!(v3::fmi3ExitInitializationMode(self.fmu), fmi3OK);
        }
    }

    fn set(&self, references: &[u32], values: &[f64]) -> fmi3Status {
        let (r, v) = (references.as_ptr(), values.as_ptr());
        unsafe { v3::fmi3SetFloat64(self.fmu, r, references.len(), v, values.len()) }
    }

    fn get(&self, references: &[u32], count: usize) -> (fmi3Status, Vec<f64>) {
        let mut values = vec![f64::NAN; count];
        let (r, v) = (references.as_ptr(), values.as_mut_ptr());
        let status = unsafe { v3::fmi3GetFloat64(self.fmu, r, references.len(), v, count) };
        (status, values)
    }

    fn step(&self, time: f64, step: f64) -> fmi3Status {
        let (mut a, mut b, mut c, mut last) = (true, true, true, f64::NAN);
        unsafe { v3::fmi3DoStep(self.fmu, time, step, true, &mut a, &mut b, &mut c, &mut last) }
    }

    fn derivative(
        &self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        count: usize,
    ) -> (fmi3Status, Vec<f64>) {
        let mut values = vec![f64::NAN; count];
        let status = unsafe {
            v3::fmi3GetDirectionalDerivative(
                self.fmu,
                unknowns.as_ptr(),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                seed.as_ptr(),
                seed.len(),
                values.as_mut_ptr(),
                count,
            )
        };
        (status, values)
    }

    fn last(&self) -> String {
        self.messages.lock().unwrap().last().cloned().unwrap_or_default()
    }
}

impl Drop for Arrays {
    fn drop(&mut self) {
        unsafe { v3::fmi3FreeInstance(self.fmu) }
    }
}

#[test]
fn axes_are_arrays_with_the_bits_of_the_scalars() {
    let (arrays, scalars) = (Arrays::ready(plant), Fmu::ready(plant));
    for k in 0..100 {
        let (time, u) = (f64::from(k) * 1.3e-3, [f64::from(k % 7), f64::from(k % 5) - 2.0]);
        assert_eq!(arrays.set(&[COMMAND], &u), fmi3OK);
        assert_eq!(scalars.set_reals(&[0, 1], &u), fmi2OK);
        assert_eq!(arrays.step(time, 1.3e-3), fmi3OK, "{}", arrays.last());
        assert_eq!(scalars.step(time, 1.3e-3), fmi2OK);
        let (status, y) = arrays.get(&[POSITION], 2);
        assert_eq!(status, fmi3OK);
        let wanted = [scalars.real("position[1]"), scalars.real("position[2]")];
        assert_eq!(y.iter().map(|y| y.to_bits()).collect::<Vec<_>>(), wanted.map(f64::to_bits));
    }
    let mut flags = [false; 2];
    let status = unsafe { v3::fmi3GetBoolean(arrays.fmu, &MOVING, 1, flags.as_mut_ptr(), 2) };
    assert_eq!((status, flags), (fmi3OK, [true; 2]));
}

#[test]
fn several_variables_are_read_one_behind_the_other() {
    let arrays = Arrays::ready(plant);
    let table = plant(resources()).unwrap();
    let gain = table.variables().find("axis[2].lag.gain").unwrap();
    let time = v3::time_reference(table.variables());
    assert_eq!(arrays.set(&[gain, COMMAND], &[7.0, 1.0, 2.0]), fmi3OK, "{}", arrays.last());
    let (status, values) = arrays.get(&[COMMAND, time, gain, COMMAND], 6);
    assert_eq!(status, fmi3OK);
    assert_eq!(values, [1.0, 2.0, 0.0, 7.0, 1.0, 2.0]);
}

#[test]
fn array_parameters_are_arrays_wherever_they_stand() {
    // Two axes with three weights each.
    let table = arrays_plant(resources()).unwrap();
    let weights: Vec<u32> =
        (1..=2).map(|i| table.variables().find(&format!("axis[{i}].taps.w[1]")).unwrap()).collect();
    let arrays = Arrays::new(arrays_plant);
    assert_eq!(arrays.get(&weights, 6).1, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(arrays.set(&[weights[1]], &[0.5, 0.25, 0.125]), fmi3OK, "{}", arrays.last());
    arrays.start();
    assert_eq!(arrays.set(&[COMMAND], &[1.0, 8.0]), fmi3OK);
    assert_eq!(arrays.step(0.0, PERIOD), fmi3OK);
    let position = table.variables().find("position[1]").unwrap();
    assert_eq!(arrays.get(&[position], 2).1, [6.0, 7.0]);
}

#[test]
fn the_number_of_values_is_exactly_that_of_the_elements() {
    for count in [0, 1, 3] {
        let arrays = Arrays::ready(plant);
        let (status, values) = arrays.get(&[POSITION], count);
        assert_eq!(status, fmi3Error);
        assert!(values.iter().all(|value| value.is_nan()), "nothing is written");
        for part in ["1 value references", &format!("{count} in values"), "2 values together"] {
            assert!(arrays.last().contains(part), "{part}: {}", arrays.last());
        }
        let arrays = Arrays::ready(plant);
        assert_eq!(arrays.set(&[COMMAND], &vec![1.0; count]), fmi3Error);
        assert_eq!(arrays.get(&[COMMAND], 2).1, [0.0; 2], "nothing is set");
    }
    let arrays = Arrays::ready(plant);
    assert_eq!(arrays.get(&[], 0).0, fmi3OK);
    let mut flag = false;
    assert_eq!(unsafe { v3::fmi3GetBoolean(arrays.fmu, &MOVING, 1, &mut flag, 1) }, fmi3Error);
}

#[test]
fn an_array_is_set_completely_or_not_at_all() {
    let arrays = Arrays::ready(plant);
    assert_eq!(arrays.set(&[COMMAND], &[1.0, f64::NAN]), fmi3Error);
    for part in ["command[2] (element 2 of value reference 0)", "NaN", "finite"] {
        assert!(arrays.last().contains(part), "{part}: {}", arrays.last());
    }
    assert_eq!(arrays.get(&[COMMAND], 2).1, [0.0; 2]);
}

#[test]
fn an_element_has_no_value_reference_of_its_own() {
    let arrays = Arrays::ready(plant);
    assert_eq!(arrays.get(&[COMMAND + 1], 1).0, fmi3Error);
    for part in ["value reference 1 is unknown", "command[2]", "element 2", "value reference 0"] {
        assert!(arrays.last().contains(part), "{part}: {}", arrays.last());
    }
    let arrays = Arrays::ready(plant);
    assert_eq!(arrays.set(&[POSITION], &[0.0; 2]), fmi3Error);
    assert!(arrays.last().contains("is an output"), "{}", arrays.last());
    let arrays = Arrays::ready(plant);
    assert_eq!(arrays.get(&[MOVING], 2).0, fmi3Error);
    assert!(arrays.last().contains("is of type Boolean, not Float64"), "{}", arrays.last());
}

#[test]
fn one_axis_is_an_array_of_one() {
    let arrays = Arrays::ready(controller);
    assert_eq!(arrays.set(&[0], &[2.0]), fmi3OK, "{}", arrays.last());
    assert_eq!(arrays.get(&[0], 1).1, [2.0]);
}

#[test]
fn directional_derivatives_are_spread_out() {
    let arrays = Arrays::ready(plant);
    assert_eq!(arrays.step(0.0, PERIOD), fmi3OK);
    let (status, values) = arrays.derivative(&[POSITION], &[COMMAND], &[1.0, -1.0], 2);
    assert_eq!(status, fmi3OK, "{}", arrays.last());
    assert!((values[0] - 0.2).abs() < 1e-10 && (values[1] + 0.5).abs() < 1e-10, "{values:?}");
    for (seed, count, part) in [(&[1.0][..], 2, "1 in seed"), (&[1.0, 0.0], 1, "1 in sensitivity")]
    {
        let arrays = Arrays::ready(plant);
        assert_eq!(arrays.derivative(&[POSITION], &[COMMAND], seed, count).0, fmi3Error);
        assert!(arrays.last().contains(part), "{}", arrays.last());
    }
    let arrays = Arrays::ready(plant);
    assert_eq!(arrays.derivative(&[POSITION], &[1], &[1.0], 2).0, fmi3Error);
}

#[test]
fn slopes_of_outputs_are_spread_out() {
    let slopes = |arrays: &Arrays, references: &[u32], count: usize| {
        let (mut values, orders) = (vec![f64::NAN; count], vec![1; references.len()]);
        let (r, v) = (references.as_ptr(), values.as_mut_ptr());
        let (n, o) = (references.len(), orders.as_ptr());
        let status = unsafe { v3::fmi3GetOutputDerivatives(arrays.fmu, r, n, o, v, count) };
        (status, values)
    };
    let arrays = Arrays::ready(plant);
    assert_eq!(slopes(&arrays, &[POSITION], 2), (fmi3OK, vec![0.0; 2]));
    assert_eq!(arrays.set(&[COMMAND], &[3.0, -1.0]), fmi3OK);
    assert_eq!(arrays.step(0.0, PERIOD), fmi3OK);
    let position = arrays.get(&[POSITION], 2).1;
    let wanted = position.iter().map(|y| y / PERIOD).collect::<Vec<_>>();
    assert_eq!(slopes(&arrays, &[POSITION], 2), (fmi3OK, wanted));
    for (references, count, part) in
        [(&[POSITION][..], 1, "but 1 in values"), (&[COMMAND], 2, "is no Real output")]
    {
        let arrays = Arrays::ready(plant);
        assert_eq!(slopes(&arrays, references, count).0, fmi3Error);
        assert!(arrays.last().contains(part), "{}", arrays.last());
    }
}
