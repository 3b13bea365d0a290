//! What the program is made of: where `unsafe` is, that Python and npm parts are pinned by hash, and
//! that nothing but the bench's gateways reaches for a network.

use crate::common;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use common::{root, succeed};

/// The crates that may have `unsafe`: the C edges of FMI and of gateways in C, the handlers of the program's end,
/// and the allocator that tests count with.
const UNSAFE: [&str; 4] = ["crates/exits", "crates/fmi-bindings", "crates/plugin", "dev/counting"];

/// All files below the project's folders with this ending, but what is built.
fn files(ending: &str) -> Vec<PathBuf> {
    let mut all = Vec::new();
    let mut folders = vec![root().to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder of the project").flatten() {
            let (path, name) = (entry.path(), entry.file_name());
            let is_hidden = name.to_string_lossy().starts_with('.');
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                if !is_hidden && name != "target" && name != "node_modules" {
                    folders.push(path);
                }
            } else if path.extension().is_some_and(|e| e == ending) {
                all.push(path);
            }
        }
    }
    all.sort();
    all
}

fn shown(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}

/// A source line without its comment and without what stands in quotes.
fn code(line: &str) -> String {
    let mut out = String::new();
    let mut quoted = false;
    let mut letters = line.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '\\' if quoted => drop(letters.next()),
            '"' => quoted = !quoted,
            '/' if !quoted && letters.peek() == Some(&'/') => break,
            _ if !quoted => out.push(letter),
            _ => {}
        }
    }
    out
}

fn has_word(code: &str, word: &str) -> bool {
    code.split(|c: char| !c.is_alphanumeric() && c != '_').any(|w| w == word)
}

#[test]
fn unsafe_code_is_in_four_crates_only_and_the_compiler_sees_to_it() {
    let workspace = fs::read_to_string(root().join("Cargo.toml")).expect("the manifest");
    let table: toml::Table = workspace.parse().expect("TOML");
    assert_eq!(table["workspace"]["lints"]["rust"]["unsafe_code"].as_str(), Some("forbid"));
    let excluded = table["workspace"]["exclude"].as_array().expect("excluded packages");
    let mut own = Vec::new();
    let manifests = files("toml").into_iter().filter(|path| path.ends_with("Cargo.toml"));
    for file in manifests {
        let member = shown(file.parent().expect("a folder"));
        if excluded.iter().any(|path| path.as_str() == Some(&member)) {
            continue;
        }
        let manifest: toml::Table = fs::read_to_string(file).expect("there").parse().expect("TOML");
        let lints = manifest.get("lints").expect(&member);
        if lints.get("workspace").and_then(toml::Value::as_bool) == Some(true) {
            continue;
        }
        let clippy = lints.get("clippy").expect("its lints");
        assert_eq!(clippy["undocumented_unsafe_blocks"].as_str(), Some("deny"), "{member}");
        assert_eq!(lints["rust"]["unsafe_op_in_unsafe_fn"].as_str(), Some("deny"), "{member}");
        own.push(member);
    }
    own.sort_unstable();
    let mut allowed = UNSAFE.to_vec();
    allowed.sort_unstable();
    assert_eq!(own, allowed, "crates with lints of their own");
    // The sources themselves, those of excluded packages among them.
    let outside = |path: &&PathBuf| !UNSAFE.iter().any(|name| path.starts_with(root().join(name)));
    for path in files("rs").iter().filter(outside) {
        let text = fs::read_to_string(path).expect("a source");
        for (number, line) in text.lines().enumerate() {
            let code = code(line);
            let forms = [
                "unsafe {",
                "unsafe fn",
                "unsafe impl",
                "unsafe extern",
                "unsafe trait",
                "unsafe(",
            ];
            assert!(
                !forms.iter().any(|form| code.contains(form)),
                "{}:{}: {line}",
                shown(path),
                number + 1
            );
        }
    }
}

