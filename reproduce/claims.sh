#!/usr/bin/env bash
# The claims table of evidence/claims.md, and evidence/claims.csv with the answer of every run, by
# the laboratory. Hours; never part of `all`.
#
#   reproduce/claims.sh OUT [SCENES]
#
# Needs powergs-lab beside powergs-sim (cargo build --release -p powergs-sim -p powergs-lab).
# SCENES is a folder with trained scenes as lab/claims.sh names them; they are of others and not
# part of the repository. Without it only the demonstration runs, an hour, and the page written has
# its columns alone. A second call with the same OUT goes on where the first was stopped.
source "$(dirname "$0")/lib.sh"

lab=$(dirname "$program")/powergs-lab
[ -x "$lab" ] ||
    fail "there is no $lab: cargo build --release -p powergs-sim -p powergs-lab"
mkdir none
"$root/lab/claims.sh" "$program" "${2:-none}" "$out/runs"
keep "$out/runs/claims.md" evidence/claims.md
# The rows of `## By run` as CSV.
{
    echo claim,run,here,agrees
    awk -F ' [|] ' '
        function cell(text) {
            gsub(/^[|] | [|]$/, "", text)
            gsub(/\\[|]/, "|", text)
            gsub(/\\`/, "`", text)
            gsub(/"/, "\"\"", text)
            return text ~ /[",]/ ? "\"" text "\"" : text
        }
        /^## / { on = /^## By run/; row = 0 }
        on && /^[|]/ && ++row > 2 { print cell($1) "," cell($2) "," cell($3) "," cell($4) }
    ' "$out/runs/claims.md"
} > claims.csv
keep claims.csv evidence/claims.csv
