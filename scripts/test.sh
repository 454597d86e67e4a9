#!/usr/bin/env bash
# Installs what is missing, builds with warnings as errors, checks the formatting and runs all tests.
# Usage: scripts/test.sh [PRESET]
#   PRESET: developer (default)
#           debug   under ASan and UBSan
#           tsan    under ThreadSanitizer
#           clang   shared libraries by clang++
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-developer}
scripts/bootstrap.sh test
scripts/check_format.sh
cmake --preset "$preset"
cmake --build --preset "$preset"
ctest --preset "$preset" -j "$(nproc)"
