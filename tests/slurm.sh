#!/usr/bin/env bash
# A sweep on a real Slurm: one machine, two nodes, in a temporary folder. A part is killed, a node
# goes down, and the program that follows is interrupted; the merged result must be, byte for byte,
# what one process writes. Skips, and says so in one line, where Slurm is not and cannot be
# installed.
#
# Usage: tests/slurm.sh [PROGRAM]          (default: target/release/powergs-sim)
#        tests/slurm.sh --install          installs what is missing, and no more
set -euo pipefail
cd "$(dirname "$0")/.."
[ "${1:-}" = --install ] || program=$(realpath "${1:-target/release/powergs-sim}")
[ -z "${program:-}" ] || [ -x "$program" ] || { echo "slurm.sh: $program is not there: cargo build --release" >&2; exit 2; }

say() { echo "slurm.sh: $*"; }
die() { say "FAILED: $*" >&2; exit 1; }

# Debian has the daemons where only root looks.
PATH=$PATH:/usr/sbin:/sbin
complete() { for c in munged slurmctld slurmd sbatch; do command -v "$c" > /dev/null || return 1; done; }

install() {
    local as=""
    if [ "$(id -u)" -ne 0 ]; then
        { command -v sudo && sudo -n true; } > /dev/null 2>&1 || return 1
        as="sudo -n"
    fi
    command -v apt-get > /dev/null || return 1
    local apt="env DEBIAN_FRONTEND=noninteractive timeout 120 apt-get -qq -o Dpkg::Use-Pty=0"
    $as $apt update > /dev/null 2>&1 || true
    $as $apt install -y --no-install-recommends slurm-wlm munge > /dev/null 2>&1
}
if ! complete; then
    say "installing slurm-wlm and munge"
    install && complete || { echo "skipped: slurm-wlm and munge cannot be installed here"; exit 0; }
fi
[ -n "${program:-}" ] || exit 0

# --- a cluster of two nodes -----------------------------------------------------------------------
work=$(mktemp -d "${TMPDIR:-/tmp}/powergs-slurm.XXXXXX")
chmod 755 "$work"
export SLURM_CONF=$work/slurm.conf
host=$(hostname -s)
user=$(id -un)
port=$((20000 + RANDOM % 20000))
follower=

stop() {
    # The processes of this run and no others: their ids are in files of this folder, their
    # arguments name it, or they work in it.
    local pids=() pid file
    [ -z "$follower" ] || pids+=("$follower")
    scancel --user="$user" 2> /dev/null || true
    for _ in $(seq 50); do
        [ -n "$(squeue -h 2> /dev/null)" ] || break
        sleep 0.1
    done
    for file in "$work"/slurmd-*.pid "$work/slurmctld.pid" "$work/munge/pid"; do
        pid=$(cat "$file" 2> /dev/null) && pids+=("$pid")
    done
    for pid in $(pgrep -f -- "$work/"); do pids+=("$pid"); done
    for pid in $(pgrep slurmstepd); do
        case $(readlink "/proc/$pid/cwd") in "$work"*) pids+=("$pid") ;; esac
    done
    for pid in "${pids[@]}"; do kill "$pid" 2> /dev/null || true; done
    for _ in $(seq 100); do
        gone "${pids[@]}" && break
        sleep 0.1
    done
    for pid in "${pids[@]}"; do kill -9 "$pid" 2> /dev/null || true; done
    rm -rf "$work"
}
# Whether no process of a list is left; one that only waits to be reaped is gone.
gone() {
    local pid
    for pid; do
        [ ! -e "/proc/$pid/stat" ] || grep -q ') Z ' "/proc/$pid/stat" 2> /dev/null || return 1
    done
}
trap stop EXIT
trap 'exit 130' INT TERM

mkdir "$work/state" "$work/munge"
dd if=/dev/urandom of="$work/munge.key" bs=1024 count=1 status=none
chmod 600 "$work/munge.key"
cat > "$SLURM_CONF" <<END
ClusterName=powergs
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket
CredType=cred/munge
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool-%n
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd-%n.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,bf_interval=1,batch_sched_delay=0
ReturnToService=2
KillWait=2
MailProg=/bin/true
NodeName=n1 NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 1)) CPUs=1 State=UNKNOWN
NodeName=n2 NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 2)) CPUs=1 State=UNKNOWN
PartitionName=all Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
END
munged --socket="$work/munge/socket" --key-file="$work/munge.key" --pid-file="$work/munge/pid" \
    --log-file="$work/munge/log" --seed-file="$work/munge/seed" --num-threads=2
