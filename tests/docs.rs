//! The documentation: its commands run, its links lead somewhere, its site builds.
//!
//! A fence ```` ```sh ```` holds commands that are run here, page by page, each page in a folder of its own.
//! ```` ```sh hardware ````, `sh data` and `sh long` hold what needs a machine, measured logs or minutes.
#![cfg(unix)]

use crate::common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use common::{foreign, root};

/// A fenced block: what stands behind the fence, its first line's number, its text.
struct Block {
    language: String,
    line: usize,
    text: String,
}

fn blocks(page: &Path) -> Vec<Block> {
    let text = fs::read_to_string(page).expect("a page");
    let (mut all, mut inside): (Vec<Block>, bool) = (Vec::new(), false);
    for (number, line) in text.lines().enumerate() {
        if let Some(language) = line.strip_prefix("```") {
            inside = !inside;
            if inside {
                let language = language.trim().to_owned();
                all.push(Block { language, line: number + 2, text: String::new() });
            }
        } else if let (true, Some(block)) = (inside, all.last_mut()) {
            block.text += line;
            block.text.push('\n');
        }
    }
    all
}

/// The Markdown files of a folder.
fn pages(folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join(folder)).expect("the folder is in the project");
    let mut all: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "md"))
        .collect();
    all.sort();
    all
}

/// Runs all commands of a page, in its order, as a reader does.
fn run(page: &str) {
    assert!(RUN.contains(&page), "{page} is in the list of what runs");
    let blocks = blocks(&root().join(page));
    let commands: Vec<&Block> = blocks.iter().filter(|block| block.language == "sh").collect();
    assert!(!commands.is_empty(), "{page} has no command to run");
    let folder = tempfile::tempdir().expect("a folder");
    let tools = Path::new(env!("CARGO_BIN_EXE_piezoloop")).parent().expect("a folder").to_owned();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::iter::once(tools).chain(std::env::split_paths(&path));
    let script: String =
        commands.iter().map(|b| format!("echo '# line {}'\n{}", b.line, b.text)).collect();
    let output = Command::new("sh")
        .args(["-e", "-c", &script])
        .current_dir(folder.path())
        .env("PATH", std::env::join_paths(paths).expect("a PATH"))
        .output()
        .expect("a shell");
    let message = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{page}:\n{message}{errors}");
    println!("{page}: {} blocks run", commands.len());
}

/// The pages whose commands run, each in a test of its own.
const RUN: [&str; 9] = [
    "README.md",
    "docs/tutorial.md",
    "docs/howto-simulation.md",
    "docs/howto-control.md",
    "docs/howto-test.md",
    "docs/control.md",
    "docs/learned.md",
    "docs/sweep.md",
    "docs/deploy.md",
];

#[test]
fn the_readme_runs() {
    run("README.md");
}

/// README's first command, and the table that it says the command prints.
#[test]
fn the_demo_gives_the_figures_of_the_readme() {
    let folder = tempfile::tempdir().expect("a folder");
    let demo = common::json(&["demo"], folder.path());
    assert!(folder.path().join("piezoloop-demo/index.html").is_file());
    let readme = fs::read_to_string(root().join("README.md")).expect("the page");
    let row = |name: &str| -> Vec<f64> {
        let line = readme.lines().find(|line| line.starts_with(&format!("| {name} |")));
        let cells = line.unwrap_or_else(|| panic!("README has no row {name}")).split('|').skip(2);
        cells.filter_map(|cell| cell.trim().strip_suffix(" %")?.parse().ok()).collect()
    };
    for (name, key) in
        [("PID alone", "pid_percent"), ("inverse + the same PID", "inverse_and_pid_percent")]
    {
        let printed = row(name);
        assert_eq!(printed.len(), 2, "{name}");
        for (axis, printed) in printed.iter().enumerate() {
            let got = demo["axes"][axis][key].as_f64().expect("a figure");
            // Two digits are printed.
            assert!((got / printed - 1.0).abs() < 0.05, "{name}, axis {axis}: {got} and {printed}");
        }
    }
    for axis in 0..2 {
        let figure = |key: &str| demo["axes"][axis][key].as_f64().expect("a figure");
        assert!(figure("identified_percent") < 0.15 * figure("line_percent"), "{demo}");
    }
}

