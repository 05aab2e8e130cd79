#!/bin/bash
# Runs every kernel and form under clang's thread sanitizer, which must find no race. Then runs the racy twin,
# tests/tsan/racy.cpp; the sanitizer must flag each of its mistakes every time. `make tsan` builds build/tsan/ and calls
# it. Arguments select kernels.
#
# Kernels and their scenes come from `lockstep list`, so a new one cannot be forgotten. The inputs exceed one chunk of
# every loop, and one band of every sweep, at two threads and at four. A kernel passes if no race is found and the
# verifier passes it, too. The exit code is 1 if any row fails. The log of each run stays in build/tsan/. With QUICK=1
# each form runs on one scene. THREADS=64 runs forms on so many, and SCENES="a b" on the first of these that is a form's
# own, one of bench if it can be, with all of its bodies (verify/nightly.py).
set -u
cd "$(dirname "$0")/.." || exit 1
build=build/tsan
threads=${THREADS:-2,4}
repeats=${QUICK:+2} repeats=${repeats:-5}  # of each mistake

# Archer tells the sanitizer what OpenMP orders. 66 is the exit code of a report. Archer guards its own table of locks
# with one mutex. If the sanitizer saw that mutex, it would order any lock after every other and hide most races of code
# that takes locks, above all those under a wrong lock (racy twin, list_under_wrong_lock). The suppression hides the
# mutex.
echo "called_from_lib:libarcher.so" > $build/suppressions
export TSAN_OPTIONS="ignore_noninstrumented_modules=1 halt_on_error=1 exitcode=66 suppressions=$PWD/$build/suppressions"
export OMP_TOOL_LIBRARIES=${OMP_TOOL_LIBRARIES:-/usr/lib/llvm-14/lib/libarcher.so} ARCHER_OPTIONS=verbose=1

passed=0 failed=0

# shorten DOMAIN SCENE: a copy of a scene with few frames, bodies and iterations. `make verify` covers whole runs, and a
# race shows in one step. A cloth keeps three iterations, because the iterations of chains overlap. Conjugate gradients
# end at a tenth of the residual. A frame of the liquid is 5 ms, so that it has fewer substeps.
shorten() {
  local short='s/^kind *= *"linear"/&\ntolerance = 0.1/; /^frame_time/d'
  short+='; s/^kind *= *"production_fluid"/&\nframe_time = 0.005/'
  local bodies='s/^count *=.*/count = 400/; s/^settle *=.*/settle = 30/'
  [ -z "${SCENES:-}" ] || bodies='s/^settle *=.*/settle = 3/'
  sed -E "$short; s/^frames *=.*/frames = 5/; s/^iterations *=.*/iterations = 3/; s/^substeps *=.*/substeps = 2/; /^energy_falls_after/d; $bodies" \
    "scenes/$1/$2.toml" > "$build/$2.toml"
}

# Runs a command with its output in $log. Sets $seen to the result: clean, race, or what went wrong. Exit code 66 alone
# does not mean a race: the sanitizer also ends with it if it cannot start.
observe() {
  "$@" > "$log" 2>&1
  local code=$?
  if ! grep -q '^Archer detected OpenMP application with TSan' "$log"; then seen="no Archer, exit $code"
  elif grep -q '^WARNING: ThreadSanitizer: data race' "$log"; then seen=race
  elif [ $code = 0 ]; then seen=clean
  else seen="exit $code"; fi
}

row() { printf '%-19s %-25s %-15s %7s  %-14s %-14s %7s  %s\n' "$@"; }

# report KERNEL FORM SCENE THREADS EXPECTED START: prints a row with $seen, and names the log if it is not EXPECTED.
report() {
  local note="" seconds=$(( ($(date +%s%N) - $6) / 10000000 ))
  if [ "$seen" = "$5" ]; then passed=$((passed + 1)); else failed=$((failed + 1)) note="FAILED: see $log"; fi
  row "$1" "$2" "$3" "$4" "$5" "$seen" "$((seconds / 100)).$(printf %02d $((seconds % 100)))" "$note"
}

# clean KERNEL FORM SCENE THREADS COMMAND...
clean() {
  local start; start=$(date +%s%N)
  log=$build/$(echo "$1-$2-$3" | tr -s '/ -' _).log
  observe "${@:5}"
  report "$1" "$2" "$3" "$4" clean "$start"
}

row kernel form scene threads expected seen seconds ""
# Lines of kernel, form and scenes, separated by |, without Archer, which would print among them. Forms that run another
# form's code are left out.
forms=$(OMP_TOOL=disabled $build/lockstep list --json | /usr/bin/python3 -c '
import json, os, sys
large = os.environ.get("SCENES", "").split()
for row in json.load(sys.stdin)["rows"]:
    if not row["covered_by"]:
        own = [scene for scene in large if scene in row["scenes"] + row["more_scenes"]]
        own = ([scene for scene in own if scene in row["bench_scenes"]] + own)[:1]  # which bench has is full of work
        print(row["kernel"], row["form"], " ".join(own if large else row["tsan_scenes"]), sep="|")')
cp scenes/*/*.{obj,mtx} $build/  # what scenes name beside them

while IFS="|" read -r kernel form scenes; do
  [[ $# = 0 || " $* " = *" $kernel "* ]] || continue
  [ -n "$scenes" ] || { seen="no scene" log=$0; report "$kernel" "$form" - - clean "$(date +%s%N)"; }
  [ -z "${QUICK:-}" ] || scenes=${scenes%% *}
  for scene in $scenes; do
    shorten "${kernel%%/*}" $scene
    clean "$kernel" "$form" $scene $threads $build/lockstep verify --kernel "$kernel" --form "$form" --scene $build/$scene.toml --threads $threads
  done
  # The first frames of the clump: all particles are in one cell, so all threads take one lock.
  if [ "$kernel" = fluid/step ]; then
    shorten fluid clump
    clean "$kernel" "$form" "clump start" ${threads##*,} $build/lockstep run --form "$form" --scene $build/clump.toml --threads ${threads##*,} --frames 2 --out $build/clump.fluid
  fi
done <<< "$forms"
[ $((passed + failed)) -gt 0 ] || { echo "no kernel $*"; failed=1; }
kernel_rows=$((passed + failed))

while read -r mistake scene; do
  log=$build/racy_$mistake.log start=$(date +%s%N) flagged=0 other=""
  for ((repeat = 0; repeat < repeats; ++repeat)); do
    OMP_NUM_THREADS=$((2 + repeat % 2 * 2)) observe $build/racy "$mistake"
    if [ "$seen" = race ]; then flagged=$((flagged + 1)); else other=", $seen"; fi
  done
  seen="race $flagged of $repeats$other"
  report "racy twin" "$mistake" "$scene" 2,4 "race $repeats of $repeats" "$start"
done < <($build/racy 2>/dev/null)
[ $((passed + failed)) -gt $kernel_rows ] || { echo "$build/racy lists no mistake"; failed=$((failed + 1)); }
echo "$passed passed, $failed failed"
[ $failed = 0 ]
