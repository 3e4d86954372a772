# What every script here begins with: `source` it. The caller's first argument is the folder to
# write to; files get the same path in it as in the repository.
#
# Sets root (the checkout), out (that folder), work (a temporary folder, the current one from here
# on, removed at the end) and program (powergs-sim). See README.md.
# shellcheck shell=bash
set -euo pipefail
trap 'exit 130' INT
trap 'exit 143' TERM

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

fail() {
    echo "${0##*/}: $*" >&2
    exit 2
}

# The comment at the top of a script.
usage() {
    sed -n '2,/^[^#]/{/^#/s/^# \{0,1\}//p}' "$0"
    exit "$1"
}

find_program() {
    local built=$root/target/release/powergs-sim
    if [ -n "${POWERGS_SIM:-}" ]; then
        command -v "$POWERGS_SIM" > /dev/null || fail "POWERGS_SIM=$POWERGS_SIM: no such program"
        realpath "$(command -v "$POWERGS_SIM")"
    elif command -v powergs-sim > /dev/null; then
        realpath "$(command -v powergs-sim)"
    elif [ -x "$built" ]; then
        echo "$built"
    else
        fail "there is no powergs-sim: run \`cargo build --release\` in $root," \
            "or put the place of the program into POWERGS_SIM"
    fi
}

# keep FILE PATH: a result, under its path in the repository.
keep() {
    mkdir -p "$out/$(dirname "$2")"
    cp "$1" "$out/$2"
}

# checked WHAT same|differs: the outcome of a check that makes no file.
checked() {
    printf '%s\t%s\n' "$1" "$2" >> "$out/checked.txt"
}

sim() {
    "$program" "$@"
}

case ${1:-} in
    -h | --help) usage 0 ;;
    '' | -*) usage 2 >&2 ;;
esac
program=$(find_program)
export POWERGS_SIM=$program
mkdir -p "$1"
out=$(cd "$1" && pwd)
work=$(mktemp -d "${TMPDIR:-/tmp}/powergs-reproduce.XXXXXX")
trap 'rm -rf "$work"' EXIT
cd "$work"
