#!/usr/bin/env bash
# docs/tutorial.md: the summaries that it shows, of the toy scene that it makes.
#
#   reproduce/tutorial.sh OUT
#
# A `text` block of the page gets the lines of this run from the one on that looks like its first.
source "$(dirname "$0")/lib.sh"

page=docs/tutorial.md
sim synth lego --points 30000 -o toy.ply --cameras toy.json --quiet
sim extract toy.ply --cameras toy.json --every 40 -o toy.bin --quiet
sim replay toy.bin --out first > printed.txt
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
' printed.txt "$root/$page" > page.md
keep page.md "$page"
