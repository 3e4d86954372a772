//! The script of the array job.

use super::{SbatchValue, Settings};

/// What the name of the job begins with where `[sbatch]` gives none; the command follows.
const JOB_NAME: &str = "powergs";

/// Exit code of the script when the folder or a line of `setup` fails, before the simulator runs.
pub const SETUP_FAILED: u8 = 125;

/// What every task is called with. All of it is bytes: arguments need not be UTF-8.
#[derive(Debug, Clone)]
pub struct Call<'a> {
    /// The simulator, if the settings name none.
    pub program: &'a [u8],
    /// The command: `sweep`.
    pub command: &'a str,
    /// What follows the command, without `--out` and `--shard`.
    pub arguments: Vec<&'a [u8]>,
    /// What the simulator is called with when all parts are done: `sweep merge DIR`.
    pub finish: Vec<&'a [u8]>,
    /// The output folder, absolute.
    pub out: &'a [u8],
    /// The folder in which relative paths begin, absolute.
    pub folder: &'a [u8],
}

/// Why no script can be written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ScriptError {
    /// A value for an `#SBATCH` line.
    #[error("`{0}` cannot stand in an #SBATCH line: it holds {1}; use another name")]
    Directive(String, &'static str),
}

/// A shell word that means exactly `word`.
pub fn quoted(word: &[u8]) -> Vec<u8> {
    let safe = |b: &u8| b.is_ascii_alphanumeric() || b"_-+./:,@%=".contains(b);
    if !word.is_empty() && word.iter().all(safe) {
        return word.to_vec();
    }
    let mut out = vec![b'\''];
    for byte in word {
        match byte {
            b'\'' => out.extend_from_slice(b"'\\''"),
            _ => out.push(*byte),
        }
    }
    out.push(b'\'');
    out
}

/// A value as `sbatch` reads it from an `#SBATCH` line. It knows quotes, but no way to write a
/// quote or a backslash that does not depend on its version.
///
/// # Errors
/// Double quotes, backslashes and control characters.
pub fn directive_value(text: &str) -> Result<String, ScriptError> {
    let bad = |what| Err(ScriptError::Directive(text.to_owned(), what));
    if text.contains('"') {
        return bad("a double quote");
    }
    if text.contains('\\') {
        return bad("a backslash");
    }
    if text.chars().any(char::is_control) {
        return bad("a line break or another control character");
    }
    let safe = |c: char| c.is_ascii_alphanumeric() || "_-+./:,@%=".contains(c);
    Ok(if text.chars().all(safe) && !text.is_empty() {
        text.to_owned()
    } else {
        format!("\"{text}\"")
    })
}

/// The parts as an array expression: `1-4,7%2`. They must ascend.
pub fn array(parts: &[u32], at_once: Option<u32>) -> String {
    let mut text = String::new();
    let mut rest = parts;
    while let Some(&first) = rest.first() {
        let run = rest.iter().zip(first..).take_while(|(part, n)| **part == *n).count();
        let last = rest[run - 1];
        let comma = if text.is_empty() { "" } else { "," };
        text.push_str(&match run {
            1 => format!("{comma}{first}"),
            2 => format!("{comma}{first},{last}"),
            _ => format!("{comma}{first}-{last}"),
        });
        rest = &rest[run..];
    }
    at_once.map(|n| format!("{text}%{n}")).unwrap_or(text)
}

/// Where a task writes what it prints, under the output folder.
pub fn log_name(job: &str, part: u32) -> String {
    format!("slurm/{job}_{part}.log")
}

/// Where a task notes its exit code, under the output folder.
pub fn exit_name(job: &str, part: u32) -> String {
    format!("slurm/{job}_{part}.exit")
}

/// A word in a comment, which a line break would end.
fn commented(word: &[u8]) -> Vec<u8> {
    word.iter().map(|&b| if b.is_ascii_control() { b'?' } else { b }).collect()
}

