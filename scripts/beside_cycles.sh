#!/usr/bin/env bash
# Draws one scene with tremula and with Blender's Cycles (Debian: apt install blender) and prints the mean grey levels
# of both by region. Exit 1 where they are more than 3 % apart; without Blender nothing is done. Some minutes.
# Usage: scripts/beside_cycles.sh [--refresh] [BUILD]   BUILD: build/developer, made by scripts/test.sh
#   --refresh   makes docs/figures/beside-cycles.png and the table in docs/theory/raytrace.md, too
set -euo pipefail
export LC_ALL=C.UTF-8
cd "$(dirname "$0")/.."
kept=()
if [ "${1:-}" = --refresh ]; then
  kept=("$PWD/docs/figures/beside-cycles.png" "$PWD/docs/theory/raytrace.md")
  shift
fi
program=$(realpath "${1:-build/developer}/bin/tremula")
[ -x "$program" ] || { echo "beside_cycles: no $program" >&2; exit 2; }
if ! command -v blender > /dev/null; then
  echo "beside_cycles: no Blender here, nothing compared (apt install blender)"
  exit 0
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
status=0
blender --background --factory-startup --python-exit-code 3 --python scripts/beside_cycles/beside_cycles.py -- \
  "$program" "$work" "${kept[@]}" > "$work/log" 2>&1 || status=$?
if [ -e "$work/table" ]; then
  cat "$work/table"
else
  tail -n 20 "$work/log" >&2
fi
exit "$status"
