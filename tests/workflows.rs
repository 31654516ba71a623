//! The workflows and the action under `.github`: they cannot run here, so what a linter of text can know is checked.
//!
//! Linters that know more were run by hand: actionlint found nothing but the names of newer runners, which its list does not
//! hold; the published schemas of workflows and actions hold; zizmor 1.32 asks for hashes in place of the tags of GitHub's own
//! actions, and warns that the action puts the folder it fetched on the path, as it must.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn files() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(".github");
    // A package holds no .github.
    let mut open = vec![root];
    let mut found = Vec::new();
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "yml") {
                let text = std::fs::read_to_string(&path).expect("UTF-8");
                found.push((path, text));
            }
        }
    }
    found.sort();
    found
}

fn named(file: &str) -> Option<String> {
    files().into_iter().find(|(p, _)| p.ends_with(file)).map(|(_, text)| text)
}

/// What stands between `${{` and `}}`.
fn expressions(text: &str) -> Vec<&str> {
    text.split("${{").skip(1).filter_map(|rest| rest.split("}}").next()).map(str::trim).collect()
}

/// The scripts of `run:` keys, by indentation.
fn scripts(text: &str) -> Vec<String> {
    let lines: Vec<&str> = text.lines().collect();
    let indent = |l: &str| l.len() - l.trim_start().len();
    let mut found = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        let Some(rest) = line.trim_start().trim_start_matches("- ").strip_prefix("run:") else { continue };
        let own = indent(line);
        let body = lines[i + 1..].iter().take_while(|l| l.trim().is_empty() || indent(l) > own);
        found.push(if rest.trim() == "|" { body.map(|l| format!("{l}\n")).collect() } else { rest.to_string() });
    }
    found
}

#[test]
fn every_file_is_well_formed_and_gives_no_more_rights_than_it_needs() {
    for (path, text) in files() {
        let place = path.display();
        assert!(!text.contains('\t') && text.ends_with('\n'), "{place}: tabs, or no line feed at the end");
        for (i, line) in text.lines().enumerate() {
            let indent = line.len() - line.trim_start().len();
            assert!(indent % 2 == 0, "{place}:{}: an odd indent", i + 1);
        }
        assert_eq!(text.matches("${{").count(), text.matches("}}").count(), "{place}: an expression is open");
        if path.parent().is_some_and(|p| p.ends_with("workflows")) {
            assert!(text.contains("\npermissions:\n  contents: read\n"), "{place}: permissions are not named");
            assert!(text.contains("timeout-minutes:"), "{place}: a job may run for ever");
            assert_eq!(text.matches("actions/checkout@").count(), text.matches("persist-credentials: false").count());
        }
        for used in text.lines().filter_map(|l| l.trim_start().trim_start_matches("- ").strip_prefix("uses:")) {
            let version = used.trim().rsplit_once('@').map(|(_, v)| v).unwrap_or_default();
            assert!(version.starts_with('v') && version.len() > 1, "{place}: {used} names no version");
        }
    }
}

#[test]
fn no_script_is_put_together_from_what_a_stranger_may_write() {
    for (path, text) in files() {
        for script in scripts(&text) {
            assert!(!script.contains("${{"), "{}: pass it by the environment:\n{script}", path.display());
        }
    }
}

#[test]
fn the_action_uses_the_inputs_it_declares_and_arguments_that_exist() {
    let Some(text) = named("actions/check/action.yml") else { return };
    let declared: BTreeSet<&str> = text
        .split("\ninputs:\n")
        .nth(1)
        .and_then(|rest| rest.split("\noutputs:\n").next())
        .expect("inputs before outputs")
        .lines()
        .filter(|l| l.starts_with("  ") && !l.starts_with("   "))
        .map(|l| l.trim().trim_end_matches(':'))
        .collect();
    let used: BTreeSet<&str> = expressions(&text)
        .into_iter()
        .filter_map(|e| e.strip_prefix("inputs."))
        .map(|e| e.split(' ').next().unwrap())
        .collect();
    assert_eq!(declared, used);
    let Some(binary) = option_env!("CARGO_BIN_EXE_amcheck") else { return };
    let help = std::process::Command::new(binary).arg("--help").output().expect("amcheck starts");
    let help = String::from_utf8_lossy(&help.stdout).into_owned();
    let script = scripts(&text).concat();
    for word in script.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-')).filter(|w| w.starts_with("--")) {
        let foreign = ["--check", "--repo", "--pattern", "--clobber"];
        assert!(foreign.contains(&word) || help.contains(word), "amcheck has no {word}");
    }
}

/// Runs the action's script as a runner does, over patterns of files of a folder; what it put out, and its summary.
fn judged_by_the_action(binary: &Path, folder: &Path, script: &str, parts: &str) -> (String, String) {
    let mut path = vec![binary.parent().expect("a folder").to_path_buf()];
    path.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
    std::fs::write(folder.join("judge.sh"), script).expect("a file");
    for file in ["output", "summary"] {
        std::fs::write(folder.join(file), "").expect("a file");
    }
    let given = [
        ("PARTS", parts),
        ("PROCESS", "fdm"),
        ("FAIL_ON", "fail"),
        ("BASELINE", ""),
        ("ACCEPT", ""),
        ("MORE", "--only thin-wall --quiet"),
        ("OUT", "out"),
        ("GITHUB_OUTPUT", "output"),
        ("GITHUB_STEP_SUMMARY", "summary"),
    ];
    let done = std::process::Command::new("bash")
        .args(["--noprofile", "--norc", "-eo", "pipefail", "judge.sh"])
        .current_dir(folder)
        .env("PATH", std::env::join_paths(path).expect("a path"))
        .envs(given)
        .output()
        .expect("bash starts");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let read = |file: &str| std::fs::read_to_string(folder.join(file)).expect("UTF-8");
    (read("output"), read("summary"))
}

