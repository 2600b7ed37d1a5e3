#!/usr/bin/env bash
# Runs the tests of the unsafe code, and of the loaders, under AddressSanitizer. Needs a nightly toolchain.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! rustup run nightly rustc --version >/dev/null 2>&1; then
    echo "make asan: no nightly toolchain is installed, and the sanitizer needs one: rustup toolchain install nightly" >&2
    exit 2
fi
host=$(rustup run nightly rustc -vV | sed -n 's/^host: //p')
export RUSTFLAGS="-Zsanitizer=address" CARGO_TARGET_DIR=target/asan
# Build scripts and macros are not instrumented, because the target is given.
rustup run nightly cargo test --target "$host" -p gi-bvh --lib
rustup run nightly cargo test --target "$host" -p gi-scene --test files --test fuzz
