#!/usr/bin/env bash
# docs/images/sweep_front.png (README.md): the front of the sweep `gscore-units` on the demo.
#
#   reproduce/sweep_front.sh OUT
source "$(dirname "$0")/lib.sh"

sim sweep gscore-units --traces "$root/traces/*.bin" --out units --quiet
keep units/analysis/front.png docs/images/sweep_front.png
