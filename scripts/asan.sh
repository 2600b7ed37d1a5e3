#!/usr/bin/env bash
# Runs the tests of the unsafe code, and of the loaders, under AddressSanitizer: with a nightly toolchain if there is
# one, otherwise with the installed compiler.
set -euo pipefail
cd "$(dirname "$0")/.."

toolchain=()
if rustup run nightly rustc --version >/dev/null 2>&1; then
    toolchain=(rustup run nightly)
else
    # Other compilers have the sanitizer too, but accept its flag only like this.
    export RUSTC_BOOTSTRAP=1
fi
host=$("${toolchain[@]}" rustc -vV | sed -n 's/^host: //p')
libraries=$("${toolchain[@]}" rustc --print sysroot)/lib/rustlib/$host/lib
if ! compgen -G "$libraries/*asan*" >/dev/null; then
    echo "make asan: the compiler's libraries contain no AddressSanitizer: rustup toolchain install nightly" >&2
    exit 2
fi
export RUSTFLAGS="-Zsanitizer=address" CARGO_TARGET_DIR=target/asan
# Build scripts and macros are not instrumented, because the target is given.
"${toolchain[@]}" cargo test --target "$host" -p gi-bvh --lib
"${toolchain[@]}" cargo test --target "$host" -p gi-scene --test files --test fuzz
