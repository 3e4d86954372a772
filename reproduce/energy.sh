#!/usr/bin/env bash
# docs/images/energy.png (README.md): where the energy of the committed demo goes.
#
#   reproduce/energy.sh OUT
source "$(dirname "$0")/lib.sh"

sim replay "$root/traces/demo.bin" --out demo --quiet
keep demo/energy.png docs/images/energy.png
