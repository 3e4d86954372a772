#!/usr/bin/env bash
# The tables of evidence/sensitivity.md, and docs/images/sensitivity.png. Hours; with --quick only
# the table of nine keys, in seconds.
#
#   reproduce/sensitivity.sh OUT [--quick]
#
# The page keeps its text; its tables are those of this run.
source "$(dirname "$0")/lib.sh"

page=$root/evidence/sensitivity.md

# The rows of the table `| key | value | near |` of the page.
nine_keys() {
    awk '/^\| key \| value \| near/ { on = 1 } on && !/^\|/ { exit } on && /^\| `/' "$page" |
        cut -d'`' -f2
}
keys=$(nine_keys | paste -sd,)
sim sensitivity gscore "$root/traces/demo.bin" --frames ..1 --keys "$keys" --out keys --quiet
# Of the report: columns 3 (key), 4 (value), 14 (near) and 16 to 19 (elasticities).
awk -F' [|] ' '
    function bar(text) { gsub(/\\[|]/, "\001", text); return text }
    { $0 = bar($0) }
    FNR == NR {
        if ($1 ~ /^\| (machine|energy|dram)$/) {
            sub(/ \|$/, "")
            row[$2] = "| " $2 " | " $3 " | " $13 " | " $15 " | " $16 " | " $17 " | " $18 " |"
        }
        next
    }
    /^\| key \| value \| near/ { on = 1 }
    on && !/^\|/ { on = 0 }
    { key = $1; sub(/^\| /, "", key) }
    on && key in row { $0 = row[key] }
    { gsub("\001", "\\|"); print }
' keys/summary.md "$page" > page.md

if [ "${2:-}" != --quick ]; then
    sim synth room -o indoor.ply --cameras indoor.json --quiet
    sim synth truck -o outdoor.ply --cameras outdoor.json --quiet
    for place in indoor outdoor; do
        sim extract "$place.ply" --cameras "$place.json" --path-frames 720 --frames ..3 \
            -o "$place.bin" --quiet
    done
    sim sensitivity gscore indoor.bin outdoor.bin --assumptions --memory "3 GiB" --out all --quiet
    keep all/tornado.png docs/images/sensitivity.png
    # From the first table of the report on, it is what the page has behind its text.
    first='^[|] trace [|] frames [|] FPS [|]'
    awk -v first="$first" '$0 ~ first { exit } { print }' page.md > head.md
    awk -v first="$first" '$0 ~ first { on = 1 } on { print }' all/summary.md |
        sed 's|(tornado.png)|(../docs/images/sensitivity.png)|' > tail.md
    cat head.md tail.md > page.md
fi
keep page.md evidence/sensitivity.md
