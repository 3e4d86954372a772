#!/usr/bin/env bash
# The runs behind docs/claims.md, and the page. Hours; a second call goes on where the first was stopped.
#
#   benches/claims.sh PROGRAM SCENES OUT [RATIO...]
#
# SCENES has the folders fox-posed, snowmiku-posed (photos and a model), playcanvas-playbot and
# playcanvas-biker (models); what is not there is left out. OUT gets a folder for each scene and ratio.
# ITERATIONS (100) are those of a sample, THREADS (1) those of each of JOBS (2) runs at a time.
set -euo pipefail
program=$(realpath "$1") scenes=$(realpath "$2")
mkdir -p "$3"
out=$(realpath "$3")
shift 3
ratios=("$@")
if [ ${#ratios[@]} -eq 0 ]; then ratios=(0.38 1 2.66); fi
iterations=${ITERATIONS:-100} threads=${THREADS:-1} jobs=${JOBS:-2}

# NAME RATIO arguments of `optimize`...
one() {
    local name=$1-$2 ratio=$2 start=$SECONDS again=()
    shift 2
    if [ -e "$out/$name/results.json" ]; then return; fi
    if [ -e "$out/$name" ]; then again=(--resume); fi
    "$program" optimize "$@" --oracle paper --display-ratio "$ratio" --baselines --iterations "$iterations" \
        --quiet -j "$threads" --out "$out/$name" "${again[@]}" > "$out/$name.log" 2>&1 || {
        # Exit code 1: a target was missed, which the claims say.
        [ -e "$out/$name/results.json" ] || { echo "$name failed: $(tail -1 "$out/$name.log")"; return; }
    }
    echo "$name: $((SECONDS - start)) s"
}

for ratio in "${ratios[@]}"; do
    foveated=(--foveated --quality H,M,L)
    list=("demo --demo ${foveated[*]} --study lambda")
    at=$scenes/fox-posed
    list+=("fox $at/point_cloud.ply --images $at/images --size 135x240 --pooling-rate 0.46 ${foveated[*]}")
    at=$scenes/snowmiku-posed
    list+=("snowmiku $at/point_cloud.ply --images $at/images --size 263x197 --pooling-rate 0.235 ${foveated[*]}")
    at=$scenes/playcanvas-playbot
    list+=("robot $at/3_0 --cameras $at/cameras.json --reference self --size 320x240 --pooling-rate 0.19 ${foveated[*]}")
    list+=("robot250k $at/1_0 --cameras $at/cameras.json --reference self --size 960x540 --quality M")
    at=$scenes/playcanvas-biker
    list+=("biker $at/biker.spz --cameras $at/cameras.json --reference self --size 400x300 --quality M")
    for words in "${list[@]}"; do
        read -r -a words <<< "$words"
        case ${words[1]} in
            --demo) ;;
            *) [ -e "${words[1]}" ] || { echo "${words[0]}: left out, there is no ${words[1]}"; continue; } ;;
        esac
        while [ "$(jobs -rp | wc -l)" -ge "$jobs" ]; do wait -n || true; done
        one "${words[0]}" "$ratio" "${words[@]:1}" &
    done
done
wait
if [ "${ratios[0]}" = 0.38 ]; then
    one demo-12 0.38 --demo --schedule published
fi
runs=()
for folder in "$out"/*/; do
    if [ -e "$folder/results.json" ]; then runs+=("$folder"); fi
done
"$program" claims "${runs[@]}" --force --write "$out/claims.md"
