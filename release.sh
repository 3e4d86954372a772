#!/usr/bin/env bash
# Makes what a release holds: programs, Python packages, manual pages, completions, schemas, parts, checksums. Uploads nothing.
#
# Usage: ./release.sh [FOLDER]        FOLDER (dist) must not exist
#
# Needs Rust with the targets below, a C compiler, Python 3.10 or newer, and network for tools of pinned versions.
# Twenty minutes on two cores. TARGETS="x86_64-unknown-linux-musl aarch64-unknown-linux-musl" makes others.
set -euo pipefail
cd "$(dirname "$0")"
out=${1:-dist}
[ ! -e "$out" ] || { echo "release.sh: $out is there already; give another folder" >&2; exit 1; }
read -ra targets <<< "${TARGETS:-x86_64-unknown-linux-gnu.2.28 x86_64-unknown-linux-musl}"

version=$(sed -n 's/^version = "\(.*\)"$/\1/p' Cargo.toml | head -1)
POWERGS_COMMIT=$(git rev-parse --short=12 HEAD)
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export POWERGS_COMMIT SOURCE_DATE_EPOCH
[ -z "$(git status --porcelain)" ] || echo "release.sh: the tree has changes that commit $POWERGS_COMMIT has not" >&2
grep -q "^## $version " CHANGELOG.md || { echo "release.sh: CHANGELOG.md has no section $version" >&2; exit 1; }

step() { printf '\n== %s (after %d:%02d)\n' "$*" $((SECONDS / 60)) $((SECONDS % 60)); }
tools=$(mktemp -d)
trap 'rm -rf "$tools"' EXIT
mkdir -p "$out"
out=$(cd "$out" && pwd)

step "tools"
python3 -m venv "$tools/python"
"$tools/python/bin/pip" install --quiet --requirement .ci/release.txt
PATH="$tools/python/bin:$PATH"
for target in "${targets[@]}"; do
    rustup target list --installed | grep -qx "${target%%.*}" || rustup target add "${target%%.*}"
done

step "manual pages, completions and schemas, by the program itself"
cargo run --release --locked --quiet --example manual -- "$tools/man"
for shell in bash zsh fish; do
    cargo run --release --locked --quiet -- completions $shell > "$tools/powergs-sim.$shell"
done
mkdir "$tools/schema"
for kind in machine energy display dram sweep synth; do
    cargo run --release --locked --quiet -- arch schema $kind > "$tools/schema/$kind.json"
done
cargo run --release --locked --quiet -- arch schema --report > "$tools/schema/report.json"

for target in "${targets[@]}"; do
    step "program: $target"
    cargo zigbuild --profile dist --locked --quiet --package powergs-sim --target "$target"
    name=powergs-sim-$version-${target%%.*}
    mkdir -p "$tools/$name/completions"
    cp "target/${target%%.*}/dist/powergs-sim" "$tools/$name/"
    cp -r "$tools/man" "$tools/schema" README.md CITATION.cff LICENSE-* NOTICE "$tools/$name/"
    cp "$tools"/powergs-sim.{bash,zsh,fish} "$tools/$name/completions/"
    mkdir "$tools/$name/traces" && cp traces/demo.bin "$tools/$name/traces/"
    tar --sort=name --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner \
        -C "$tools" -cf - "$name" | gzip -n -9 > "$out/$name.tar.gz"
done

step "Python: wheel and source"
maturin build --release --locked --zig --compatibility manylinux_2_28 --manifest-path python/Cargo.toml --out "$out"
git rev-parse --short=12 HEAD > python/COMMIT
maturin sdist --manifest-path python/Cargo.toml --out "$out"
rm python/COMMIT

step "what it is made of"
cargo install --quiet --locked --root "$tools/cargo" cargo-cyclonedx@0.5.9
"$tools/cargo/bin/cargo-cyclonedx" cyclonedx --quiet --manifest-path Cargo.toml --format json --spec-version 1.5 \
    --override-filename powergs-sim.cdx
mv powergs-sim.cdx.json "$out/powergs-sim-$version.cdx.json"
git clean --quiet --force -- '*.cdx.json'

step "checksums"
(cd "$out" && sha256sum -- * > "$tools/sums" && mv "$tools/sums" SHA256SUMS && cat SHA256SUMS)
