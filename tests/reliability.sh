#!/usr/bin/env bash
# What may happen to a sweep: killed twenty times, two processes in one folder, a full disk, a
# folder that cannot be written, changed inputs, Ctrl-C, a file of a million points. Nothing may be
# lost, and what is finished must be, byte for byte, what an undisturbed run writes.
#
# Usage: tests/reliability.sh [PROGRAM] [SEED]          (default: target/release/powergs-sim 1)
set -euo pipefail
cd "$(dirname "$0")/.."
program=$(realpath "${1:-target/release/powergs-sim}")
[ -x "$program" ] || { echo "reliability.sh: $program is not there" >&2; exit 2; }
RANDOM=${2:-1}

work=$(mktemp -d "${TMPDIR:-/tmp}/powergs-reliability.XXXXXX")
running=
mounted=
finish() {
    [ -z "$running" ] || kill -9 "$running" 2> /dev/null || true
    [ -z "$mounted" ] || umount "$mounted" 2> /dev/null || true
    rm -rf "$work"
}
trap finish EXIT
trap 'exit 130' INT TERM

say() { echo "reliability.sh: $*"; }
die() { say "FAILED: $*" >&2; [ ! -s "$work/log" ] || tail -n 20 "$work/log" >&2; exit 1; }

# Runs the program; its exit code is in `code`, what it says in $work/log.
attempt() {
    code=0
    "$program" "$@" > "$work/log" 2>&1 || code=$?
}
wants() { # CODE TEXT WHAT
    [ "$code" -eq "$1" ] || die "$3: exit code $code, not $1"
    grep -qi -- "$2" "$work/log" || die "$3: does not say \"$2\""
}
# All results in two folders, and those of their analysis.
same() {
    local file n=0
    while read -r file; do
        cmp "$1/$file" "$2/$file" || die "$3: $file differs"
        n=$((n + 1))
    done < <(cd "$1" && find . -type f ! -path './records/*' \
        \( -name '*.csv' -o -name '*.parquet' -o -name '*.md' -o -name '*.svg' -o -name '*.png' \
        -o -name '*.html' \) | sort)
    [ "$n" -ge 2 ] || die "$3: only $n files were compared"
}

cp traces/demo.bin "$work/demo.bin"
cat > "$work/sweep.toml" <<'END'
question = "Does this folder survive?"
base = "gscore"
set = { "dram.model" = "bandwidth" }
[[axes]]
key = "vru.cores"
range = { from = 1, to = 12, step = 1 }
[[axes]]
key = "dram.efficiency"
range = { from = 0.005, to = 1.0, step = 0.005 }
END
sweep=(sweep "$work/sweep.toml" --traces "$work/demo.bin" --jobs 2)

begun=$(date +%s%N)
attempt "${sweep[@]}" --out "$work/whole"
[ "$code" -eq 0 ] || die "the undisturbed run: exit code $code"
took_ms=$((($(date +%s%N) - begun) / 1000000))
say "undisturbed: $(($(wc -l < "$work/whole/results.csv") - 1)) rows in $took_ms ms"

# --- killed twenty times --------------------------------------------------------------------------
# A moment between the start and the end of an undisturbed run, seconds.
moment() {
    local us=$(((RANDOM * 32768 + RANDOM) % (took_ms * 1000)))
    printf '%d.%06d' $((us / 1000000)) $((us % 1000000))
}
kills=0
late=0
while [ "$kills" -lt 20 ]; do
    rm -rf "$work/killed"
    "$program" "${sweep[@]}" --out "$work/killed" > "$work/log" 2>&1 &
    running=$!
    sleep "$(moment)"
    kill -9 "$running" 2> /dev/null || true
    code=0
    wait "$running" 2> /dev/null || code=$?
    running=
    case $code in
    137) kills=$((kills + 1)) ;;
    0) late=$((late + 1)) ;;
    *) die "before kill $kills: exit code $code" ;;
    esac
    [ "$late" -le 60 ] || die "the sweep is too short to be killed"
    resume=()
    [ ! -e "$work/killed/state.toml" ] || resume=(--resume)
    attempt "${sweep[@]}" --out "$work/killed" "${resume[@]}"
    [ "$code" -eq 0 ] || die "the run after kill $kills: exit code $code"
    same "$work/whole" "$work/killed" "after kill $kills"
done
say "killed $kills times (and $late times too late): the same results"