#[test]
fn the_tutorial_runs() {
    run("docs/tutorial.md");
}

#[test]
fn the_page_for_the_simulation_engineer_runs() {
    run("docs/howto-simulation.md");
}

#[test]
fn the_page_for_the_control_engineer_runs() {
    run("docs/howto-control.md");
}

#[test]
fn the_page_for_the_test_engineer_runs() {
    run("docs/howto-test.md");
}

#[test]
fn the_page_on_controllers_runs() {
    run("docs/control.md");
}

#[test]
fn the_page_on_learned_models_runs() {
    run("docs/learned.md");
}

#[test]
fn the_page_on_targets_runs() {
    run("docs/deploy.md");
}

#[test]
fn the_page_on_sweeps_runs() {
    run("docs/sweep.md");
}

#[test]
fn every_command_of_the_pages_is_run_or_marked() {
    let (mut marked, mut problems) = (0, Vec::new());
    for page in [pages("docs"), pages("modelica"), vec![root().join("README.md")]].concat() {
        let name = page.strip_prefix(root()).expect("a page of the project").display().to_string();
        for block in blocks(&page) {
            let place = format!("{name}:{}", block.line);
            match block.language.as_str() {
                "sh" if RUN.contains(&name.as_str()) => {}
                "sh" => problems.push(format!("{place}: the page is not among those that run")),
                "sh hardware" | "sh data" | "sh long" => marked += 1,
                "" | "text" | "console" | "bash" | "shell"
                    if block.text.lines().any(is_command) =>
                {
                    problems.push(format!("{place}: commands stand in ```sh"));
                }
                _ => {}
            }
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
    println!("{marked} blocks need hardware, data or long; they are not run");
    assert_eq!(marked, 20, "blocks that are not run are counted here");
}

fn is_command(line: &str) -> bool {
    let starts = ["piezoloop ", "cargo ", "pip ", "sh ", "rustup ", "dev/tools/"];
    starts.iter().any(|start| line.starts_with(start))
}

/// The commands of the tool in a text, each on one line.
fn commands(text: &str) -> Vec<String> {
    let complete = text.replace("\\\n", " ");
    let lines = complete.lines().filter_map(|line| {
        let at = line.find("piezoloop ")?;
        (!line.trim_start().starts_with('#')).then(|| line[at..].to_owned())
    });
    lines.collect()
}

/// What an example's README shows is what its script, which runs in `tests/examples.rs`, does.
#[test]
fn the_commands_of_the_examples_stand_in_their_scripts() {
    let mut shown = 0;
    for entry in fs::read_dir(root().join("examples")).expect("examples") {
        let folder = entry.expect("an entry").path();
        let script = fs::read_to_string(folder.join("run.sh")).expect("each example has a script");
        let script = commands(&script);
        for block in blocks(&folder.join("README.md")) {
            if !matches!(block.language.as_str(), "" | "sh") {
                continue;
            }
            for command in commands(&block.text) {
                let words: Vec<&str> = command.split_whitespace().collect();
                let name: Vec<&str> = words[..3.min(words.len())]
                    .iter()
                    .copied()
                    .filter(|word| word.chars().all(char::is_alphabetic))
                    .collect();
                let options: Vec<&str> =
                    words.iter().copied().filter(|word| word.starts_with('-')).collect();
                let is_run = script.iter().any(|line| {
                    let there: Vec<&str> = line.split_whitespace().collect();
                    name.iter().chain(&options).all(|word| there.contains(word))
                });
                assert!(is_run, "{}: not in run.sh: {command}", folder.display());
                shown += 1;
            }
        }
    }
    assert!(shown > 20, "{shown} commands");
}

#[test]
fn links_lead_to_files_of_the_project() {
    let mut problems = Vec::new();
    let mut all = [pages("docs"), pages("modelica"), vec![root().join("README.md")]].concat();
    for example in fs::read_dir(root().join("examples")).expect("examples") {
        let readme = example.expect("an entry").path().join("README.md");
        all.extend(Some(readme).filter(|file| file.is_file()));
    }
    for page in all {
        let text = fs::read_to_string(&page).expect("a page");
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = target.split('#').next().unwrap_or_default();
            let is_outside = target.contains("://") || target.starts_with("mailto:");
            let there = page.parent().expect("a folder").join(file);
            // Formulas such as `z[j](x)` are no links.
            let is_link = !target.contains(char::is_whitespace) && file.contains(['.', '/']);
            if is_link && !is_outside && !there.exists() {
                problems.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn every_page_is_on_the_map_and_in_the_site() {
    let [map, site] = ["docs/index.md", "mkdocs.yml"]
        .map(|file| fs::read_to_string(root().join(file)).expect("a file of the project"));
    for page in pages("docs") {
        let name = page.file_name().and_then(|name| name.to_str()).expect("a name").to_owned();
        let is_linked = name == "index.md" || map.contains(&format!("]({name})"));
        assert!(is_linked, "docs/index.md has no link to {name}");
        assert!(site.contains(&format!(": {name}\n")), "mkdocs.yml has no line for {name}");
    }
}

#[test]
fn the_site_builds_without_a_warning() {
    let Some(python) = foreign::environment("docs") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let mut site = Command::new(python);
    site.arg(root().join("dev/tools/site")).arg(env!("CARGO_BIN_EXE_piezoloop")).arg(folder.path());
    let message = foreign::message(&mut site, folder.path());
    println!("{message}");
    let page = |name: &str| {
        fs::read_to_string(folder.path().join("site").join(name)).expect("a page of the site")
    };
    assert!(page("commands.html").contains("piezoloop bench emulate"));
    assert!(page("gap-schema.html").contains("<code>verdict</code>"));
    assert!(page("tutorial.html").contains("From log to bench"));
}

/// The sentences of a page: no code, no tables, links by their text.
fn sentences(page: &str) -> Vec<String> {
    let text = fs::read_to_string(root().join(page)).expect("a page");
    let (mut all, mut current, mut inside) = (Vec::new(), String::new(), false);
    let mut end = |current: &mut String| {
        all.extend(Some(std::mem::take(current)).filter(|sentence| !sentence.trim().is_empty()));
    };
    for line in text.lines() {
        let start = line.trim_start();
        let is_fence = start.starts_with("```");
        let number = start.trim_start_matches(|c: char| c.is_ascii_digit());
        let is_item =
            start.starts_with("* ") || number.len() < start.len() && number.starts_with(". ");
        if is_fence || start.is_empty() || is_item || start.starts_with(['|', '#']) {
            end(&mut current);
        }
        inside ^= is_fence;
        if inside || is_fence || start.starts_with('|') {
            continue;
        }
        let line = if is_item { start.split_once(' ').map_or("", |item| item.1) } else { start };
        // `[text](address)` is its text.
        let mut shown = String::new();
        for (at, part) in line.split("](").enumerate() {
            shown += if at == 0 { part } else { part.split_once(')').map_or(part, |p| p.1) };
        }
        for word in shown.split_whitespace() {
            current.push(' ');
            current += word;
            if word.trim_end_matches(['*', '"', ')']).ends_with(['.', '!', '?']) {
                end(&mut current);
            }
        }
    }
    end(&mut current);
    all
}

#[test]
fn sentences_of_the_first_pages_are_short() {
    const MOST: usize = 30;
    for page in ["README.md", "docs/tutorial.md", "docs/howto-control.md", "docs/howto-test.md"] {
        let all = sentences(page);
        assert!(all.len() > 10, "{page} has {} sentences", all.len());
        for sentence in all {
            let is_word = |word: &&str| word.contains(char::is_alphanumeric);
            let words = sentence.split_whitespace().filter(is_word).count();
            assert!(words <= MOST, "{page}: {words} words, at most {MOST}:{sentence}");
        }
    }
}
