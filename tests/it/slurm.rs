//! `sweep --slurm` and `codesign --slurm` against commands that answer as Slurm's do: tasks run at
//! once, and those that the test names are lost instead.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

use crate::codesign;

/// Runs every task of the array, or loses it in the state that the file `lose-TASK` names, once.
const SBATCH: &str = r#"#!/bin/sh
n=$(($(cat jobs 2> /dev/null || echo 100) + 1))
echo $n > jobs
list=${2#--array=}
for range in $(echo "${list%%\%*}" | tr , ' '); do
    for task in $(seq "${range%-*}" "${range#*-}"); do
        state=COMPLETED
        if [ -e "lose-$task" ]; then
            state=$(cat "lose-$task")
            [ -e always ] || rm "lose-$task"
        else
            SLURM_ARRAY_JOB_ID=$n SLURM_ARRAY_TASK_ID=$task SLURM_CPUS_ON_NODE=1 \
                bash "$3" > "out/slurm/${n}_$task.log" 2>&1 || state=FAILED
        fi
        echo "${n}_$task|$state|None" >> "states-$n"
    done
done
echo "$n"
"#;

const SQUEUE: &str = r#"#!/bin/sh
for argument; do
    case $argument in --jobs=*) job=${argument#--jobs=} ;; esac
done
[ ! -e away ] || { rm away; echo "squeue: error: Unable to contact slurm controller" >&2; exit 1; }
[ ! -e forgotten ] || { echo "slurm_load_jobs error: Invalid job id specified" >&2; exit 1; }
cat "states-$job"
"#;

const SWEEP: &str = r#"
question = "Does it come back?"
base = "gscore"
[[axes]]
key = "vru.cores"
values = [1, 2, 3, 4, 5, 6]
"#;

/// A folder with the commands, the sweep and its settings.
struct Cluster(tempfile::TempDir);

impl Cluster {
    fn new(settings: &str) -> Cluster {
        let cluster = Cluster(tempfile::tempdir().unwrap());
        for (name, text) in [("sbatch", SBATCH), ("squeue", SQUEUE)] {
            let path = cluster.path().join("bin").join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, text).unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
        }
        cluster.write("sweep.toml", SWEEP);
        cluster.write("sbatch.toml", &format!("shards = 3\npoll = \"100 ms\"\n{settings}"));
        cluster
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path().join(name), text).unwrap();
    }

    /// The program in this folder, with only the commands of this folder and of the system.
    fn program(&self, words: &[&str]) -> Command {
        let mut program = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
        let path = format!("{}:/usr/bin:/bin", self.path().join("bin").display());
        program.current_dir(self.path()).env("PATH", path).args(words);
        program
    }

    fn sweep(&self, more: &[&str]) -> Command {
        let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/demo.bin");
        let mut program = self.program(&["sweep", "sweep.toml", "--frames", "..1"]);
        program.args(["--traces", demo]).args(more);
        program
    }

    /// A co-design of the files that `codesign::stage` writes.
    fn codesign(&self, more: &[&str]) -> Command {
        let mut program = self.program(&["codesign", "tiny.ply", "--cameras", "cameras.json"]);
        program.args(["--space", "space.toml", "--quality-db", "22", "--background", "0.5,0,0"]);
        program.args(["--iterations", "20", "--interval", "4"]).args(more);
        program
    }

    fn on_slurm(&self, more: &[&str]) -> Command {
        let mut program = self.sweep(&["--out", "out", "--slurm", "sbatch.toml"]);
        program.args(more);
        program
    }

    fn jobs(&self) -> String {
        fs::read_to_string(self.path().join("jobs")).unwrap_or_default()
    }
}

/// All results in a folder and in that of its analysis, by path.
fn results(folder: PathBuf) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files = Vec::new();
    for inside in ["", "analysis"] {
        let Ok(entries) = fs::read_dir(folder.join(inside)) else { continue };
        for entry in entries {
            let path = entry.unwrap().path();
            let ending = path.extension().unwrap_or_default().to_string_lossy().into_owned();
            if ["csv", "parquet", "md", "svg", "png", "html"].contains(&ending.as_str()) {
                let name = path.strip_prefix(&folder).unwrap().to_owned();
                files.push((name, fs::read(path).unwrap()));
            }
        }
    }
    files.sort();
    assert!(files.len() >= 2, "results.csv and results.parquet at least");
    files
}

