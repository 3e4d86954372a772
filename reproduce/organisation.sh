#!/usr/bin/env bash
# evidence/organisation.csv: the gains of evidence/organisation.md on today's `lego`. Minutes.
#
#   reproduce/organisation.sh OUT
#
# The page has trained models of others, which never enter, and scenes of an older generator: its
# numbers cannot be made from nothing, and there is no file to compare with. What this shows is
# that the conclusions hold: how much boxes and skipping gain with each organisation of the VRU.
source "$(dirname "$0")/lib.sh"

sim synth lego --points 340000 -o lego.ply --cameras lego.json --quiet
sim extract lego.ply --cameras lego.json --every 50 --frames ..4 --size 800x800 -o lego.bin --quiet

files=()
# machine NAME SETTING...: a machine that skips sub-tiles, one that does not, one with squares.
machine() {
    local name=$1 kind set=(--set energy=gscore-28nm-nerarch --set vru.stop-latency=0)
    set+=(--set dram.model=bandwidth)
    shift
    for setting in "$@"; do set+=(--set "$setting"); done
    for kind in skip all squares; do
        local more=(--set "name=$name-$kind")
        if [ "$kind" != skip ]; then more+=(--set vru.subtile-skipping=false); fi
        if [ "$kind" = squares ]; then more+=(--set geometry.test=aabb); fi
        sim arch show gscore --resolved "${set[@]}" "${more[@]}" > "$name-$kind.toml"
        files+=("$name-$kind.toml")
    done
}
machine free vru.impl=serial
machine state vru.impl=swap
machine hidden vru.impl=swap 'buffers.pixel-out.word=32 B' buffers.pixel-out.ports=1r1w
machine scan vru.impl=scan vru.subtile-queue=16
for depth in 1 2 4 8 16 64; do
    machine "$depth" vru.impl=parallel "vru.subtile-queue=$depth"
done
sim compare "${files[@]}" lego.bin --out compare --quiet
# Columns: kind, name, then the machines, then ratios.
awk -F, '
    FNR == 1 { for (i = 3; i <= NF && $i !~ /[/]/; i++) name[i] = $i; last = i - 1; next }
    $1 == "measure" { for (i = 3; i <= last; i++) value[$2, name[i]] = $i }
    END {
        print "organisation,area_core_mm2,time_of_free,energy_of_free,obb,skip,both"
        for (i = 3; i <= last; i += 3) {
            kind = name[i]; sub(/-skip$/, "", kind)
            skip = value["frame_time_ms", kind "-skip"]
            all = value["frame_time_ms", kind "-all"]
            squares = value["frame_time_ms", kind "-squares"]
            energy = value["energy_per_frame_mj", kind "-skip"]
            if (i == 3) { free = skip; joules = energy }
            printf "%s,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f\n", kind, value["area_core_mm2", name[i]],
                skip / free, energy / joules, squares / all, all / skip, squares / skip
        }
    }
' compare/compare.csv > organisation.csv
keep organisation.csv evidence/organisation.csv
