//! Work on Slurm: settings, script, what Slurm answers. `tests/slurm.sh` runs on a real one.

use std::process::Command;

use powergs_study::slurm::Settings;
use powergs_study::slurm::script::{Call, array, directive_value, quoted, script};
use powergs_study::slurm::state::{
    Loss, State, Submitted, Verdict, given_up, judge, states, submitted,
};

const GOOD: &str = r#"
shards = 12
at-once = 4
retries = 2
poll = "500 ms"
setup = ["module load gcc  # the site's", "ulimit -c 0"]

[environment]
LANG = "C"
NOTE = "it's $HOME"

[sbatch]
partition = "long"
cpus-per-task = 4
exclusive = true
no-requeue = false
comment = "two words; rm -rf #x"
"#;

#[test]
fn settings_are_read() {
    let settings = Settings::parse(GOOD).unwrap();
    assert_eq!((settings.shards, settings.at_once, settings.retries), (12, Some(4), 2));
    assert_eq!(settings.poll_s(), 0.5);
    let least = Settings::parse("shards = 1").unwrap();
    assert_eq!((least.retries, least.poll_s(), least.at_once), (3, 15.0, None));
    assert!(least.program.is_none() && least.sbatch.is_empty());
}

#[track_caller]
fn refused(text: &str, wanted: &[&str]) {
    let error = Settings::parse(text).unwrap_err().to_string();
    for part in wanted {
        assert!(error.contains(part), "`{part}` is not in:\n{error}");
    }
}

#[test]
fn mistakes_in_settings_are_found_with_their_line() {
    refused("", &["missing key `shards`"]);
    refused("shards = 0", &["line 1", "at least 1"]);
    refused("shards = 100000", &["at most 99999"]);
    refused("shards = 2\nretires = 3", &["line 2", "did you mean `retries`"]);
    refused("shards = 2\npoll = 30", &["line 2", "needs its unit"]);
    refused("shards = 2\npoll = \"2 ms\"", &["0.1 s to 1 h"]);
    refused("shards = 2\npoll = \"1e300 s\"", &["line 2"]);
    refused("shards = 2\n[sbatch]\narray = \"1-3\"", &["line 3", "`shards`"]);
    refused("shards = 2\n[sbatch]\nmem_per_cpu = 1", &["`mem-per-cpu`"]);
    refused("shards = 2\n[sbatch]\n--mem = 1", &["without dashes"]);
    refused("shards = 2\n[sbatch]\np = \"x\"", &["short option"]);
    refused("shards = 2\n[sbatch]\nmem = 1.5", &["a whole number"]);
    refused("shards = 2\n[sbatch]\nmem = [1]", &["a whole number"]);
    refused("shards = 2\n[sbatch]\ncomment = 'a \"b\"'", &["double quote"]);
    refused("shards = 2\n[environment]\n\"A B\" = \"x\"", &["not the name of a variable"]);
    refused("shards = 2 x", &["not valid TOML"]);
}

#[test]
fn no_line_can_be_smuggled_into_the_script() {
    refused("shards = 2\nsetup = [\"true\\nrm x\"]", &["line break"]);
    refused("shards = 2\nprogram = \"a\\nb\"", &["line break"]);
    refused("shards = 2\n[sbatch]\nmem = \"1\\n#SBATCH --uid=0\"", &["line break"]);
    refused("shards = 2\n[sbatch]\n\"mem\\n\" = \"1\"", &["not a long option"]);
    refused("shards = 2\n[environment]\nA = \"1\\nrm x\"", &["line break"]);
    assert!(directive_value("a\nb").is_err() && directive_value("a\\b").is_err());
    assert_eq!(directive_value("a b").unwrap(), "\"a b\"");
    assert_eq!(directive_value("4G").unwrap(), "4G");
}

#[test]
fn a_quoted_word_is_that_word_to_a_shell() {
    let words = ["", "a", "a b", "it's", "$(rm x)", "`x`", "a\nb", "*", "~", "#", "\\", "\"", "-n"];
    let mut line = b"printf '%s\\0'".to_vec();
    for word in words {
        line.push(b' ');
        line.extend(quoted(word.as_bytes()));
    }
    let line = String::from_utf8(line).unwrap();
    let output = Command::new("sh").arg("-c").arg(line).output().unwrap();
    let wanted: String = words.iter().map(|w| format!("{w}\0")).collect();
    assert_eq!(String::from_utf8(output.stdout).unwrap(), wanted);
}

