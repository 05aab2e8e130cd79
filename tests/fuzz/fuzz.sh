#!/bin/bash
# Runs the loaders under libFuzzer with the address and undefined-behaviour sanitizers: each for some time, starting
# from its corpus, one process a core. `make fuzz` builds build/fuzz/ and calls it. Arguments: seconds for each loader,
# and the loaders; all by default. With SHARD=2/3 in the environment, the second of three shares of these.
#
# A finding is any result except a file that is read and an InputError of one line (tests/fuzz/loaders.h): another
# exception, a crash, a sanitizer's report, more than ten seconds for a file, or more than 2 GB. Its input stays in
# build/fuzz/ and is the first to run next time. Fix the loader, reduce the input by hand or with -minimize_crash=1, and
# put it into found/ below this folder: tests/fuzz_regressions_test.cpp then reads it on every run.
#
# The table shows the number of inputs that were run, the size of the corpus, the covered edges of the program, the
# findings (a loader stops at its first), and the seconds. The exit code is 1 if there is a finding.
#
# New inputs stay in build/fuzz/ as well. `tests/fuzz/fuzz.sh keep` copies into corpus/ the few that cover an edge which
# no input there covers. Inputs of all loaders count, because scenes share a parser.
set -u
cd "$(dirname "$0")/../.." || exit 1
build=build/fuzz
all=$($build/loaders_fuzz -runs=1 2>&1 | sed -n 's/^LOCKSTEP_LOADER: expected one of: //p')  # the domains, for their scenes, and files
seconds=${1:-600}
loaders=${*:2}
loaders=${loaders:-$all}
for loader in $loaders; do
  [[ " $all " = *" $loader "* ]] || { echo "no loader $loader, expected one of: $all" >&2; exit 2; }
done
if [ -n "${SHARD:-}" ]; then  # by the rule of verify/shard.h
  [[ "$SHARD" =~ ^([1-9][0-9]{0,5})/([1-9][0-9]{0,5})$ ]] && [ "${BASH_REMATCH[1]}" -le "${BASH_REMATCH[2]}" ] ||
    { echo "SHARD=$SHARD: expected I/N with 1 <= I <= N, such as 2/3" >&2; exit 2; }
  place=0 share=""
  for loader in $loaders; do
    [ $((place % BASH_REMATCH[2])) = $((BASH_REMATCH[1] - 1)) ] && share+="$loader "
    place=$((place + 1))
  done
  loaders=$share
fi
TMPDIR=$(mktemp -d -p /dev/shm lockstep_XXXXXX) || exit 1  # in memory; the loaders read their inputs from here
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT

limits="-timeout=10 -rss_limit_mb=2048 -max_len=4096"
fuzzer() { LOCKSTEP_LOADER=$1 $build/loaders_fuzz $limits "${@:2}"; }

if [ "$seconds" = keep ]; then
  for loader in $loaders; do
    rm -rf "$TMPDIR/kept"
    mkdir "$TMPDIR/kept"
    cp tests/fuzz/corpus/*/* "$TMPDIR/kept/"
    fuzzer $loader -set_cover_merge=1 -use_counters=0 "$TMPDIR/kept" $build/$loader/corpus 2>&1 | tail -n 1
    for input in "$TMPDIR"/kept/*; do
      [ -e "$(echo tests/fuzz/corpus/*/"${input##*/}")" ] || cp "$input" tests/fuzz/corpus/$loader/
    done
  done
  exit
fi

# A dictionary of the words in scenes, extracted from the loaders; each with and without quotes.
sed 's@//.*@@; /#include/d' common/scene.cpp common/*/scene.cpp | grep -oE '"[a-z_]{2,}\\?"' | tr -d '\\"' | sort -u |
  sed 's/.*/"&"\n"\\"&\\""/' > $TMPDIR/scene.dict

row() { printf '%-12s %12s %8s %8s %9s %8s  %s\n' "$@"; }

fuzz() {
  local loader=$1 folder=$build/$1 start=$SECONDS inputs dictionary=""
  mkdir -p $folder/corpus $folder/findings
  find $folder/findings -type f -exec mv -t $folder/corpus {} +
  inputs=$(ls -d $folder/corpus tests/fuzz/{corpus,found}/$loader 2>/dev/null)
  case $loader in fluid_file | obj | off | ply | stl | matrix_market | msh | vtk | veg | facesim) ;; *)  # scenes have a parser in common, so the inputs of one domain are of use to another
    dictionary=-dict=$TMPDIR/scene.dict inputs+=" $(ls -d tests/fuzz/corpus/* | grep -vE '/(fluid_file|obj|off|ply|stl|matrix_market|msh|vtk|veg|facesim)$')" ;;
  esac
  fuzzer $loader $dictionary -max_total_time=$seconds -print_final_stats=1 -artifact_prefix=$folder/findings/ \
    $inputs > $folder/log 2>&1
  local code=$?
  local findings; findings=$(find $folder/findings -type f ! -name 'slow-unit-*' | wc -l)
  local last; last=$(grep -aE '^#[0-9]+.* cov: ' $folder/log | tail -n 1)
  local executions; executions=$(sed -nE 's/^#([0-9]+).*/\1/p' <<< "$last")
  local edges; edges=$(sed -nE 's/.* cov: ([0-9]+).*/\1/p' <<< "$last")
  local inputs; inputs=$(sed -nE 's/.* corp: ([0-9]+).*/\1/p' <<< "$last")
  local note=""
  if [ $code != 0 ]; then
    [ "$findings" -gt 0 ] || findings=1
    note="$(grep -aoE -m 1 '^finding: .*|(ERROR: |runtime error: ).*' $folder/log | head -n 1 | cut -c 1-160), see $folder/"
  fi
  row $loader "${executions:-0}" "${inputs:-0}" "${edges:-0}" "$findings" $((SECONDS - start)) "$note"
  [ $code = 0 ]
}

row loader executions inputs edges findings seconds ""
failed=0 running=0
for loader in $loaders; do
  [ $running -lt "${JOBS:-$(nproc)}" ] || { wait -n || failed=1; running=$((running - 1)); }
  fuzz $loader &
  running=$((running + 1))
done
while [ $running -gt 0 ]; do wait -n || failed=1; running=$((running - 1)); done
exit $failed
