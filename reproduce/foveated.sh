#!/usr/bin/env bash
# docs/images/foveated_quality.png and foveated_ratio.png (docs/foveation.md): the demonstration
# with levels for the periphery and the published methods.
#
#   reproduce/foveated.sh OUT
source "$(dirname "$0")/lib.sh"

# Exit code 1: a comparison missed its target, which the picture shows.
sim optimize --demo --foveated --baselines --quality M,L --iterations 400 --out demo --quiet ||
    [ $? -eq 1 ]
keep demo/foveated_quality.png docs/images/foveated_quality.png
keep demo/foveated_ratio.png docs/images/foveated_ratio.png
