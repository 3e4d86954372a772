#!/usr/bin/env bash
# The tables of the example of a paper's artifact folder: reproduce/paper/expected/*.csv.
#
#   reproduce/paper.sh OUT
source "$(dirname "$0")/lib.sh"

"$root/reproduce/paper/run" paper
for table in front compare; do
    keep "paper/tables/$table.csv" "reproduce/paper/expected/$table.csv"
done
