#!/usr/bin/env bash
# evidence/validation.md: published numbers beside ours. With --quick the rows without frames and
# those on quick workloads are compared with the page, and nothing is written.
#
#   reproduce/validation.sh OUT [--quick]
source "$(dirname "$0")/lib.sh"

page=evidence/validation.md
if [ "${2:-}" = --quick ]; then
    if sim validate --quick --quiet --check "$root/$page"; then
        checked "$page (quick rows)" same
    else
        checked "$page (quick rows)" differs
    fi
else
    # Exit code 1: a row is out of its tolerance, which the page says.
    sim validate --quiet --write page.md || [ $? -eq 1 ]
    keep page.md "$page"
fi
