#!/usr/bin/env bash
# fuzz.sh FOLDER SECONDS [READER...]: libFuzzer on the readers that the program FOLDER/build/fuzz_inputs
# knows, or on those named, for SECONDS each, one on each core, with 512 MB and 5 s for an input.
# FUZZ_SEED=N: the same inputs in each run on the same machine, as far as the seconds reach.
# Reports the number of executions; a failing input, the logs and the corpora lie in FOLDER.
set -euo pipefail
export folder=$1 seconds=$2
shift 2
export seed=${FUZZ_SEED:-0}
export program=$folder/build/fuzz_inputs
# Freed memory is not kept back for long: it counts among the 512 MB.
export ASAN_OPTIONS=${ASAN_OPTIONS:-quarantine_size_mb=16}

one_reader() {
  export LAMELLA_READER=$1
  # Of grids a child reads, which is ended after ten seconds of its own.
  local limit=5 corpus=$folder/corpus/$1 log=$folder/fuzz-$1.log verdict=passed failed=0 count
  if [ "$1" = vdb ]; then limit=60; fi
  "$program" --seeds "$corpus" >/dev/null
  if ! "$program" -seed="$seed" -max_total_time="$seconds" -max_len=65536 -timeout="$limit" \
    -rss_limit_mb=512 -print_final_stats=1 -verbosity=1 \
    -artifact_prefix="$folder/$1-" "$corpus" >"$log" 2>&1; then verdict=FAILED failed=1; fi
  count=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  printf '%-9s %s: %s executions, %s inputs in the corpus\n' "$1" "$verdict" "${count:-no}" \
    "$(find "$corpus" -type f | wc -l)"
  # What went wrong, for who sees this output alone.
  if [ $failed = 1 ]; then tail -n 40 "$log"; fi
  return $failed
}
export -f one_reader

if [ $# -gt 0 ]; then printf '%s\n' "$@"; else "$program" --list; fi |
  xargs -P "$(nproc)" -I READER bash -c 'one_reader READER'
