#!/usr/bin/env bash
# The runs behind evidence/claims.md, and the page. Hours; a second call goes on where the first was stopped.
#
#   lab/claims.sh PROGRAM SCENES OUT
#
# PROGRAM is powergs-sim; powergs-lab lies beside it.
#
# SCENES has the folders fox-posed, snowmiku-posed (photos and a model), playcanvas-playbot,
# playcanvas-biker and playcanvas-flowers (models); what is not there is left out. OUT gets a folder for
# each scene and ratio of display to rendering power. Models are trained at the first ratio of RATIOS
# (0.38 1 2.66); at the others they are priced anew, and a few samples and the optimum there are made.
# ITERATIONS (100) are those of a sample, THREADS (1) those of each of JOBS (2) runs at a time;
# ONLY (all) names the scenes. What λ does in the published 1000 iterations is a run of its own: two
# ratios, no comparisons.
set -euo pipefail
program=$(realpath "$1") scenes=$(realpath "$2")
mkdir -p "$3"
out=$(realpath "$3")
iterations=${ITERATIONS:-100} threads=${THREADS:-1} jobs=${JOBS:-2}
read -ra ratios <<< "${RATIOS:-0.38 1 2.66}"
only=${ONLY:-}

# FOLDER arguments of `optimize`...
one() {
    local name=$1 start=$SECONDS again=()
    shift
    if [ -e "$out/$name/results.json" ]; then return; fi
    if [ -e "$out/$name" ]; then again=(--resume); fi
    "$program" optimize "$@" --quiet -j "$threads" --out "$out/$name" "${again[@]}" > "$out/$name.log" 2>&1 || {
        # Exit code 1: a target was missed, which the claims say.
        [ -e "$out/$name/results.json" ] || { echo "$name failed: $(tail -1 "$out/$name.log")"; return 1; }
    }
    echo "$name: $((SECONDS - start)) s"
}

# NAME arguments of `optimize`...: at each ratio.
scene() {
    local name=$1 first=${ratios[0]} ratio
    shift
    one "$name-$first" "$@" --oracle paper --display-ratio "$first" --baselines --iterations "$iterations" \
        --keep all || return 0
    for ratio in "${ratios[@]:1}"; do
        one "$name-$ratio" --reprice "$out/$name-$first" --display-ratio "$ratio" --realise || true
    done
}

# NAME arguments of `optimize`...: at the first ratio.
steered() {
    local name=$1 first=${ratios[0]}
    shift
    one "$name-$first-steered" "$@" --oracle paper --display-ratio "$first" --dimming damped \
        --rhos 0,0.2 --iterations 1000 --final-iterations 100 || true
}

# scene|steered NAME FILE arguments of `optimize`...: in the background, as many at a time as there may be.
start() {
    if [ -n "$only" ] && [[ " $only " != *" $2 "* ]]; then return; fi
    if [ "$3" != --demo ] && [ ! -e "$3" ]; then
        echo "$2: left out, there is no $3"
        return
    fi
    while [ "$(jobs -rp | wc -l)" -ge "$jobs" ]; do wait -n || true; done
    "$@" &
}

levels=(--foveated --screen powergs --quality H,M,L --study lambda)
medium=(--quality M)
own=(--reference self "${medium[@]}")
photos=$scenes/fox-posed
fox=("$photos/point_cloud.ply" --images "$photos/images" --size 135x240)
photos=$scenes/snowmiku-posed
snowmiku=("$photos/point_cloud.ply" --images "$photos/images" --size 263x197)
at=$scenes/playcanvas-playbot
robot=("$at/3_0" --cameras "$at/cameras.json" --size 320x240)
start scene demo --demo "${levels[@]}"
start scene fox "${fox[@]}" --pooling-rate 0.46 "${levels[@]}"
flowers=$scenes/playcanvas-flowers
start scene flowers "$flowers/lod-meta.json" --cameras "$flowers/cameras.json" --size 600x334 "${own[@]}"
biker=$scenes/playcanvas-biker
start scene biker "$biker/biker.spz" --cameras "$biker/cameras.json" --size 400x300 "${own[@]}"
start scene snowmiku "${snowmiku[@]}" --pooling-rate 0.235 "${levels[@]}"
start scene robot "${robot[@]}" --reference self --pooling-rate 0.19 "${levels[@]}"
start scene robot250k "$at/1_0" --cameras "$at/cameras.json" --size 960x540 "${own[@]}"
start steered demo --demo "${medium[@]}"
start steered fox "${fox[@]}" "${medium[@]}"
start steered snowmiku "${snowmiku[@]}" "${medium[@]}"
start steered robot "${robot[@]}" "${own[@]}"
wait
if [ "${ratios[0]}" = 0.38 ]; then
    one demo-12 --demo --schedule published --oracle paper --display-ratio 0.38 --iterations "$iterations"
fi
runs=()
for folder in "$out"/*/; do
    if [ -e "$folder/results.json" ]; then runs+=("$folder"); fi
done
"$(dirname "$program")/powergs-lab" claims "${runs[@]}" --force --write "$out/claims.md"
