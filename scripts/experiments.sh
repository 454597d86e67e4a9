#!/usr/bin/env bash
# Repeats the papers' experiments: refreshes the tables of docs/experiments.md and their pictures (docs/figures).
# Times that it prints are those of this machine: let it do nothing else meanwhile. Two or three minutes.
# Usage: scripts/experiments.sh [BUILD]   BUILD: build/developer, made by scripts/test.sh, or with TREMULA_BENCH
set -euo pipefail
export LC_ALL=C
cd "$(dirname "$0")/.."
build=$(realpath "${1:-build/developer}")
for program in table_1 enough_modes direct_forces compare_dynamics as_printed linear_poses; do
  [ -x "$build/bench/bench_$program" ] || { echo "experiments: no $build/bench/bench_$program" >&2; exit 2; }
done
mkdir -p docs/figures
"$build/bench/bench_compare_dynamics" bamboo-2942 6 --plot docs/figures/dynamics.svg > /dev/null
"$build/bench/bench_direct_forces" --plot docs/figures/direct-forces.svg > /dev/null
"$build/bench/bench_linear_poses" --plot docs/figures/linear-poses.svg > /dev/null
node scripts/run_docs.mjs --refresh "$build" docs/experiments.md