#[test]
fn parts_become_an_array_expression() {
    assert_eq!(array(&[1, 2, 3, 4], None), "1-4");
    assert_eq!(array(&[7], Some(2)), "7%2");
    assert_eq!(array(&[1, 2, 4, 6, 7, 8, 99], None), "1,2,4,6-8,99");
}

/// A script of GOOD in a folder of its own; the program prints its words.
fn example(out: &[u8], folder: &[u8]) -> String {
    example_of(b"echo", out, folder)
}

fn example_of(program: &[u8], out: &[u8], folder: &[u8]) -> String {
    let settings = Settings::parse(GOOD).unwrap();
    let arguments: Vec<&[u8]> = vec![b"my sweep.toml", b"--set", b"a='b'"];
    let finish: Vec<&[u8]> = vec![b"sweep", b"merge", out];
    let call = Call { program, command: "sweep", arguments, finish, out, folder };
    String::from_utf8(script(&settings, &call).unwrap()).unwrap()
}

#[test]
fn a_line_break_in_the_name_of_the_program_ends_no_comment() {
    let text = example_of(b"/opt/p\ntouch owned\n/x", b"/data/o", b"/home/me");
    let hint = text.lines().find(|line| line.starts_with("# When all parts are done")).unwrap();
    assert!(hint.contains("/opt/p?touch owned?/x"), "{hint}");
    // Elsewhere the name is one quoted word, which a shell gives back.
    assert!(text.contains("'/opt/p\ntouch owned\n/x' --jobs"), "{text}");
    assert_eq!(text.lines().filter(|line| *line == "touch owned").count(), 1, "{text}");
}

#[test]
fn the_script_says_what_the_settings_say() {
    let text = example(b"/data/o ut%", b"/home/me");
    for line in [
        "# `powergs-sim sweep` in 12 parts.",
        "# When all parts are done: echo sweep merge '/data/o ut%'",
        "#SBATCH --job-name=powergs-sweep",
        "#SBATCH --array=1-12%4",
        "#SBATCH --output=\"/data/o ut%%/slurm/%A_%a.log\"",
        "#SBATCH --open-mode=append",
        "#SBATCH --partition=long",
        "#SBATCH --cpus-per-task=4",
        "#SBATCH --exclusive",
        "#SBATCH --comment=\"two words; rm -rf #x\"",
        "export NOTE='it'\\''s $HOME'",
        "module load gcc  # the site's",
    ] {
        assert!(text.lines().any(|l| l == line), "`{line}` is not in:\n{text}");
    }
    assert!(!text.contains("no-requeue"), "false leaves an option out");
    let settings = Settings::parse("shards = 1").unwrap();
    let (program, out, none) = (b"p", b"/a\"b", Vec::new());
    let call = Call {
        program,
        command: "codesign",
        arguments: none.clone(),
        finish: none,
        out,
        folder: b"/",
    };
    assert!(script(&settings, &call).unwrap_err().to_string().contains("double quote"));
}

#[test]
fn the_script_runs_a_part_and_notes_its_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("o u't");
    std::fs::create_dir_all(out.join("slurm")).unwrap();
    let bytes = out.as_os_str().as_encoded_bytes();
    let text = example(bytes, folder.path().as_os_str().as_encoded_bytes());
    let run = |text: &str| {
        let mut bash = Command::new("bash");
        bash.args(["-c", text]).env("SLURM_ARRAY_JOB_ID", "77").env("SLURM_ARRAY_TASK_ID", "3");
        let output = bash.env("SLURM_CPUS_ON_NODE", "2").output().unwrap();
        let note = std::fs::read_to_string(out.join("slurm/77_3.exit")).ok();
        (output.status.code(), note, String::from_utf8(output.stdout).unwrap())
    };
    let good = text.replace("module load gcc", "true");
    let printed =
        format!("--jobs 2 sweep my sweep.toml --set a='b' --out {} --shard 3/12\n", out.display());
    assert_eq!(run(&good), (Some(0), Some("0\n".into()), printed));
    let (code, note, _) = run(&good.replace("ulimit -c 0", "false"));
    assert_eq!((code, note), (Some(125), Some("125\n".into())), "a line of setup failed");
    let (code, note, _) = run(&good.replace("\necho ", "\n(exit 3) && echo "));
    assert_eq!((code, note), (Some(3), Some("3\n".into())), "the program failed");
    let (code, note, _) = run(&good.replace("\necho ", "\nkill -9 $$; echo "));
    assert_eq!((code, note), (None, None), "killed: the old note is gone");
}

