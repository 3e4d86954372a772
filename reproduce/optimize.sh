#!/usr/bin/env bash
# docs/images/optimize_curves.png and optimize_plane.png (README.md, docs/optimizer.md): the
# demonstration of the optimiser.
#
#   reproduce/optimize.sh OUT
source "$(dirname "$0")/lib.sh"

sim optimize --demo --out demo --quiet
keep demo/curves.png docs/images/optimize_curves.png
keep demo/plane.png docs/images/optimize_plane.png
