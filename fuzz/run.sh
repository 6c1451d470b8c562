#!/usr/bin/env bash
# Fuzzes every target in turn: fuzz/run.sh SECONDS [TARGET...]. Needs the nightly compiler and
# cargo-fuzz (cargo install cargo-fuzz). Ends with an error at the first finding.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds="${1:?usage: fuzz/run.sh SECONDS [TARGET...]}"
shift
[ $# -gt 0 ] || mapfile -t targets < <(cd fuzz/fuzz_targets && printf '%s\n' *.rs | sed 's/\.rs$//')
[ $# -eq 0 ] || targets=("$@")
for target in "${targets[@]}"; do
  printf '\n== %s for %s seconds\n' "$target" "$seconds"
  mkdir -p "fuzz/corpus/$target"
  folders=("fuzz/corpus/$target")
  [ ! -d "fuzz/seeds/$target" ] || folders+=("fuzz/seeds/$target")
  cargo +nightly fuzz run --fuzz-dir fuzz "$target" "${folders[@]}" -- \
    -max_total_time="$seconds" -max_len=4096 -timeout=10 -rss_limit_mb=1024 -malloc_limit_mb=512 \
    -dict="fuzz/dictionaries/$target.dict" -print_final_stats=1
done