slurmctld
slurmd -N n1
slurmd -N n2
for _ in $(seq 100); do
    [ "$(sinfo -h -N -t idle 2> /dev/null | wc -l)" -eq 2 ] && break
    sleep 0.2
done
[ "$(sinfo -h -N -t idle | wc -l)" -eq 2 ] || { tail "$work"/*.log; die "the nodes do not come up"; }
say "$(sinfo --version) runs with two nodes"

# --- a sweep on one machine -----------------------------------------------------------------------
sweep=$work/'units & sizes.toml'
cat > "$sweep" <<'END'
question = "Does Slurm get the same results?"
base = "gscore"
set = { "dram.model" = "bandwidth" }
[[axes]]
key = "vru.cores"
range = { from = 1, to = 12, step = 1 }
[[axes]]
key = "dram.efficiency"
range = { from = 0.002, to = 1.0, step = 0.002 }
END
cp traces/demo.bin "$work/demo.bin"
arguments=("$sweep" --traces "$work/demo.bin")
"$program" sweep "${arguments[@]}" --out "$work/local" --jobs 2 --quiet
say "one process is done: $(($(wc -l < "$work/local/results.csv") - 1)) rows"

# --- the same on Slurm ----------------------------------------------------------------------------
out=$work/'on slurm'
cat > "$work/sbatch.toml" <<END
shards = 6
poll = "0.5 s"
setup = ["ulimit -c 0"]
[environment]
NOTE = "it's a test"
[sbatch]
time = 5
cpus-per-task = 1
no-requeue = true
END
on_slurm=(sweep "${arguments[@]}" --out "$out" --slurm "$work/sbatch.toml")
"$program" "${on_slurm[@]}" --print > "$work/printed.sh"
bash -n "$work/printed.sh"
[ ! -e "$out" ] || die "--print made the folder"

log=$work/follow.log
"$program" "${on_slurm[@]}" 2> "$log" &
follower=$!

# Waits until a part has results, then runs a command.
journal() { printf '%s/records/shard-%05d-of-00006.jsonl' "$out" "$1"; }
when_under_way() {
    local part=$1; shift
    for _ in $(seq 6000); do
        [ ! -s "$(journal "$part")" ] || { "$@" "$part"; return; }
        sleep 0.01
    done
    cat "$log"; die "part $part does not begin"
}
kill_part() {
    local pid
    pid=$(pgrep -f -- "--out $out --shard $1/6") || die "part $1 ended before it was killed"
    kill -9 "$pid"
    say "killed part $1"
}
lose_node() {
    local job node pid script
    job=$(sed -n 's/^id = "\(.*\)"/\1/p' "$out/slurm/job.toml" | head -n 1)
    pid=$(pgrep -f -- "--out $out --shard $1/6") || die "part $1 ended before its node was lost"
    script=$(ps -o ppid= -p "$pid" | tr -d ' ')
    # A node that is gone says nothing about its tasks.
    kill -STOP "$script" "$pid"
    node=$(squeue -h -t running -o %N -j "${job}_$1")
    scontrol update nodename="$node" state=down reason=test
    kill -9 "$script" "$pid"
    say "lost node $node with part $1"
    sleep 1
    # It may have come back by itself.
    scontrol update nodename="$node" state=resume 2> /dev/null || true
}
interrupt() {
    kill -INT "$follower"
    local code=0
    wait "$follower" || code=$?
    follower=
    [ "$code" -eq 130 ] || { cat "$log"; die "exit code $code after Ctrl-C, not 130"; }
    grep -q -- "--resume" "$log" || die "Ctrl-C does not say how to follow again"
    say "interrupted the program that follows"
}
when_under_way 2 kill_part
when_under_way 3 lose_node
when_under_way 4 interrupt
"$program" "${on_slurm[@]}" --resume --json > "$work/merged.json" 2>> "$log" || {
    cat "$log"; die "following again"
}
grep -q "lost part 2: killed by signal 9" "$log" || { cat "$log"; die "the kill went unnoticed"; }
grep -q "lost part.* 3.*: its node failed" "$log" || { cat "$log"; die "the node went unnoticed"; }

# --- the same result ------------------------------------------------------------------------------
n=0
while read -r file; do
    cmp "$work/local/$file" "$out/$file" || die "$file differs"
    n=$((n + 1))
done < <(cd "$work/local" && find . -type f ! -path './records/*' \
    \( -name '*.csv' -o -name '*.parquet' -o -name '*.md' -o -name '*.svg' -o -name '*.png' \
    -o -name '*.html' \) | sort)
[ "$n" -ge 4 ] || die "only $n files were compared"
say "passed: $n files are byte for byte those of one process"
