#!/usr/bin/env bash
# Fails, and names the places, where the documents name what does not exist:
#  - in docs/theory, everything in backticks: files, functions, types, fields, flags, tests (Suite.Name);
#  - in docs/theory/notation.md, a word that nothing uses, or one of those that the table forbids;
#  - in all documents, links to files, and the commands and flags of command lines that begin with tremula.
# Usage: scripts/check_docs.sh
set -euo pipefail
shopt -s globstar nullglob
cd "$(dirname "$0")/.."

declare -A words tests flags commands files
while read -r word; do words[$word]=1; done \
  < <(grep -rhoE '[A-Za-z_][A-Za-z0-9_]*' src cli viewer/src --include='*.?pp' --include='*.ts' | sort -u)
while read -r test; do tests[$test]=1; done \
  < <(grep -rhoE '^TEST(_[FP])?\([A-Za-z0-9_]+, *[A-Za-z0-9_]+' tests | sed -E 's/^TEST(_[FP])?\(([^,]+), */\2./')
while read -r flag; do flags[$flag]=1; done < <(grep -hoE -- '--[a-z][a-z-]*' cli/*.cpp | sort -u)
for flag in --help --version; do flags[$flag]=1; done
while read -r command; do commands[$command]=1; done \
  < <(grep -hoE 'add_subcommand\("[a-z]+' cli/*.cpp | sed 's/.*"//')
for file in src/**/*.?pp cli/*.?pp; do files[$(basename "$file")]=1; done

problems=0
complain() {
  echo "$1: $2"
  problems=$((problems + 1))
}

check_command() {  # place, command line
  local place=$1 word
  set -f
  set -- $2
  set +f
  shift
  if [[ ${1:-} == [a-z]* && -z ${commands[$1]:-} ]]; then complain "$place" "no command 'tremula $1'"; fi
  for word in "$@"; do
    word=${word%%=*}
    if [[ $word =~ ^--[a-z-]+$ && -z ${flags[$word]:-} ]]; then complain "$place" "no flag '$word'"; fi
  done
}

check_name() {  # place, what stood in backticks
  local part
  case $2 in
    */*) [ -e "$2" ] || [ -e "src/tremula/$2" ] || complain "$1" "no file '$2'" ;;
    *.cpp | *.hpp) [ -n "${files[$2]:-}" ] || complain "$1" "no file '$2'" ;;
    tremula\ *) check_command "$1" "$2" ;;
    --*) [ -n "${flags[${2%% *}]:-}" ] || complain "$1" "no flag '$2'" ;;
    *.*) [ -n "${tests[$2]:-}" ] || complain "$1" "no test '$2'" ;;
    *)
      for part in ${2//::/ }; do
        [ -n "${words[$part]:-}" ] || complain "$1" "nothing in the sources is called '$part'"
      done
      ;;
  esac
}

# The table of words in notation.md: what stands first is used, what stands last is not.
check_words() {
  local number=0 line in_words= word banned
  while IFS= read -r line; do
    number=$((number + 1))
    case $line in
      '## Words'*) in_words=1 ;;
      '## '*) in_words= ;;
    esac
    [[ -n $in_words && $line == '| `'* ]] || continue
    word=$(cut -d'|' -f2 <<< "$line" | grep -oE '`[^`]+`' | tr -d '`')
    [ -n "${words[$word]:-}" ] || complain "docs/theory/notation.md:$number" "'$word' is a word that nothing uses"
    while read -r banned; do
      [ -z "${words[$banned]:-}" ] ||
        complain "docs/theory/notation.md:$number" "'$banned' is used: the word is '$word'"
    done < <(cut -d'|' -f4 <<< "$line" | grep -oE '`[^`]+`' | tr -d '`')
  done < docs/theory/notation.md
}
check_words

checked=0
for document in README.md docs/**/*.md; do
  number=0
  fenced=
  goes_on=
  while IFS= read -r line || [ -n "$line" ]; do
    number=$((number + 1))
    place=$document:$number
    if [[ $line == '```'* ]]; then
      if [ -n "$fenced" ]; then fenced=; else fenced=1; fi
      continue
    fi
    if [ -n "$fenced" ]; then
      if [ -n "$goes_on" ]; then check_command "$place" "tremula $line"; fi
      if [[ $line =~ ^(\$ )?tremula\  ]]; then
        goes_on=1
        check_command "$place" "${line#\$ }"
      fi
      [[ $line == *\\ ]] || goes_on=
      continue
    fi
    if [ "$line" = '## Words' ]; then break; fi  # check_words has looked at those
    [[ $line == *']('* || $line == *'`'* ]] || continue
    while read -r link; do
      case $link in
        '' | http* | '#'*) ;;
        *) [ -e "$(dirname "$document")/${link%%#*}" ] || complain "$place" "no file '$link' to link to" ;;
      esac
    done < <(grep -oE '\]\([^) ]+\)' <<< "$line" | sed -E 's/^\]\(//; s/\)$//')
    [[ $document == docs/theory/* ]] || continue
    while read -r name; do
      [ -n "$name" ] || continue
      checked=$((checked + 1))
      check_name "$place" "$name"
    done < <(grep -oE '`[^`]+`' <<< "$line" | tr -d '`')
  done < "$document"
done

if [ "$problems" -gt 0 ]; then
  echo "check_docs: $problems names that do not exist"
  exit 1
fi
echo "check_docs: $checked names in docs/theory exist"
