#!/usr/bin/env bash
# docs/start.md and docs/tutorial.md: the summaries that they show.
#
#   reproduce/tutorial.sh OUT
source "$(dirname "$0")/lib.sh"

# shown PAGE PRINTED: a `text` block of the page gets the lines that were printed, from the one
# on that looks like its own first.
shown() {
    awk '
        function looks(text) { gsub(/[0-9.]+/, "0", text); gsub(/ +/, " ", text); return text }
        FNR == NR { line[FNR] = $0; n = FNR; next }
        /^```text/ { block = 1; at = 0; print; next }
        /^```/ { block = 0 }
        block && block++ == 1 {
            for (i = n; i >= 1; i--) if (looks(line[i]) == looks($0)) at = i
        }
        block && at { print line[at++]; next }
        { print }
    ' "$2" "$root/$1" > page.md
    keep page.md "$1"
}

sim synth lego --points 30000 -o toy.ply --cameras toy.json --quiet
sim extract toy.ply --cameras toy.json --every 40 -o toy.bin --quiet
sim replay toy.bin --out first > printed.txt
shown docs/tutorial.md printed.txt

mkdir traces
cp "$root/traces/demo.bin" traces
{
    sim replay traces/demo.bin --set vru.units-per-core=32 --out wider | sed -n '/^frame/p'
    sim compare gscore edge traces/demo.bin --out pair
    sim replay traces/demo.bin --out demo
} > printed.txt
shown docs/start.md printed.txt