/// The script: all parts, one task each. Safe to run again: a part continues where it stopped.
///
/// # Errors
/// An output folder whose name `sbatch` cannot take.
pub fn script(settings: &Settings, call: &Call<'_>) -> Result<Vec<u8>, ScriptError> {
    let mut out = Vec::new();
    let mut line = |parts: &[&[u8]]| {
        parts.iter().for_each(|part| out.extend_from_slice(part));
        out.push(b'\n');
    };
    let program = settings.program.as_ref().map_or(call.program, |p| p.as_bytes());
    let (program, dir) = (quoted(program), quoted(call.out));
    line(&[b"#!/bin/bash"]);
    let (command, parts) = (call.command, settings.shards);
    line(&[format!("# `powergs-sim {command}` in {parts} parts.").as_bytes()]);
    line(&[b"# By hand: mkdir -p ", &commented(&dir), b"/slurm, then sbatch THIS_FILE"]);
    let mut finish = program.clone();
    append(&mut finish, &call.finish);
    line(&[b"# When all parts are done: ", &commented(&finish)]);
    for directive in directives(settings, call)? {
        line(&[b"#SBATCH --", directive.as_bytes()]);
    }
    line(&[b"out=", &dir]);
    line(&[b"note=$out/slurm/${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID.exit"]);
    line(&[b"leave() {"]);
    line(&[b"    printf '%s\\n' \"$1\" > \"$note.part\" && mv -f -- \"$note.part\" \"$note\""]);
    line(&[b"    exit \"$1\""]);
    line(&[b"}"]);
    line(&[b"rm -f -- \"$note\""]);
    let guard = format!("[ $? -eq 0 ] || leave {SETUP_FAILED}");
    line(&[b"cd -- ", &quoted(call.folder)]);
    line(&[guard.as_bytes()]);
    for (name, value) in &settings.environment {
        line(&[b"export ", name.as_bytes(), b"=", &quoted(value.as_bytes())]);
    }
    for setup in &settings.setup {
        line(&[setup.as_bytes()]);
        line(&[guard.as_bytes()]);
    }
    let mut task = program;
    task.extend_from_slice(b" --jobs \"${SLURM_CPUS_ON_NODE:-1}\" ");
    task.extend_from_slice(command.as_bytes());
    append(&mut task, &call.arguments);
    task.extend_from_slice(b" \\\n    --out \"$out\" --shard \"$SLURM_ARRAY_TASK_ID/");
    task.extend_from_slice(format!("{parts}\"").as_bytes());
    line(&[&task]);
    line(&[b"leave $?"]);
    Ok(out)
}

/// Adds words to a line of the script.
fn append(line: &mut Vec<u8>, words: &[&[u8]]) {
    for word in words {
        line.push(b' ');
        line.extend(quoted(word));
    }
}

/// The `#SBATCH` lines, without what stands before the name.
fn directives(settings: &Settings, call: &Call<'_>) -> Result<Vec<String>, ScriptError> {
    let folder = String::from_utf8(call.out.to_vec()).map_err(|_| {
        let text = String::from_utf8_lossy(call.out).into_owned();
        ScriptError::Directive(text, "bytes that are not UTF-8")
    })?;
    let logs = directive_value(&format!("{}/slurm/%A_%a.log", folder.replace('%', "%%")))?;
    let all: Vec<u32> = (1..=settings.shards).collect();
    let given = |name: &str| settings.sbatch.contains_key(name);
    let mut lines = Vec::new();
    if !given("job-name") {
        lines.push(format!("job-name={JOB_NAME}-{}", call.command));
    }
    lines.push(format!("array={}", array(&all, settings.at_once)));
    lines.push(format!("output={logs}"));
    lines.push("open-mode=append".to_owned());
    if !given("requeue") && !given("no-requeue") {
        lines.push("requeue".to_owned());
    }
    for (name, value) in &settings.sbatch {
        match value {
            SbatchValue::Text(text) => lines.push(format!("{name}={}", directive_value(text)?)),
            SbatchValue::Flag => lines.push(name.clone()),
            SbatchValue::Off => {}
        }
    }
    Ok(lines)
}
