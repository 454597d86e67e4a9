#!/usr/bin/env bash
# Installs what tremula needs on Debian or Ubuntu. Idempotent, and quick when nothing is missing.
# Usage: scripts/bootstrap.sh [PURPOSE]
#   PURPOSE: build, what the program, the library and the demo are made from;
#            test (default), also what the tests, the benchmarks and the check of the formatting take;
#            fuzz, what scripts/fuzz.sh takes
set -euo pipefail
cd "$(dirname "$0")/.."
purpose=${1:-test}
sudo=()
if [ "$(id -u)" -ne 0 ]; then sudo=(sudo); fi

packages=(
  g++ cmake ninja-build ca-certificates
  libeigen3-dev libfftw3-dev librandom123-dev libtbb-dev
  libcli11-dev nlohmann-json3-dev zlib1g-dev libmeshoptimizer-dev libstb-dev libtomlplusplus-dev
)
# A Node.js from elsewhere is as good as the system's, as long as it brings npm.
if ! command -v node >/dev/null || ! command -v npm >/dev/null; then packages+=(nodejs npm); fi
# What needs one of these is left out, or skips and says so, where the system has no such package.
if_there_is=(libembree-dev libopenexr-dev libopenvdb-dev libboost-dev)
npm_omits=(--omit=dev)
case $purpose in
  build) ;;
  test)
    packages+=(git python3 libspectra-dev libmatio-dev libgtest-dev libgmock-dev libbenchmark-dev libkissfft-dev)
    if_there_is+=(clang-format-14 chromium ffmpeg)
    npm_omits=()
    ;;
  fuzz) packages+=(clang libclang-rt-dev libspectra-dev libmatio-dev libgtest-dev libgmock-dev) ;;
  *)
    echo "bootstrap: '$purpose' is no purpose; build, test and fuzz are" >&2
    exit 2
    ;;
esac

installed() { [ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }
can_be_installed() { [[ $(LC_ALL=C apt-cache policy "$1" 2>/dev/null) == *"Candidate: "[!\(]* ]]; }

missing=()
for package in "${packages[@]}"; do installed "$package" || missing+=("$package"); done
wished=()
for package in ${if_there_is[@]+"${if_there_is[@]}"}; do installed "$package" || wished+=("$package"); done
install() {
  echo "bootstrap: installing $*"
  "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@"
}
if [ $((${#missing[@]} + ${#wished[@]})) -gt 0 ]; then
  # Lists are fetched for what must be there; for a wish alone only where there are none yet.
  if [ ${#missing[@]} -gt 0 ] || ! can_be_installed g++; then "${sudo[@]}" apt-get update -qq; fi
  granted=()
  for package in ${wished[@]+"${wished[@]}"}; do
    if can_be_installed "$package"; then
      granted+=("$package")
    else
      echo "bootstrap: this system has no package $package; what needs it will skip"
    fi
  done
  if [ ${#missing[@]} -gt 0 ]; then install "${missing[@]}"; fi
  # Lists that are old name packages that are gone.
  if [ ${#granted[@]} -gt 0 ] && ! install "${granted[@]}"; then
    { "${sudo[@]}" apt-get update -qq && install "${granted[@]}"; } ||
      echo "bootstrap: ${granted[*]} could not be installed; what needs them will skip"
  fi
fi

# The viewer's packages, pinned by its lock file; skipped while they are those of the lock file. What the tests take
# holds what a build takes; to fuzz takes no more than that.
level=build
if [ "$purpose" = test ]; then level=test; fi
if ! cmp -s viewer/package-lock.json "viewer/node_modules/.for-$level"; then
  (cd viewer && npm ci ${npm_omits[@]+"${npm_omits[@]}"} --no-audit --no-fund --loglevel=error)
  cp viewer/package-lock.json viewer/node_modules/.for-build
  if [ "$level" = test ]; then cp viewer/package-lock.json viewer/node_modules/.for-test; fi
fi
echo "bootstrap: everything to $purpose is installed"
