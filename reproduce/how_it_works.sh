#!/usr/bin/env bash
# docs/images/gscore.svg (README.md, docs/how-it-works.md) and docs/images/timeline.png: the diagram
# of a machine, and a frame of the committed demo on it. The diagram names no commit.
#
#   reproduce/how_it_works.sh OUT
source "$(dirname "$0")/lib.sh"

sim arch show gscore --figure -o gscore.svg --quiet
sed -i 's/, commit [0-9a-f]*//' gscore.svg
keep gscore.svg docs/images/gscore.svg
sim replay "$root/traces/demo.bin" --timeline 0 --what-if 0 --out look --quiet
keep look/timeline.png docs/images/timeline.png
