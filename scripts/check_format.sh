#!/usr/bin/env bash
# Fails, and names the places, where a C++ file is not formatted as .clang-format says. `scripts/check_format.sh fix`
# formats them. Versions of clang-format disagree, so that any other than 14 is not asked.
set -euo pipefail
cd "$(dirname "$0")/.."
formatter=
for candidate in clang-format-14 clang-format; do
  if [[ $("$candidate" --version 2>/dev/null) == *" version 14."* ]]; then formatter=$candidate && break; fi
done
if [ -z "$formatter" ]; then
  echo "check_format: skipped, there is no clang-format 14 here"
  if [ "${1:-}" = fix ]; then exit 1; fi
  exit 0
fi
mapfile -t files < <(find src cli tests bench examples -name '*.hpp' -o -name '*.cpp' | sort)
if [ "${1:-}" = fix ]; then
  "$formatter" -i "${files[@]}"
else
  "$formatter" --dry-run --Werror "${files[@]}"
fi