# --- Ctrl-C ---------------------------------------------------------------------------------------
under_way() { # FOLDER: waits until there are results
    for _ in $(seq 3000); do
        [ -z "$(find "$1/records" -name '*.jsonl' -size +0 2> /dev/null)" ] || return 0
        sleep 0.01
    done
    die "no results in $1"
}
"$program" "${sweep[@]}" --out "$work/interrupted" > "$work/log" 2>&1 &
running=$!
under_way "$work/interrupted"
kill -INT "$running"
code=0
wait "$running" || code=$?
running=
wants 130 "--resume" "Ctrl-C"
[ ! -e "$work/interrupted/results.csv" ] || die "Ctrl-C: there are results already"
attempt sweep status "$work/interrupted"
wants 0 "missing" "status after Ctrl-C"
attempt "${sweep[@]}" --out "$work/interrupted"
wants 2 "--resume" "the same folder without --resume"
attempt "${sweep[@]}" --out "$work/interrupted" --resume
[ "$code" -eq 0 ] || die "after Ctrl-C: exit code $code"
same "$work/whole" "$work/interrupted" "after Ctrl-C"
say "Ctrl-C: continued"

# --- two processes --------------------------------------------------------------------------------
"$program" "${sweep[@]}" --out "$work/shared" > "$work/first.log" 2>&1 &
running=$!
under_way "$work/shared"
attempt "${sweep[@]}" --out "$work/shared" --resume
wants 2 "another process" "two processes"
code=0
wait "$running" || code=$?
running=
[ "$code" -eq 0 ] || die "the first of two processes: exit code $code"
same "$work/whole" "$work/shared" "two processes"
say "two processes: the second refuses, the first is not disturbed"

# --- parts ----------------------------------------------------------------------------------------
pids=()
for part in 1 2 3; do
    POWERGS_SHARD=$part/3 "$program" "${sweep[@]}" --out "$work/parts" > "$work/part$part" 2>&1 &
    pids+=($!)
done
under_way "$work/parts"
kill -9 "${pids[1]}"
for pid in "${pids[0]}" "${pids[2]}"; do
    wait "$pid" || { cp "$work"/part[13] "$work/log"; die "a part beside a killed one failed"; }
done
wait "${pids[1]}" 2> /dev/null || true
attempt sweep merge "$work/parts"
wants 1 "parts* 2" "merge with a part missing"
attempt "${sweep[@]}" --out "$work/parts" --shard 2/3
[ "$code" -eq 0 ] || die "a part again: exit code $code"
attempt sweep merge "$work/parts"
[ "$code" -eq 0 ] || die "merge: exit code $code"
same "$work/whole" "$work/parts" "three parts, one of them killed"
attempt "${sweep[@]}" --out "$work/apart1" --shard 1/2
attempt "${sweep[@]}" --out "$work/apart2" --shard 2/2
attempt sweep merge "$work/apart1" --from "$work/apart2"
[ "$code" -eq 0 ] || die "merge of two folders: exit code $code"
same "$work/whole" "$work/apart1" "two folders"
attempt "${sweep[@]}" --out "$work/single" --shard 1/1
attempt "${sweep[@]}" --out "$work/single" --shard 1/1
[ "$code" -eq 0 ] || die "the only part, twice: exit code $code"
attempt sweep merge "$work/single"
same "$work/whole" "$work/single" "one part"
say "parts: the same results"

# --- a full disk ----------------------------------------------------------------------------------
full() { # FOLDER
    wants 2 "cannot be written\|no space\|too large" "a full disk"
    [ ! -e "$1/results.csv" ] || die "a full disk: half a table"
}
mkdir "$work/small"
if mount -t tmpfs -o size=64k none "$work/small" 2> /dev/null; then
    mounted=$work/small
    attempt "${sweep[@]}" --out "$work/small/s"
    full "$work/small/s"
    mount -o remount,size=64m "$work/small"
    attempt "${sweep[@]}" --out "$work/small/s" --resume
    [ "$code" -eq 0 ] || die "after making room: exit code $code"
    same "$work/whole" "$work/small/s" "after a full disk"
    umount "$work/small"
    mounted=
    say "a full disk (tmpfs): said so, and continued"
fi
# A limit on the size of files does the same where nothing can be mounted.
code=0
(ulimit -f 32; trap '' XFSZ; "$program" "${sweep[@]}" --out "$work/limited") > "$work/log" 2>&1 || code=$?
full "$work/limited"
attempt "${sweep[@]}" --out "$work/limited" --resume
[ "$code" -eq 0 ] || die "without the limit: exit code $code"
same "$work/whole" "$work/limited" "after a full disk"
say "a limit on files: said so, and continued"

# --- a folder that cannot be written --------------------------------------------------------------
mkdir "$work/readonly"
if mount -t tmpfs -o size=1m,ro none "$work/readonly" 2> /dev/null; then
    mounted=$work/readonly
    attempt "${sweep[@]}" --out "$work/readonly/s"
    wants 2 "read-only" "a read-only file system"
    umount "$work/readonly"
    mounted=
    say "a read-only folder: said so"
elif [ "$(id -u)" -ne 0 ]; then
    chmod 555 "$work/readonly"
    attempt "${sweep[@]}" --out "$work/readonly/s"
    wants 2 "denied" "a read-only folder"
    say "a read-only folder: said so"
else
    say "skipped: a read-only folder (nothing can be mounted, and root writes everywhere)"
