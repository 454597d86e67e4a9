#!/usr/bin/env bash
# Fuzzes every reader, the growth of L-systems, and the way from a file to a moving plant, with libFuzzer under ASan
# and UBSan (tests/fuzz): each harness for SECONDS, and at most RUNS inputs. What it learns stays in
# build/fuzz/corpus/HARNESS for the next time; an input that is a finding is kept in build/fuzz/findings, and
# `build/fuzz/tests/fuzz/fuzz_replay HARNESS FILE` tries it again. Fails when there is a finding.
# Usage: scripts/fuzz.sh SECONDS [HARNESS...]     RUNS=1000000 scripts/fuzz.sh 600 swc
set -euo pipefail
cd "$(dirname "$0")/.."

if ! [[ ${1:-} =~ ^[0-9]+$ ]]; then
  echo "usage: scripts/fuzz.sh SECONDS [HARNESS...]" >&2
  exit 2
fi
seconds=$1
shift
scripts/bootstrap.sh fuzz

launcher=()
if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
cmake --preset fuzz "${launcher[@]}" >/dev/null
cmake --build --preset fuzz

build=$PWD/build/fuzz
replay=$build/tests/fuzz/fuzz_replay
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
mkdir -p "$build/findings" "$build/logs"
if [ $# -eq 0 ]; then mapfile -t harnesses < <("$replay" --list); else harnesses=("$@"); fi

failed=0
for harness in "${harnesses[@]}"; do
  corpus=$build/corpus/$harness
  seeds=$build/seeds/$harness
  log=$build/logs/$harness.log
  mkdir -p "$corpus"
  "$replay" "$harness" --seeds "$seeds"
  status=0
  TMPDIR=$scratch TREMULA_HARNESS=$harness UBSAN_OPTIONS=print_stacktrace=1 \
    "$build/tests/fuzz/fuzz_inputs" "$corpus" "$seeds" -dict="$seeds.dict" -max_total_time="$seconds" \
    -runs="${RUNS:--1}" -timeout=10 -rss_limit_mb=2048 -use_value_profile=1 -print_final_stats=1 \
    -artifact_prefix="$build/findings/$harness-" >"$log" 2>&1 || status=$?
  inputs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  rate=$(sed -n 's/^stat::average_exec_per_sec: *//p' "$log")
  if [ "$status" -eq 0 ]; then
    echo "fuzz: $harness: $inputs inputs, $rate a second, nothing found"
  else
    failed=1
    echo "fuzz: $harness: a finding after ${inputs:-?} inputs (build/fuzz/logs/$harness.log)"
    grep -aE 'ERROR|SUMMARY|what\(\)|Test unit written|runtime error' "$log" | head -n 6 | sed 's/^/  /' || true
  fi
done
exit "$failed"
