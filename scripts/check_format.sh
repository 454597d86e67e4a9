#!/usr/bin/env bash
# Fails, and names the places, where a C++ file is not formatted as .clang-format says. `scripts/check_format.sh fix`
# formats them.
set -euo pipefail
cd "$(dirname "$0")/.."
mapfile -t files < <(find src cli tests bench examples -name '*.hpp' -o -name '*.cpp' | sort)
if [ "${1:-}" = fix ]; then
  clang-format-14 -i "${files[@]}"
else
  clang-format-14 --dry-run --Werror "${files[@]}"
fi
