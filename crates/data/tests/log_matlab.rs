//! MATLAB files as scripts, Simulink, Dymola and Octave write them.
#![cfg(feature = "formats")]

#[path = "binary/mat.rs"]
mod mat;

use data::{Log, ReadOptions};
use mat::{Value, column, doubles, row, standing, version_4, version_5};

const T: [f64; 4] = [0.0, 0.1, 0.2, 0.3];
const U: [f64; 4] = [1.0, 2.0, 3.0, 4.0];
const Y: [f64; 4] = [-1.0, 0.5, 0.25, 7.0];

fn read(bytes: &[u8]) -> Result<Log, String> {
    read_with(bytes, &ReadOptions::default())
}

fn read_with(bytes: &[u8], options: &ReadOptions) -> Result<Log, String> {
    let file = tempfile::Builder::new().suffix(".mat").tempfile().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    Log::read(file.path(), options).map_err(|problems| problems.to_string())
}

fn of(variables: &[(&str, Value)]) -> Log {
    read(&version_5(variables)).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn assert_columns(log: &Log, expected: &[(&str, &[f64])]) {
    assert_eq!(log.time(), T);
    let names: Vec<&str> = log.columns().iter().map(|column| column.name.as_str()).collect();
    let wanted: Vec<&str> = expected.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, wanted);
    for (name, values) in expected {
        assert_eq!(log.column(name).unwrap().values, *values, "{name}");
    }
}

#[track_caller]
fn assert_reported(log: &Log, wanted: &str) {
    let notes = log.notes().join("\n");
    assert!(notes.contains(wanted), "{wanted} is not in: {notes}");
}

/// `[u; y]` with a row for each.
fn rows() -> Vec<f64> {
    U.iter().zip(&Y).flat_map(|(u, y)| [*u, *y]).collect()
}

fn columns() -> Vec<f64> {
    [U, Y].concat()
}

#[test]
fn row_vectors_with_times_called_t() {
    let note = Value::Text("a note");
    let log = of(&[
        ("dt", row(&[0.1])),
        ("t", row(&T)),
        ("u", row(&U)),
        ("y", column(&Y)),
        ("note", note),
    ]);
    assert_columns(&log, &[("u", &U), ("y", &Y)]);
    assert_reported(&log, "t is taken as the time");
    let dropped: Vec<&str> = log.left_out().iter().map(|column| column.name.as_str()).collect();
    assert_eq!(dropped, ["dt", "note"]);
    // Signals as the rows of a matrix.
    let log = of(&[("t", row(&T)), ("x", Value::Numbers(2, 4, rows()))]);
    assert_columns(&log, &[("x[1]", &U), ("x[2]", &Y)]);
    assert_reported(&log, "x: a column per time, taken transposed");
}

#[test]
fn a_sample_rate_goes_before_times() {
    let bytes = version_5(&[("t", row(&T)), ("u", row(&U))]);
    let options = ReadOptions { rate: Some(100.0), ..ReadOptions::default() };
    let log = read_with(&bytes, &options).unwrap();
    assert_eq!(log.time()[1], 0.01);
    assert_eq!(log.column("t").unwrap().values, T);
}

#[test]
fn arrays_that_simulink_logs() {
    let log =
        of(&[("tout", column(&T)), ("yout", Value::Numbers(4, 2, columns())), ("sig", column(&U))]);
    assert_columns(&log, &[("yout_1", &U), ("yout_2", &Y), ("sig", &U)]);
    assert_reported(&log, "tout is taken as the time");
}

#[test]
fn matrices_of_to_file_have_their_times_in_the_first_row() {
    let matrix: Vec<f64> = (0..4).flat_map(|k| [T[k], U[k], Y[k]]).collect();
    let log = of(&[("ans", Value::Numbers(3, 4, matrix))]);
    assert_columns(&log, &[("ans_1", &U), ("ans_2", &Y)]);
    assert_reported(&log, "ans: the first row is taken as the time, the others are ans_1, ans_2");
    // From Workspace takes them in the first column.
    let log = of(&[("simin", Value::Numbers(4, 2, [T, U].concat()))]);
    assert_columns(&log, &[("simin", &U)]);
    assert_reported(&log, "the first column");
    // What does not grow is no time.
    let error = read(&version_5(&[(
        "ans",
        Value::Numbers(2, 4, rows().iter().map(|v| v.abs()).rev().collect()),
    )]));
    assert!(error.unwrap_err().contains("time: is missing"));
}

#[test]
fn structures_with_time() {
    let signal = |label, values| {
        vec![("values", values), ("label", Value::Text(label)), ("dimensions", row(&[1.0]))]
    };
    let one = vec![signal("position", column(&U))];
    let structure = |time, signals| {
        Value::Structure(vec![vec![
            ("time", time),
            ("signals", Value::Structure(signals)),
            ("blockName", Value::Text("m/Scope")),
        ]])
    };
    assert_columns(&of(&[("out", structure(column(&T), one.clone()))]), &[("position", &U)]);
    let two = vec![signal("", Value::Numbers(4, 2, columns())), signal("w", column(&Y))];
    let log = of(&[("out", structure(column(&T), two))]);
    assert_columns(&log, &[("out_1_1", &U), ("out_1_2", &Y), ("w", &Y)]);
    assert_reported(&log, "out is a structure with time of out_1_1, out_1_2, w");
    // Without time: the times stand in tout. Two of one label.
    let empty = Value::Numbers(0, 0, Vec::new());
    let twice = vec![signal("w", column(&U)), signal("w", column(&Y))];
    let log = of(&[("tout", column(&T)), ("logs", structure(empty, twice))]);
    assert_columns(&log, &[("w", &U), ("w_2", &Y)]);
    // An array of signals of one row and two columns: the times are the third index.
    let deep = vec![signal("m", Value::Numbers(2, 4, rows()))];
    assert_columns(&of(&[("out", structure(column(&T), deep))]), &[("m_1", &U), ("m_2", &Y)]);
}