fi
: > "$work/file"
attempt "${sweep[@]}" --out "$work/file"
[ "$code" -eq 2 ] || die "--out is a file: exit code $code"
mkdir "$work/foreign" && : > "$work/foreign/thesis.tex"
attempt "${sweep[@]}" --out "$work/foreign" --force
wants 2 "another folder" "a folder of something else"
[ -e "$work/foreign/thesis.tex" ] || die "--force removed a file that is not ours"

# --- inputs that change ---------------------------------------------------------------------------
"$program" "${sweep[@]}" --out "$work/changed" > "$work/log" 2>&1 &
running=$!
under_way "$work/changed"
kill -9 "$running"
wait "$running" 2> /dev/null || true
running=
cp "$work/demo.bin" "$work/kept.bin"
lines=$(cat "$work"/changed/records/*.jsonl | wc -l)
attempt synth demo --points 3000 --seed 5 -o "$work/other.ply"
attempt extract "$work/other.ply" --orbit 1 --size 64x64 -o "$work/other.bin"
[ "$code" -eq 0 ] || die "another trace cannot be made"
mv "$work/other.bin" "$work/demo.bin"
attempt "${sweep[@]}" --out "$work/changed" --resume
wants 2 "has changed" "another trace"
cp "$work/kept.bin" "$work/demo.bin"
[ "$(cat "$work"/changed/records/*.jsonl | wc -l)" -ge "$lines" ] || die "another trace: results are lost"
cp "$work/changed/state.toml" "$work/state"
sed -i 's/^model-version = .*/model-version = 1000/' "$work/changed/state.toml"
attempt "${sweep[@]}" --out "$work/changed" --resume
wants 2 "version of the model" "a folder of another model"
cp "$work/state" "$work/changed/state.toml"
attempt "${sweep[@]}" --out "$work/changed" --resume
[ "$code" -eq 0 ] || die "with the old inputs again: exit code $code"
same "$work/whole" "$work/changed" "with the old inputs again"
say "a changed trace and another model: refused, nothing lost"

# --- a store --------------------------------------------------------------------------------------
attempt "${sweep[@]}" --out "$work/stored1" --store "$work/store"
[ "$code" -eq 0 ] || die "with a store: exit code $code"
attempt "${sweep[@]}" --out "$work/stored2" --store "$work/store"
same "$work/whole" "$work/stored2" "from a store"
for model in "$work/store"/model-*; do mv "$model" "$work/store/model-1000.1"; done
attempt "${sweep[@]}" --out "$work/stored3" --store "$work/store"
wants 0 "other versions" "a store of another model"
same "$work/whole" "$work/stored3" "a store of another model"
[ -d "$work/store/model-1000.1" ] || die "a store of another model: it is gone"
for journal in "$work/store"/model-*/*.jsonl; do
    dd if=/dev/urandom of="$journal" bs=1 count=600 seek=100 conv=notrunc status=none
done
attempt "${sweep[@]}" --out "$work/stored4" --store "$work/store"
same "$work/whole" "$work/stored4" "a damaged store"
say "stores: of another model, and damaged"

# --- damaged journals -----------------------------------------------------------------------------
cp -r "$work/whole" "$work/damaged"
rm "$work/damaged/results.csv"
for journal in "$work/damaged/records"/*.jsonl; do
    dd if=/dev/urandom of="$journal" bs=1 count=5000 seek=1000 conv=notrunc status=none
    truncate -s -7 "$journal"
done
attempt "${sweep[@]}" --out "$work/damaged" --resume
wants 0 "damaged" "damaged journals"
same "$work/whole" "$work/damaged" "damaged journals"
say "damaged journals: simulated again"

# --- a million points -----------------------------------------------------------------------------
cat > "$work/million.toml" <<'END'
question = "Does a million fit?"
base = "gscore"
set = { "dram.model" = "bandwidth" }
[[axes]]
key = "vru.cores"
range = { from = 1, to = 1000, step = 1 }
[[axes]]
key = "dram.efficiency"
range = { from = 0.001, to = 1.0, step = 0.001 }
END
code=0
/usr/bin/env bash -c 'ulimit -v 4000000; "$@" & pid=$!; peak=0
    while kill -0 "$pid" 2> /dev/null; do
        now=$(sed -n "s/^VmHWM:[[:space:]]*\([0-9]*\) kB/\1/p" /proc/$pid/status 2> /dev/null)
        peak=${now:-$peak}; sleep 0.05
    done
    wait "$pid"; code=$?; echo "peak $peak kB"; exit $code' bash \
    "$program" sweep "$work/million.toml" --traces "$work/demo.bin" --dry-run > "$work/log" 2>&1 || code=$?
[ "$code" -eq 0 ] || die "a million points: exit code $code"
peak=$(sed -n 's/^peak \([0-9]*\) kB/\1/p' "$work/log")
[ "$peak" -lt 300000 ] || die "a million points: $peak kB"
say "a million points, looked at: $((peak / 1000)) MB"
say "passed"
