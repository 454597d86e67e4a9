#!/usr/bin/env bash
# Makes the pictures of the documents (docs/figures) and refreshes their transcripts: in fenced blocks, what stands
# below a line "$ command" becomes what the command prints now.
# Times that they print are those of this machine: let it do nothing else meanwhile.
# Usage: scripts/figures.sh [BUILD]   BUILD: build/developer, made by scripts/test.sh
set -euo pipefail
export LC_ALL=C
cd "$(dirname "$0")/.."
build=$(realpath "${1:-build/developer}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
root=$PWD
tremula() { "$build/bin/tremula" "$@"; }

# One row of a contact sheet, scaled down by the browser.
row() {  # preset, row of the sheet (0-2), width [pixels], file, options of animate
  tremula animate "$1" "${@:5}" -o "$work/$1.png" 2> /dev/null
  local size
  size=$(od -An -tu4 --endian=big -j16 -N8 "$work/$1.png")  # width and height of a PNG
  set -- "$1" "$2" "$3" "$4" $size
  cat > "$work/page.html" << PAGE
<style>body { margin: 0; overflow: hidden } img { width: $3px; margin-top: -$(($3 * $6 / $5 * $2 / 3))px }</style>
<img src="$1.png">
PAGE
  chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --user-data-dir="$work/chromium" \
    --window-size="$3,$(($3 * $6 / $5 / 3 - 1))" --screenshot="$root/$4" "file://$work/page.html" > /dev/null 2>&1
}
mkdir -p docs/figures

# The scenes, and two of them as loops of 10 s (WebP, by ffmpeg). Three quarters of an hour on two cores.
scene() {  # scene, options of render
  local name
  name=$(basename "$1" .toml)
  tremula render "$1" "${@:2}" -o "$work/$name.png"
  ffmpeg -y -loglevel error -i "$work/$name.png" -c:v libwebp -quality 85 "docs/figures/$name.webp"
}
for scene in scenes/*.toml; do scene "$scene"; done
loop() {  # scene, file, frames a second, samples, quality
  tremula render "$1" --size 640x360 --fps "$3" --period 10 --samples "$4" -o "$work/$2/%04d.png"
  ffmpeg -y -loglevel error -framerate "$3" -i "$work/$2/%04d.png" -c:v libwebp_anim -loop 0 -quality "$5" \
    -compression_level 6 "docs/figures/$2.webp"
}
loop scenes/stam-figure-4.toml small-tree-loop 12 16 60
loop scenes/stam-figure-5.toml forest-loop 10 4 45

row flag 0 1040 docs/figures/flag.png --wind-speed 8 --period 20 --seed 1
row seagrass 0 1040 docs/figures/seagrass.png --wind-speed 6 --period 20 --seed 1
row oak 0 1040 docs/figures/oak.png --wind-speed 12 --period 20 --seed 1
tremula modes stam-62 --plot docs/figures/modes.svg > /dev/null
tremula beam --count 3 --plot docs/figures/beam.svg > /dev/null
tremula wind --model iec-kaimal --speed 12 --reference-height 90 --profile power:0.2 --points 51x51 --size 145x145 \
  --center-height 90 --plot docs/figures/wind.svg
# Shinya & Fournier 1992, figures 2 and 3; 4 is beam.svg.
tremula wind --wind-speed 8 --points 21x1 --size 100x0 --center-height 10 --steps 8192 --spectra docs/figures/spectra.svg
tremula wind --wind-speed 8 --points 81x1 --size 80x0 --center-height 5 --period 60 --vectors docs/figures/gusts.svg

scripts/experiments.sh "$build"
node scripts/run_docs.mjs --refresh "$build"
ls -l docs/figures/*