#[test]
fn each_unsafe_block_has_its_reason() {
    let (mut blocks, mut without) = (0, Vec::new());
    for name in UNSAFE {
        let inside = root().join(name).join("src");
        for path in files("rs").iter().filter(|path| path.starts_with(&inside)) {
            let text = fs::read_to_string(path).expect("a source");
            assert!(!text.contains("allow(clippy::undocumented"), "{}", shown(path));
            let lines: Vec<&str> = text.lines().collect();
            for (at, line) in lines.iter().enumerate() {
                let code = code(line);
                let is_block = code.contains("unsafe {") || code.contains("unsafe impl");
                if !is_block {
                    continue;
                }
                blocks += 1;
                // Above the statement, which may have begun some lines before.
                if !lines[at.saturating_sub(12)..=at].iter().any(|l| l.contains("SAFETY:")) {
                    without.push(format!("{}:{}", shown(path), at + 1));
                }
            }
        }
    }
    println!("{blocks} unsafe blocks and implementations in {}", UNSAFE.join(" and "));
    assert!(blocks > 100, "they are found");
    assert!(without.is_empty(), "without a reason: {without:#?}");
}

#[test]
fn python_packages_are_pinned_by_hash() {
    let folder = root().join("tests/python");
    let mut count = 0;
    for entry in fs::read_dir(folder).expect("the folder").flatten() {
        let path = entry.path();
        let name = entry.file_name().into_string().expect("UTF-8");
        if !(name.starts_with("requirements") && name.ends_with(".txt")) {
            continue;
        }
        let text = fs::read_to_string(&path).expect("requirements").replace("\\\n", " ");
        for line in text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#')) {
            if line.starts_with("-r ") {
                continue;
            }
            assert!(line.contains("=="), "{name}: {line}: no version");
            let hashes: Vec<&str> = line
                .split_whitespace()
                .filter_map(|word| word.strip_prefix("--hash=sha256:"))
                .collect();
            assert!(!hashes.is_empty(), "{name}: {line}: no hash; run dev/tools/hashes");
            for hash in hashes {
                let is_one = hash.len() == 64 && hash.bytes().all(|b| b.is_ascii_hexdigit());
                assert!(is_one, "{name}: {hash}");
            }
            count += 1;
        }
    }
    println!("{count} Python packages with hashes");
    assert!(count > 50);
}

#[test]
fn npm_packages_are_pinned_by_hash() {
    let text = fs::read_to_string(root().join("tests/browser/package-lock.json")).expect("a lock");
    let lock: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let packages = lock["packages"].as_object().expect("packages");
    let real: Vec<_> = packages.iter().filter(|(name, _)| !name.is_empty()).collect();
    assert!(!real.is_empty());
    for (name, package) in real {
        let integrity = package["integrity"].as_str().unwrap_or_default();
        assert!(integrity.starts_with("sha512-"), "{name}: no integrity");
    }
}

#[test]
fn crates_come_from_the_registry_with_a_checksum() {
    let text = fs::read_to_string(root().join("Cargo.lock")).expect("the lock");
    let lock: toml::Table = text.parse().expect("TOML");
    let packages = lock["package"].as_array().expect("packages");
    for package in packages {
        let name = package["name"].as_str().expect("a name");
        let Some(source) = package.get("source").and_then(toml::Value::as_str) else {
            // An empty crate in the place of one that is never called.
            let is_empty = name == "bindgen";
            assert!(name.starts_with("piezoloop") || is_empty, "{name} has no source");
            continue;
        };
        assert_eq!(source, "registry+https://github.com/rust-lang/crates.io-index", "{name}");
        assert!(package.get("checksum").is_some(), "{name} has no checksum");
    }
    // No client of the web is linked, in any configuration.
    let names: BTreeSet<&str> = packages.iter().filter_map(|p| p["name"].as_str()).collect();
    for client in [
        "reqwest",
        "ureq",
        "hyper",
        "curl",
        "isahc",
        "attohttpc",
        "minreq",
        "rustls",
        "native-tls",
        "openssl-sys",
        "h2",
        "tungstenite",
        "quinn",
        "trust-dns-resolver",
        "hickory-resolver",
    ] {
        assert!(!names.contains(client), "{client} is in Cargo.lock");
    }
}