#[test]
fn lost_parts_are_submitted_again_and_the_result_is_that_of_one_process() {
    let cluster = Cluster::new("");
    cluster.write("lose-1", "NODE_FAIL");
    cluster.write("lose-3", "OUT_OF_MEMORY");
    cluster.write("away", "");
    let lost = contains("lost part 1: its node failed").and(contains("lost part 3: out of memory"));
    let patient = contains("Unable to contact slurm controller (asking again)");
    cluster.on_slurm(&[]).assert().success().stderr(lost.and(patient));
    assert_eq!(cluster.jobs(), "102\n", "one job of three parts, one of two");
    cluster.sweep(&["--out", "local", "--jobs", "2"]).assert().success();
    assert!(results(cluster.path().join("out")) == results(cluster.path().join("local")));

    cluster.on_slurm(&[]).assert().code(2).stderr(contains("--resume"));
    // Slurm forgets jobs after some minutes: what the tasks have noted is enough.
    cluster.write("forgotten", "");
    cluster.on_slurm(&["--resume"]).assert().success();
    assert_eq!(cluster.jobs(), "102\n", "nothing was left to do");
}

#[test]
fn the_same_command_follows_only_the_same_sweep() {
    let cluster = Cluster::new("retries = 0");
    cluster.write("lose-2", "TIMEOUT");
    let told = contains("part 2: time limit").and(contains("--resume submits"));
    cluster.on_slurm(&[]).assert().code(1).stderr(told);
    cluster.on_slurm(&["--resume", "--points", "2"]).assert().code(2);
    cluster.write("sbatch.toml", "shards = 4");
    cluster.on_slurm(&["--resume"]).assert().code(2).stderr(contains("shards = 4"));
    cluster.write("sbatch.toml", "shards = 3\npoll = \"100 ms\"\n[sbatch]\ntime = 60");
    cluster.on_slurm(&["--resume"]).assert().success().stderr(contains("submitted 1 part\n"));
}

#[test]
fn what_would_fail_again_is_not_submitted_again() {
    let cluster = Cluster::new("retries = 2\nprogram = \"./broken\"");
    cluster.write("broken", "#!/bin/sh\necho 'error: room.bin: damaged at byte 12'\nexit 3\n");
    fs::set_permissions(cluster.path().join("broken"), fs::Permissions::from_mode(0o755)).unwrap();
    let told = contains("exit code 3").and(contains("damaged at byte 12"));
    cluster.on_slurm(&[]).assert().code(3).stderr(told);
    assert_eq!(cluster.jobs(), "101\n");
    cluster.write("broken", "#!/bin/sh\nkill -9 $$\n");
    let told = contains("lost parts 1, 2, 3: killed by signal 9").and(contains("2 retries"));
    cluster.on_slurm(&["--resume"]).assert().code(1).stderr(told);
    assert_eq!(cluster.jobs(), "104\n", "one for --resume, two retries");
}

#[test]
fn cancelled_parts_stay_cancelled() {
    let cluster = Cluster::new("");
    cluster.write("lose-2", "CANCELLED");
    cluster.on_slurm(&[]).assert().code(1).stderr(contains("part 2: cancelled"));
    assert_eq!(cluster.jobs(), "101\n");
    cluster.on_slurm(&["--resume"]).assert().success();
}

#[test]
fn without_slurm_there_is_the_script() {
    let cluster = Cluster::new("");
    let print = cluster.on_slurm(&["--print"]).assert().success();
    let script = String::from_utf8(print.get_output().stdout.clone()).unwrap();
    assert!(script.starts_with("#!/bin/bash\n") && script.contains("--array=1-3\n"), "{script}");
    assert!(!cluster.path().join("out").exists());
    let nowhere = cluster.path().join("nowhere");
    cluster.on_slurm(&[]).env("PATH", nowhere).assert().code(2).stderr(contains("--print"));
    cluster.write("sbatch.toml", "shards = 3\nretires = 1");
    cluster.on_slurm(&[]).assert().code(2).stderr(contains("did you mean `retries`"));
}

