#!/usr/bin/env bash
# Draws the small pictures that the scenes are compared with (tests/cli/golden), to be looked at before they are committed.
# Usage: scripts/golden.sh [BUILD]   BUILD: build/developer, made by scripts/test.sh
set -euo pipefail
cd "$(dirname "$0")/.."
tremula=${1:-build/developer}/bin/tremula
mkdir -p tests/cli/golden
for scene in scenes/*.toml; do
  name=$(basename "$scene" .toml)
  "$tremula" render "$scene" --size 96x54 --samples 64 -o "tests/cli/golden/$name.png"
done
