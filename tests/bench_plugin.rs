//! Drivers in C behind `plugin://`: the example card on the bench, and the one for NI-DAQmx against its
//! functions as a stub of the header declares them. Skipped where there is no C compiler.
#![cfg(unix)]

use crate::common;

use std::path::Path;
use std::process::Command;

use common::bench::{log, stage};
use common::{json, refuse, succeed};

/// The functions that examples/05_bench/nidaqmx.c calls, as NI's documentation of the C API gives them.
const NIDAQMX: &str = "#include <stdint.h>\n\
    typedef int32_t int32; typedef uint32_t uInt32, bool32; typedef double float64; typedef void *TaskHandle;\n\
    #define DAQmx_Val_Volts 10348\n#define DAQmx_Val_Cfg_Default -1\n#define DAQmx_Val_GroupByChannel 0\n\
    int32 DAQmxCreateTask(const char[], TaskHandle *);\n\
    int32 DAQmxCreateAOVoltageChan(TaskHandle, const char[], const char[], float64, float64, int32, const char[]);\n\
    int32 DAQmxCreateAIVoltageChan(TaskHandle, const char[], const char[], int32, float64, float64, int32, const char[]);\n\
    int32 DAQmxGetTaskNumChans(TaskHandle, uInt32 *);\n\
    int32 DAQmxStartTask(TaskHandle); int32 DAQmxStopTask(TaskHandle); int32 DAQmxClearTask(TaskHandle);\n\
    int32 DAQmxWriteAnalogF64(TaskHandle, int32, bool32, float64, bool32, const float64[], int32 *, bool32 *);\n\
    int32 DAQmxReadAnalogF64(TaskHandle, int32, float64, bool32, float64[], uInt32, int32 *, bool32 *);\n\
    int32 DAQmxGetExtendedErrorInfo(char[], uInt32);\n";

/// Whether there is a compiler, and the file was compiled with these words.
fn compiled(folder: &Path, source: &str, words: &[&str]) -> bool {
    std::fs::write(folder.join("gateway.h"), succeed(&["bench", "header"], folder)).unwrap();
    let source = common::root().join("examples/05_bench").join(source);
    let mut compiler = Command::new("cc");
    compiler.args([
        "-std=c11",
        "-D_POSIX_C_SOURCE=200809L",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-O2",
        "-I.",
    ]);
    let Ok(compiled) = compiler.args(words).arg(source).current_dir(folder).output() else {
        println!("SKIPPED: no C compiler `cc`");
        return false;
    };
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    true
}

#[test]
fn the_example_card_is_a_machine() {
    let folder = stage(0.5);
    let here = folder.path();
    if !compiled(here, "card.c", &["-shared", "-fPIC", "-o", "libcard.so"]) {
        return;
    }
    let gateway = "plugin://./libcard.so?registers.bin";
    let call = ["bench", "run", "--plan", "plan.toml", "--gateway", gateway, "--record", "run.csv"];
    let answer = json(&call, here);
    assert_eq!(answer["reason"], "the plan has ended", "{answer:#}");
    assert_eq!(answer["machine"], "fake card with 1 channels in registers.bin");
    assert_eq!(answer["gateway_failure"], serde_json::Value::Null);
    let log = log(here, "run.csv");
    let greatest = log.column("position[1]").unwrap().values.iter().fold(0.0_f64, |m, y| m.max(*y));
    assert!((greatest - 0.6).abs() < 1e-3, "6 V are 0.6 um, not {greatest}");
    // The registers at the end: the command of the safe state, and what it led to.
    let registers = std::fs::read(here.join("registers.bin")).unwrap();
    assert_eq!((registers.len(), &registers[..8]), (16, &[0; 8][..]));
    succeed(&["bench", "replay", "run.csv"], here);

    let call = |gateway| ["bench", "run", "--plan", "plan.toml", "--gateway", gateway];
    let message = refuse(&call("plugin://./libcard.so?/no/such/folder/x"), here);
    assert!(message.contains("/no/such/folder/x: No such file"), "{message}");
    let message = refuse(&call("plugin://./other.so"), here);
    assert!(message.contains("other.so") && message.contains("bench header"), "{message}");
    let machine = ["bench", "emulate", "p1", "--gateway", gateway, "--rate", "200"];
    assert!(refuse(&machine, here).contains("is a machine itself"));
}

#[test]
fn the_example_for_nidaqmx_compiles_against_its_functions() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let installed = Path::new("/usr/include/NIDAQmx.h").exists();
    if installed {
        println!("against the installed NIDAQmx.h");
    } else {
        println!("NI-DAQmx is not installed: against a stub with the functions that are called");
        std::fs::write(here.join("NIDAQmx.h"), NIDAQMX).unwrap();
    }
    compiled(here, "nidaqmx.c", &["-fPIC", "-c", "-o", "nidaqmx.o"]);
}