#[test]
fn the_action_judges_every_part_whatever_came_of_those_before() {
    let Some(text) = named("actions/check/action.yml") else { return };
    let Some(binary) = option_env!("CARGO_BIN_EXE_amcheck").map(Path::new) else { return };
    if cfg!(windows) || std::process::Command::new("bash").arg("--version").output().is_err() {
        println!("skipped: no bash");
        return;
    }
    let script = scripts(&text).into_iter().find(|s| s.contains("$PARTS")).expect("the script that judges");
    let folder = std::env::temp_dir().join(format!("amcheck-action-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("my parts")).expect("a folder");
    let fixture = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/parts").join(name);
    for (from, to) in [("rib_010.stl", "a.stl"), ("wall_080.stl", "b.stl"), ("wall_080.stl", "my parts/c d.stl")] {
        std::fs::copy(fixture(from), folder.join(to)).expect("a copy");
    }
    std::fs::write(folder.join("b.3mf"), "no zip").expect("a file");
    let (output, summary) = judged_by_the_action(binary, &folder, &script, "*.stl\n*.3mf\nmy parts/*.stl\n");
    assert_eq!(output, "exit-code=4\n");
    for told in ["a.stl", "b.stl", "c d.stl", "b.3mf: amcheck ended with 4"] {
        assert!(summary.contains(told), "{told} is not in\n{summary}");
    }
    for report in ["a.stl", "b.stl", "my parts/c d.stl"] {
        assert!(folder.join("out").join(report).join("report.json").is_file(), "no report of {report}");
    }
    let (output, _) = judged_by_the_action(binary, &folder, &script, "a.stl\n");
    assert_eq!(output, "exit-code=1\n");
    let (output, _) = judged_by_the_action(binary, &folder, &script, "b.stl\n");
    assert_eq!(output, "exit-code=0\n");
    // Beside the reports that it wrote, in folders that are named as the parts.
    std::fs::create_dir_all(folder.join("before/b.stl")).expect("a folder");
    let (output, _) = judged_by_the_action(binary, &folder, &script, "b.stl\nbefore/*.stl\n");
    assert_eq!(output, "exit-code=2\n");
    std::fs::copy(fixture("wall_080.stl"), folder.join("before/c.stl")).expect("a copy");
    let (output, _) = judged_by_the_action(binary, &folder, &script, "b.stl\nbefore/*.stl\n");
    assert_eq!(output, "exit-code=0\n");
    let (output, _) = judged_by_the_action(binary, &folder, &script, "none*.stl\na.stl\n");
    assert_eq!(output, "exit-code=2\n");
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn the_action_describes_every_exit_code_in_the_order_it_ranks_them() {
    let Some(text) = named("actions/check/action.yml") else { return };
    let script = scripts(&text).concat();
    let ranks = script.lines().find_map(|l| l.trim().strip_prefix("rank()")).expect("the ranks");
    let ranked: Vec<&str> = ranks.split(';').filter_map(|arm| arm.split(')').next()?.split(' ').next_back()).collect();
    let ranked: Vec<&str> = ranked.into_iter().filter(|code| code.parse::<u8>().is_ok()).collect();
    let order = text.split("in the order ").nth(1).and_then(|rest| rest.split(';').next()).expect("an order");
    assert_eq!(order, format!("{}, 70", ranked.join(", ")));
    let Some(binary) = option_env!("CARGO_BIN_EXE_amcheck") else { return };
    let help = std::process::Command::new(binary).arg("--help").output().expect("amcheck starts");
    let help = String::from_utf8_lossy(&help.stdout).into_owned();
    let listed = help.split("Exit codes: ").nth(1).expect("exit codes");
    let codes = listed.split(|c: char| !c.is_ascii_digit()).filter(|code| !code.is_empty() && *code != "130");
    for code in codes {
        assert!(order.split(", ").any(|o| o == code), "{code} is not in {order}");
    }
}

#[test]
fn the_action_fetches_what_the_release_packs() {
    let (Some(action), Some(release)) = (named("actions/check/action.yml"), named("workflows/release.yml")) else {
        return;
    };
    let targets = |text: &str, from: &str| -> BTreeSet<String> {
        let ends = |c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '-');
        text.split(from).skip(1).map(|rest| rest.trim_start().split(ends).next().unwrap().to_string()).collect()
    };
    let (fetched, packed) = (targets(&action, ") target="), targets(&release, ", target:"));
    assert_eq!(fetched, packed);
    for system in ["linux", "apple", "windows"] {
        assert!(packed.iter().any(|t| t.contains(system)), "no release for {system}");
    }
    assert!(release.contains(&format!("wc -l)\" = {} ]", packed.len())), "the number of archives is another");
    assert!(release.contains("sha256sum amcheck-* > SHA256SUMS") && action.contains("--check sum"));
}
