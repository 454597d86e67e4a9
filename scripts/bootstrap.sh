#!/usr/bin/env bash
# Installs what tremula needs to build, run and test itself on Debian 12 or Ubuntu 24.04.
# Idempotent, and quick when nothing is missing. Usage: scripts/bootstrap.sh
set -euo pipefail
cd "$(dirname "$0")/.."

packages=(
  g++ cmake ninja-build git ca-certificates
  libeigen3-dev libspectra-dev libfftw3-dev libkissfft-dev librandom123-dev libtbb-dev
  libcli11-dev nlohmann-json3-dev zlib1g-dev libmeshoptimizer-dev libmatio-dev libstb-dev
  googletest libgtest-dev libbenchmark-dev clang-format-14
  nodejs chromium
)

missing=()
for package in "${packages[@]}"; do
  # A Node.js from elsewhere is as good as Debian's, as long as it brings npm.
  if [ "$package" = nodejs ] && command -v node >/dev/null && command -v npm >/dev/null; then continue; fi
  dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || missing+=("$package")
done
if [[ " ${missing[*]-} " == *" nodejs "* ]]; then missing+=(npm); fi

if [ ${#missing[@]} -gt 0 ]; then
  sudo=()
  if [ "$(id -u)" -ne 0 ]; then sudo=(sudo); fi
  echo "bootstrap: installing ${missing[*]}"
  "${sudo[@]}" apt-get update -qq
  "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
fi

# The viewer's packages, pinned by its lock file; skipped while the lock file has not changed.
if [ -f viewer/package-lock.json ]; then
  if ! cmp -s viewer/package-lock.json viewer/node_modules/.bootstrapped; then
    (cd viewer && npm ci --no-audit --no-fund --loglevel=error)
    cp viewer/package-lock.json viewer/node_modules/.bootstrapped
  fi
fi
echo "bootstrap: everything is installed"
