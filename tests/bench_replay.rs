//! `piezoloop bench replay`: a controller FMU's record is its replay.

use crate::common;

use std::path::Path;

use common::{json, refuse, succeed};

/// A controller FMU of p1, a plan and a campaign of faults; the records of its trials.
fn records(folder: &Path, kind: &str) -> Vec<String> {
    if !folder.join("controller.fmu").exists() {
        succeed(&["invert", "p1", "--period", "1e-3", "-o", "controller.toml"], folder);
        succeed(&["pack", "controller.toml", "-o", "controller.fmu"], folder);
        let plan = "rate = 1000\nsettle = 0.02\ncontroller = \"controller.fmu\"\n\
                    [[axis]]\ncommand_limits = [-20, 150]\ncommand_rate = 2e4\n\
                    [watch]\nhold = 20\nmax_age = 30\n\
                    [[sequence]]\nkind = \"rest\"\nseconds = 0.2\nat = [5]\n\
                    [[sequence]]\nkind = \"signal\"\nname = \"multisine-odd\"\naxis = 1\noffset = 5\ngain = 0.05\n\
                    [[sequence]]\nkind = \"rest\"\nseconds = 0.2\nat = [3]\n";
        std::fs::write(folder.join("plan.toml"), plan).unwrap();
        let end = |state: &str, reason: &str| {
            format!("expect = {{ state = \"{state}\", reason = \"{reason}\" }}\n")
        };
        let campaign = format!(
            "plan = \"plan.toml\"\nplant = \"p1\"\nseed = 3\n\
             [[case]]\nname = \"a bad line\"\n{}\
             [[case.fault]]\nkind = \"loss\"\nprobability = 0.2\ndirection = \"both\"\n\
             [[case.fault]]\nkind = \"jitter\"\nseconds = 4e-3\n\
             [[case.fault]]\nkind = \"corrupt\"\nprobability = 0.1\n\
             [[case]]\nname = \"no power\"\nat = [400]\n{}[[case.fault]]\nkind = \"power-loss\"\n\
             [[case]]\nname = \"cut\"\nat = [300]\n{}[[case.fault]]\nkind = \"loss\"\nprobability = 1\n",
            end("safe", "finished"),
            end("fault", "power-lost"),
            end("safe", "sample-lost"),
        );
        std::fs::write(folder.join("faults.toml"), campaign).unwrap();
    }
    let answer = json(
        &["bench", "campaign", "faults.toml", "--records", "records", "--records-as", kind],
        folder,
    );
    assert_eq!(answer["failed"], 0, "{answer:#}");
    let file = |record: &serde_json::Value| record["file"].as_str().unwrap().to_owned();
    answer["records"].as_array().unwrap().iter().map(file).collect()
}

#[test]
fn the_record_of_a_controller_fmu_is_its_replay() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for kind in ["parquet", "csv", "mf4"] {
        let files = records(here, kind);
        let mut call = vec!["bench", "replay"];
        call.extend(files.iter().map(String::as_str));
        let answer = json(&call, here);
        assert_eq!(answer["different"], 0, "{answer:#}");
        let found = answer["records"].as_array().unwrap();
        assert_eq!(found.len(), 3);
        for one in found {
            assert_eq!(one["controller_sha256"].as_str().map(str::len), Some(64));
            assert!(
                one["rows"].as_u64() > Some(200) && one["compared"].as_u64() > one["rows"].as_u64()
            );
        }
        let notes = found[0]["notes"].to_string();
        assert!(notes.contains("rows have an older position"), "{notes}");
    }
    let messages = succeed(&["bench", "replay", "records/0002.csv"], here);
    assert!(messages.contains("the same bits"), "{messages}");

    // One number of the record is changed in its last place.
    let text = std::fs::read_to_string(here.join("records/0001.csv")).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let place = lines[0].split(',').position(|name| name.starts_with("command[1]")).unwrap();
    let mut cells: Vec<String> = lines[300].split(',').map(str::to_owned).collect();
    let recorded: f64 = cells[place].parse().unwrap();
    cells[place] = format!("{:?}", f64::from_bits(recorded.to_bits() + 1));
    lines[300] = cells.join(",");
    std::fs::write(here.join("records/0001.csv"), lines.join("\n") + "\n").unwrap();
    let output = common::piezoloop(&["bench", "replay", "records/0001.csv"], here);
    let messages = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(1), "{messages}");
    assert!(
        messages.contains("1 of") && messages.contains("row 299), command[1]: recorded"),
        "{messages}"
    );
    assert!(messages.contains(&format!("replayed {recorded:?}")), "{messages}");

    // Another FMU, a moved one, none.
    std::fs::rename(here.join("controller.fmu"), here.join("moved.fmu")).unwrap();
    let message = refuse(&["bench", "replay", "records/0002.csv"], here);
    assert!(message.contains("controller.fmu is not there any more"), "{message}");
    succeed(&["bench", "replay", "records/0002.csv", "--fmu", "moved.fmu"], here);
    succeed(&["invert", "p1", "--period", "1e-3", "--feedback", "pi", "-o", "other.toml"], here);
    succeed(&["pack", "other.toml", "-o", "other.fmu"], here);
    let other = ["bench", "replay", "records/0002.csv", "--fmu", "other.fmu"];
    let message = refuse(&other, here);
    assert!(message.contains("SHA-256") && message.contains("--any-fmu"), "{message}");
    let output = common::piezoloop(&[&other[..], &["--any-fmu", "--json"]].concat(), here);
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1), "{answer}");
    assert!(answer["records"][0]["notes"][0].as_str().unwrap().contains("is not the controller"));
    assert!(answer["records"][0]["first_difference"]["signal"].is_string(), "{answer:#}");

    // What is no record.
    std::fs::write(here.join("log.csv"), "time,y\n0,1\n1,2\n").unwrap();
    assert!(refuse(&["bench", "replay", "log.csv"], here).contains("log.about.json"));
    std::fs::write(here.join("log.about.json"), "{\"tool\": \"piezoloop 0.0.1\"}").unwrap();
    assert!(refuse(&["bench", "replay", "log.csv"], here).contains("piezoloop 0.0.1"));
    assert!(refuse(&["bench", "replay", "log.txt"], here).contains(".parquet"));
}
