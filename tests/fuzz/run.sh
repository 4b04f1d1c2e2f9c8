#!/bin/sh
# run.sh SECONDS [HARNESS] [SEED]: fuzzes every harness, or the one, for its part of SECONDS, two at a time. Corpora are
# in build/fuzz/corpus and grow from run to run; what crashes, hangs or takes too much memory goes to build/fuzz/found.
# The same SEED on the same corpus tries the same inputs as far as the clock allows. Ends 1 if anything was found.
# To keep a find: build/fuzz/fuzz_NAME -minimize_crash=1 -runs=100000 FILE, and the result into tests/fuzz/cases/NAME.
set -eu
cd "$(dirname "$0")/../.."
build=$PWD/build/fuzz at_once=2

# Bytes: a recording is a small file, a document a few screens.
longest() {
  case $1 in
    hdf5) echo 16384 ;;
    sound | matlab) echo 8192 ;;
    run_folder) echo 40000 ;;
    terms | command_line) echo 512 ;;
    *) echo 4096 ;;
  esac
}

# Each find ends libFuzzer; it is begun again with another seed until the time is up.
fuzz_one() { # fuzz_one NAME SECONDS SEED
  corpus=$build/corpus/$1 found=$build/found/$1 log=$build/fuzz_$1.log dictionary=tests/fuzz/$1.dict
  mkdir -p "$corpus" "$found"
  "$build/fuzz_$1" --write-seeds "$corpus" >"$log" 2>&1
  [ -f "$dictionary" ] || dictionary=""
  start=$(date +%s) seed=$3
  while left=$((start + $2 - $(date +%s))) && [ $left -gt 0 ]; do
    "$build/fuzz_$1" -max_total_time=$left -seed="$seed" -timeout=5 -rss_limit_mb=1024 -malloc_limit_mb=256 \
      -max_len="$(longest "$1")" ${dictionary:+"-dict=$dictionary"} -artifact_prefix="$found/" -close_fd_mask=3 \
      -print_final_stats=1 "$corpus" >>"$log" 2>&1 || seed=$((seed + 1))
    # An end without a find is no find but a mistake in these options: it would come again at once.
    [ "$(grep -c "Test unit written to" "$log")" -ge $((seed - $3)) ] || { tail -3 "$log" >&2; return 2; }
  done
  awk -v name="$1" -v found="$found" '
    /^stat::number_of_executed_units:/ { executions += $2 }
    /Test unit written to / { find[$NF ~ /\/timeout-/ ? "hangs" : $NF ~ /\/oom-/ ? "memory" : "crashes"]++; any = 1 }
    END { printf "%-13s %9d executions, %d crashes, %d time-outs, %d over memory%s\n", name, executions, find["crashes"],
            find["hangs"], find["memory"], any ? "; inputs in " found : "" }' "$log"
  ! grep -q "Test unit written to" "$log"
}

if [ "$1" = --one ]; then
  fuzz_one "$2" "$3" "$4"
  exit
fi
harnesses=${2:-$(sed -n 's/^ardent_fuzz(\([a-z0-9_]*\) .*/\1/p' tests/fuzz/CMakeLists.txt)}
count=$(echo "$harnesses" | wc -w)
TMPDIR=$(mktemp -d "${TMPDIR:-/dev/shm}/ardent-fuzz-XXXXXX")
export TMPDIR ASAN_OPTIONS=quarantine_size_mb=16
trap 'rm -rf "$TMPDIR"' EXIT
trap 'exit 130' INT TERM
share=$((count > at_once ? $1 * at_once / count : $1))
echo "$harnesses" | tr ' ' '\n' | xargs -P $at_once -I NAME "$0" --one NAME "$share" "${3:-1}" || exit 1
