#!/usr/bin/env bash
# Are the tests awake? Makes the single changes of scripts/mutations.txt one after the other in a copy of the sources,
# builds the tests that may notice, runs them, and says which changes were caught. Fails if one was not, or if a line of
# the list no longer fits the sources.
# Usage: scripts/mutate.sh [PATTERN]   PATTERN: only lines that match this extended regular expression
#   TREMULA_MUTATE_SECONDS  no change is begun after that many (default 3600); what is left then counts as not tried
#   TREMULA_MUTATE_FOLDER   where the copy is and stays for the next time (default build/mutate)
set -euo pipefail
set -f  # filters of tests have stars
cd "$(dirname "$0")/.."
pattern=${1:-.}
seconds=${TREMULA_MUTATE_SECONDS:-3600}
folder=$(realpath -m "${TREMULA_MUTATE_FOLDER:-build/mutate}")
source=$folder/source
build=$folder/build
export TREMULA_DATA=${TREMULA_DATA:-$(realpath -m ../shared/data)}

# What a line says, in file, from, to and folders.
parse() {
  local rest=$1
  file=${rest%% ## *} rest=${rest#* ## }
  from=${rest%% ## *} rest=${rest#* ## }
  to=${rest%% ## *} folders=${rest#* ## }
}
# A file comes back with a new date, so that what was built from the changed one is built again.
update() { cmp -s "$1" "$2" || { mkdir -p "$(dirname "$2")" && cp "$1" "$2"; }; }
build_tests() {
  local programs=() each
  for each in $1; do programs+=("test_${each%%:*}"); done
  timeout 3600 cmake --build "$build" -j "$(nproc)" --target "${programs[@]}" > "$folder/build.log" 2>&1
}
run_tests() {  # 0: all pass
  local each filter
  for each in $1; do
    filter='*'
    if [[ $each == *:* ]]; then filter=${each#*:}; fi
    timeout 600 "$build/tests/test_${each%%:*}" --gtest_brief=1 --gtest_filter="$filter" > "$folder/test.log" 2>&1 || return 1
  done
}

mapfile -t mutations < <(grep -v '^#' scripts/mutations.txt | grep -E ' ## ' | grep -E -- "$pattern")
if [ ${#mutations[@]} -eq 0 ]; then
  echo "mutate: no change matches '$pattern'" >&2
  exit 2
fi
for mutation in "${mutations[@]}"; do
  parse "$mutation"
  count=$(FROM=$from perl -0777 -ne '$n = () = /\Q$ENV{FROM}\E/g; print $n' "$file")
  if [ "$count" != 1 ]; then
    echo "mutate: '$from' stands $count times in $file, wanted once: mend scripts/mutations.txt" >&2
    exit 2
  fi
done

mkdir -p "$source"
while IFS= read -r -d '' path; do
  if [ ! -f "$path" ]; then rm -f "$source/$path"; else update "$path" "$source/$path"; fi
done < <({ git ls-files -z --cached --others --exclude-standard; (cd "$source" && find . -type f -printf '%P\0'); } | sort -zu)
launcher=()
if command -v ccache > /dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
# The viewer's page is not what changes here, and nothing may be fetched.
cmake -S "$source" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DTREMULA_VIEWER=OFF "${launcher[@]}" > /dev/null

# Unchanged, all of these tests pass; else what fails says nothing.
all_folders=$(for mutation in "${mutations[@]}"; do parse "$mutation" && printf '%s\n' $folders; done | sort -u)
if ! build_tests "$all_folders" || ! run_tests "$all_folders"; then
  tail -n 20 "$folder/build.log" "$folder/test.log" >&2
  echo "mutate: the tests fail as the sources are" >&2
  exit 2
fi

caught=0 bad=0
start=$SECONDS
for mutation in "${mutations[@]}"; do
  parse "$mutation"
  outcome=caught
  if [ $((SECONDS - start)) -gt "$seconds" ]; then
    outcome="NOT TRIED, out of time"
  else
    FROM=$from TO=$to perl -0777 -pi -e 's/\Q$ENV{FROM}\E/$ENV{TO}/' "$source/$file"
    if ! build_tests "$folders"; then
      outcome="DOES NOT BUILD"
    elif run_tests "$folders"; then
      outcome="NOT CAUGHT"
    fi
    update "$file" "$source/$file"
  fi
  if [ "$outcome" = caught ]; then caught=$((caught + 1)); else bad=$((bad + 1)); fi
  printf '%-14s %s: %s -> %s\n' "$outcome" "$file" "$from" "$to"
done
echo "mutate: $caught of ${#mutations[@]} caught"
[ "$bad" -eq 0 ]