#[test]
fn a_codesign_in_parts_is_that_of_one_process() {
    let cluster = Cluster::new("");
    codesign::stage(cluster.path(), codesign::SPACE, 12);
    let on_slurm = |more: &[&str]| {
        let mut program = cluster.codesign(&["--out", "out", "--slurm", "sbatch.toml"]);
        program.args(more);
        program
    };
    let print = on_slurm(&["--print"]).assert().success();
    let script = String::from_utf8(print.get_output().stdout.clone()).unwrap();
    for line in ["# `powergs-sim codesign` in 3 parts.", "#SBATCH --job-name=powergs-codesign"] {
        assert!(script.lines().any(|l| l == line), "`{line}` is not in:\n{script}");
    }
    assert!(!cluster.path().join("out").exists());

    cluster.write("lose-1", "NODE_FAIL");
    cluster.write("lose-3", "TIMEOUT");
    let lost = contains("lost part 1: its node failed").and(contains("lost part 3: time limit"));
    on_slurm(&[]).assert().success().stderr(lost);
    assert_eq!(cluster.jobs(), "102\n", "one job of three parts, one of two");
    cluster.codesign(&["--out", "local", "--jobs", "2"]).assert().success();
    let [out, local] = ["out", "local"].map(|name| codesign::contents(&cluster.path().join(name)));
    for (now, before) in out.iter().zip(&local) {
        assert!(now.1 == before.1, "{} differs", now.0);
    }

    on_slurm(&[]).assert().code(2).stderr(contains("go on with --resume"));
    on_slurm(&["--resume", "--seed", "8"]).assert().code(2).stderr(contains("holds another run"));
    // What the tasks have noted is enough; another number of rounds only changes the end.
    cluster.write("forgotten", "");
    on_slurm(&["--resume", "--rounds", "0"]).assert().success();
    assert_eq!(cluster.jobs(), "102\n", "nothing was left to do");
}

#[test]
fn the_parts_of_a_codesign_that_are_missing_are_submitted_with_resume() {
    let cluster = Cluster::new("retries = 0");
    codesign::stage(cluster.path(), codesign::SPACE, 12);
    cluster.write("lose-2", "OUT_OF_MEMORY");
    let mut on_slurm = cluster.codesign(&["--out", "out", "--slurm", "sbatch.toml"]);
    on_slurm.assert().code(1).stderr(contains("part 2: out of memory"));
    assert!(!cluster.path().join("out/summary.md").exists(), "nothing is compared");
    on_slurm.arg("--resume").assert().success().stderr(contains("submitted 1 part\n"));
    assert!(cluster.path().join("out/summary.md").exists());
    // A run that begins anew forgets the jobs of the old one.
    cluster.codesign(&["--out", "out", "--force"]).assert().success();
    assert!(!cluster.path().join("out/slurm").exists());
}

#[test]
fn the_script_of_a_codesign_can_be_submitted_by_hand() {
    let cluster = Cluster::new("");
    codesign::stage(cluster.path(), codesign::SPACE, 12);
    let mut print = cluster.codesign(&["--out", "out", "--slurm", "sbatch.toml", "--print"]);
    let script = print.assert().success().get_output().stdout.clone();
    fs::create_dir_all(cluster.path().join("out/slurm")).unwrap();
    for task in ["1", "2", "3"] {
        let mut bash = Command::new("bash");
        bash.env("SLURM_ARRAY_JOB_ID", "7").env("SLURM_ARRAY_TASK_ID", task);
        bash.write_stdin(script.clone()).assert().success();
    }
    let text = String::from_utf8(script).unwrap();
    let finish = text.lines().find_map(|l| l.strip_prefix("# When all parts are done: ")).unwrap();
    Command::new("sh").current_dir(cluster.path()).args(["-c", finish]).assert().success();
    assert!(cluster.path().join("out/summary.md").exists());
}
