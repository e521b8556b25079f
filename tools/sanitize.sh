#!/bin/sh
# Miri over the geometry and a small step of every kind of cloth, ThreadSanitizer over the pool: `make sanitize`.
# Both need a nightly compiler; where there is none, this says what to install and does nothing.
set -eu
cd "$(dirname "$0")/.."
export CARGO_INCREMENTAL=0

here() { rustup component list --toolchain nightly 2>/dev/null | grep -q "^$1.*(installed)"; }

if ! here rust-src || ! here miri; then
    echo "not run: rustup toolchain install nightly --component miri,rust-src"
    exit 0
fi

host=$(rustc -vV | sed -n 's/^host: //p')

echo "Miri: undefined behaviour"
# Clocks and files are only looked at by the test harness.
MIRIFLAGS=-Zmiri-disable-isolation cargo +nightly miri test --package taut --target-dir target/miri --lib -- geometry
MIRIFLAGS=-Zmiri-disable-isolation cargo +nightly miri test --package taut --target-dir target/miri --test sanitizers

echo "ThreadSanitizer: data races"
RUSTFLAGS=-Zsanitizer=thread cargo +nightly test -Zbuild-std --target "$host" --package taut --target-dir target/tsan --test sanitizers
