#!/usr/bin/env bash
# fuzz.sh BUILD SECONDS READER...: libFuzzer on readers, one after the other, for SECONDS each, with
# 512 MB and 5 s for an input. Reports the number of executions; a failing input lies in BUILD.
set -euo pipefail
build=$1 seconds=$2
shift 2
# Freed memory is not kept back for long: it counts among the 512 MB.
export ASAN_OPTIONS=${ASAN_OPTIONS:-quarantine_size_mb=16}
failed=0
for reader in "$@"; do
  # Of grids a child reads, which is ended after ten seconds of its own.
  limit=5
  if [ "$reader" = vdb ]; then limit=60; fi
  corpus=$build/corpus/$reader log=$build/fuzz-$reader.log
  "$build/tests/fuzz_$reader" --seeds "$corpus" >/dev/null
  if "$build/tests/fuzz_$reader" -max_total_time="$seconds" -max_len=65536 -timeout="$limit" \
    -rss_limit_mb=512 -print_final_stats=1 -verbosity=1 \
    -artifact_prefix="$build/$reader-" "$corpus" >"$log" 2>&1; then verdict=passed; else
    verdict=FAILED failed=1
  fi
  count=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  printf '%-9s %s: %s executions, %s inputs in the corpus\n' "$reader" "$verdict" "${count:-no}" \
    "$(find "$corpus" -type f | wc -l)"
done
exit $failed