#[test]
fn structures_are_scopes() {
    let fields =
        vec![("time", column(&T)), ("u", column(&U)), ("flags", Value::Bytes(vec![1, 0, 255, 3]))];
    let log = of(&[("log", Value::Structure(vec![fields])), ("k", row(&[2.0]))]);
    assert_columns(&log, &[("u", &U), ("flags", &[1.0, 0.0, 255.0, 3.0])]);
    // Times beside the structures; signals of one name in two of them.
    let side = |values: &[f64]| Value::Structure(vec![vec![("u", column(values))]]);
    let log = of(&[("t", row(&T)), ("left", side(&U)), ("right", side(&Y))]);
    assert_columns(&log, &[("u", &U), ("right.u", &Y)]);
    // A timeseries that was made a structure.
    let series = vec![("Name", Value::Text("force")), ("Time", column(&T)), ("Data", column(&Y))];
    assert_columns(&of(&[("ts", Value::Structure(vec![series]))]), &[("force", &Y)]);
}

#[test]
fn objects_are_named_and_refused_alone() {
    let series = || ("ts", Value::Object("timeseries"));
    let log = of(&[("t", row(&T)), ("u", row(&U)), series()]);
    assert_columns(&log, &[("u", &U)]);
    let why = "is an object of class timeseries: save time = ts.Time; y = ts.Data";
    assert_eq!(log.left_out()[0].why, why);
    let error = read(&version_5(&[series()])).unwrap_err();
    assert!(error.contains("ts is an object of class timeseries"), "{error}");
    assert!(error.contains("time = ts.Time; y = ts.Data; save(f"), "{error}");
    let error = read(&version_5(&[("tt", Value::Object("timetable"))])).unwrap_err();
    assert!(error.contains("y = tt.Variables; save(f"), "{error}");
}

#[test]
fn version_4_in_both_byte_orders() {
    let bytes =
        [version_4("time", 0, 4, 1, &doubles(&T)), version_4("u", 0, 4, 1, &doubles(&U))].concat();
    assert_columns(&read(&bytes).unwrap(), &[("u", &U)]);
    let big =
        |values: &[f64]| values.iter().flat_map(|value| value.to_be_bytes()).collect::<Vec<u8>>();
    let shorts: Vec<u8> = [1_i16, 2, 3, -4].iter().flat_map(|value| value.to_be_bytes()).collect();
    let bytes =
        [version_4("t", 1000, 1, 4, &big(&T)), version_4("n", 1030, 1, 4, &shorts)].concat();
    assert_columns(&read(&bytes).unwrap(), &[("n", &[1.0, 2.0, 3.0, -4.0])]);
    let error = read(&bytes[..bytes.len() - 1]).unwrap_err();
    assert!(error.contains("n is cut off"), "{error}");
}

/// As Dymola and OpenModelica write results: columns are times, an alias may have the other sign.
#[test]
fn results_of_dymola() {
    let class = standing(&["Atrajectory", "1.1", "", "binTrans"], 11);
    // Rows of characters: the first index runs fastest.
    let class: Vec<u8> =
        (0..11).flat_map(|at| (0..4).map(|row| class[row * 11 + at]).collect::<Vec<_>>()).collect();
    let names = standing(&["time", "m.x", "m.minus", "m.k"], 8);
    let about = standing(&["Time in s [s]", "Position [m]", "[m|mm]", "Stiffness"], 16);
    let info: Vec<u8> = [[0, 1, 0, -1], [2, 2, 0, -1], [2, -2, 0, -1], [1, 1, 0, -1]]
        .iter()
        .flatten()
        .flat_map(|word: &i32| word.to_le_bytes())
        .collect();
    let moves: Vec<f64> = (0..4).flat_map(|k| [T[k], U[k]]).collect();
    let bytes = [
        version_4("Aclass", 51, 4, 11, &class),
        version_4("name", 51, 8, 4, &names),
        version_4("description", 51, 16, 4, &about),
        version_4("dataInfo", 20, 4, 4, &info),
        version_4("data_1", 0, 1, 2, &doubles(&[3.0, 3.0])),
        version_4("data_2", 0, 2, 4, &doubles(&moves)),
    ]
    .concat();
    let log = read(&bytes).unwrap_or_else(|error| panic!("{error}"));
    assert_columns(&log, &[("m.x", &U), ("m.minus", &U.map(|u| -u))]);
    assert_eq!(log.column("m.x").unwrap().unit.as_ref().unwrap().text, "m");
    assert_reported(&log, "result of Dymola or OpenModelica");
    assert_reported(&log, "1 parameters and constants");
}