#[test]
fn only_the_bench_speaks_over_a_network() {
    for path in files("rs") {
        let name = shown(&path);
        let is_tool = name.contains("src/") && !name.starts_with("tests/");
        let is_bench = ["crates/bench/src/gateway/", "crates/bench/src/live/"]
            .iter()
            .any(|at| name.starts_with(at));
        if !is_tool || is_bench {
            continue;
        }
        let text = fs::read_to_string(&path).expect("a source");
        for (number, line) in text.lines().enumerate() {
            let code = code(line);
            for word in ["UdpSocket", "TcpStream", "TcpListener", "ToSocketAddrs"] {
                // Where Unix sockets are missing, the type of the isolated FMU's socket is only named.
                let is_named =
                    name == "crates/cosim/src/isolate/slave.rs" && code.contains("type Socket");
                assert!(is_named || !has_word(&code, word), "{name}:{}: {line}", number + 1);
            }
        }
    }
}

/// The way from a blueprint to a diagnosed log.
#[cfg(target_os = "linux")]
const WAY: [&[&str]; 6] = [
    &["invert", "evc", "-o", "controller.toml"],
    &["pack", "evc", "-o", "plant.fmu"],
    &["check", "plant.fmu"],
    &["signal", "multisine-odd", "-o", "signal.csv"],
    &[
        "simulate",
        "plant.fmu",
        "--log",
        "u.csv",
        "--isolate",
        "--report",
        "page.html",
        "-o",
        "run.csv",
    ],
    &[
        "identify",
        "--log",
        "run.csv",
        "--input",
        "command[1]",
        "--output",
        "position[1]",
        "-o",
        "found.toml",
    ],
];

#[cfg(target_os = "linux")]
fn drive(folder: &Path) {
    let mut text = "time,command[1],command[2]\n".to_owned();
    for k in 0..500 {
        let t = f64::from(k) * 1e-4;
        let u = 60.0 - 50.0 * (2.0 * std::f64::consts::PI * 20.0 * t).cos() * (1.0 - t);
        text += &format!("{t},{u},{u}\n");
    }
    fs::write(folder.join("u.csv"), text).expect("the folder is writable");
}

#[cfg(target_os = "linux")]
#[test]
fn no_socket_is_opened() {
    if Command::new("strace").arg("-V").output().is_err() {
        println!("SKIPPED: no strace");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    drive(folder.path());
    let mut seen = 0;
    for call in WAY {
        let trace = folder.path().join("trace");
        let output = Command::new("strace")
            .args(["-f", "-e", "trace=socket,socketpair,connect,bind,execve", "-o"])
            .arg(&trace)
            .arg(env!("CARGO_BIN_EXE_piezoloop"))
            .args(call)
            .current_dir(folder.path())
            .output()
            .expect("strace starts");
        let message = String::from_utf8_lossy(&output.stderr);
        if message.contains("ptrace") && message.contains("not permitted") {
            println!("SKIPPED: no process may be traced here");
            return;
        }
        assert!(output.status.success(), "{call:?}: {message}");
        let trace = fs::read_to_string(&trace).expect("a trace");
        assert!(trace.contains("execve("), "the trace is that of the tool");
        for line in trace.lines().filter(|line| !line.contains("execve(")) {
            // A process for an FMU is spoken to through a pair of sockets without an address.
            let is_pair = line.contains("socketpair(AF_UNIX");
            let is_end = line.contains("+++") || line.contains("---");
            assert!(is_pair || is_end, "{call:?}: {line}");
            seen += usize::from(is_pair);
        }
    }
    assert!(seen > 0, "calls are seen");
}

#[cfg(target_os = "linux")]
#[test]
fn everything_works_without_a_network() {
    let folder = tempfile::tempdir().expect("a folder");
    drive(folder.path());
    let without = || {
        let mut command = Command::new("unshare");
        command.args(["--user", "--map-root-user", "--net"]).current_dir(folder.path());
        command
    };
    if !without().arg("true").status().is_ok_and(|status| status.success()) {
        println!("SKIPPED: no namespace without a network can be made here");
        return;
    }
    for call in WAY {
        let tool = env!("CARGO_BIN_EXE_piezoloop");
        let output = without().arg(tool).args(call).output().expect("unshare starts");
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{call:?}: {message}");
    }
    let here = fs::read(folder.path().join("run.csv")).expect("a run");
    succeed(&["simulate", "plant.fmu", "--log", "u.csv", "-o", "run.csv"], folder.path());
    assert!(here == fs::read(folder.path().join("run.csv")).expect("a run"), "the same run");
}
