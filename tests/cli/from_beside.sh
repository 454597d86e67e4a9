#!/usr/bin/env bash
# Runs a script that may lie beside the project, in ../shared/tools, with the program; skips (77) and says so where it or
# python3 is absent. Usage: from_beside.sh SCRIPT PROGRAM
set -euo pipefail
script=$(realpath -m "${TREMULA_DATA:-$(dirname "$0")/../../../shared/data}/../tools/$1")
if [ ! -f "$script" ] || ! command -v python3 > /dev/null; then
  echo "skipped: no $script, or no python3 to run it"
  exit 77
fi
exec python3 "$script" "$2"