#[test]
fn the_number_of_a_job_is_read() {
    let job = |id: &str, cluster: Option<&str>| {
        Some(Submitted { id: id.into(), cluster: cluster.map(str::to_owned) })
    };
    assert_eq!(submitted("123\n"), job("123", None));
    assert_eq!(submitted("Welcome!\n123;east\n"), job("123", Some("east")));
    for text in ["", "Submitted batch job 12", "12;", "12;a b\u{7}", "-3", "9999999999999999999999"]
    {
        assert_eq!(submitted(text), None, "{text}");
    }
}

#[test]
fn states_of_tasks_are_read() {
    // As printed by `squeue --noheader --array --states=all --format=%i|%T|%r` of Slurm 22.05.
    let text = "1_6|COMPLETED|None\n1_3|FAILED|NonZeroExitCode\n1_2|NODE_FAIL|NodeDown\n\
                1_5|RUNNING|None\n1_7|PENDING|JobArrayTaskLimit\n1_8|CONFIGURING|None\n\
                12_9|RUNNING|None\n1_[10-12]|PENDING|Resources\n1|COMPLETED|None\nCLUSTER: east\n\
                1_4|TIMEOUT|TimeLimit\n1_9|COMPLETING|None";
    let found = states(text, "1");
    let wanted = [
        (2, State::Lost(Loss::Node)),
        (3, State::Failed),
        (4, State::Lost(Loss::Time)),
        (5, State::Running),
        (6, State::Completed),
        (7, State::Pending("JobArrayTaskLimit".into())),
        (8, State::Pending("None".into())),
        (9, State::Running),
    ];
    assert_eq!(found.into_iter().collect::<Vec<_>>(), wanted);
    let text = "5_1|CANCELLED by 1000\n5_2|OUT_OF_ME+\n5_3|OUT_OF_MEMORY\n5_1.batch|FAILED";
    let found = states(text, "5");
    assert_eq!(found[&1], State::Cancelled);
    assert_eq!(found[&3], State::Lost(Loss::Memory));
    assert_eq!(found.len(), 3);
}

#[test]
fn every_end_of_a_part_has_its_verdict() {
    let failed = Some(State::Failed);
    for (state, exit, wanted) in [
        (Some(State::Running), None, Verdict::Open),
        (Some(State::Pending(String::new())), Some(137), Verdict::Open), // requeued by Slurm
        (Some(State::Running), Some(0), Verdict::Done),
        (Some(State::Completed), None, Verdict::Done),
        (None, Some(0), Verdict::Done),
        (Some(State::Lost(Loss::Time)), None, Verdict::Lost(Loss::Time)),
        (Some(State::Lost(Loss::Node)), Some(0), Verdict::Done),
        (Some(State::Cancelled), Some(143), Verdict::Cancelled),
        (failed.clone(), Some(3), Verdict::Failed(3)),
        (failed.clone(), Some(4), Verdict::Failed(4)),
        (failed.clone(), Some(1), Verdict::Failed(1)),
        (failed.clone(), Some(2), Verdict::Lost(Loss::Refused)),
        (failed.clone(), Some(125), Verdict::Lost(Loss::Setup)),
        (failed.clone(), Some(127), Verdict::Lost(Loss::Start)),
        (failed.clone(), Some(130), Verdict::Lost(Loss::Killed(Some(2)))),
        (None, Some(137), Verdict::Lost(Loss::Killed(Some(9)))),
        (failed.clone(), None, Verdict::Unclear),
        (None, None, Verdict::Unclear),
    ] {
        assert_eq!(judge(state.as_ref(), exit), wanted, "{state:?} {exit:?}");
    }
    assert_eq!(given_up(failed.as_ref()), Loss::Killed(None));
    assert_eq!(given_up(None), Loss::Vanished);
}
