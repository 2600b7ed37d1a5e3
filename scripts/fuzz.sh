#!/usr/bin/env bash
# Fuzzes all kinds of inputs, or those that are named, SECONDS for each: scripts/fuzz.sh SECONDS [KIND...]
# Coverage-guided with libFuzzer, which needs a C++ compiler. Inputs that reach new code stay in target/fuzz/KIND, and
# an input that fails is kept beside them; a later run continues with them.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:?usage: scripts/fuzz.sh SECONDS [KIND...]}
shift

if ! command -v "${CXX:-c++}" >/dev/null; then
    echo "make fuzz: coverage-guided fuzzing is skipped, because it needs a C++ compiler: install one, or set CXX" >&2
    exit 0
fi
host=$(rustc -vV | sed -n 's/^host: //p')
export CARGO_TARGET_DIR=$PWD/target/fuzz-build
# Build scripts and macros are not instrumented, because the target is given.
RUSTFLAGS="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table
    -Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing" \
    cargo build --release --locked --manifest-path tests/coverage/Cargo.toml --target "$host"
program=$CARGO_TARGET_DIR/$host/release/coverage

mapfile -t all < <(GILAB_FUZZ_KIND=list "$program" 2>/dev/null)
for kind in "$@"; do
    case " ${all[*]} " in
        *" $kind "*) ;;
        *) echo "make fuzz: there is no kind \`$kind\`; the kinds are ${all[*]}" >&2; exit 2 ;;
    esac
done
[ $# -gt 0 ] || set -- "${all[@]}"
failed=0
for kind in "$@"; do
    found=$PWD/target/fuzz/$kind
    mkdir -p "$found/corpus"
    # A busy machine is no hang: the program measures processor time, and -timeout is for what never ends.
    if ! GILAB_FUZZ_KIND=$kind GILAB_FUZZ_SEEDS=$found/corpus "$program" -max_total_time="$seconds" -timeout=100 \
        -rss_limit_mb=2048 -print_final_stats=1 -artifact_prefix="$found/" "$found/corpus" >"$found/log" 2>&1; then
        echo "make fuzz: $kind fails, and its input is kept: see $found/log" >&2
        failed=1
    fi
    inputs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$found/log")
    edges=$(grep -o 'cov: [0-9]*' "$found/log" | tail -1)
    echo "$kind: ${inputs:-unknown number of} inputs in $seconds s, ${edges#cov: } branches of the code reached"
done
exit $failed
