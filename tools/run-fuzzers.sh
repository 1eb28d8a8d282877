#!/bin/bash
# Builds the fuzzers of tests/fuzz and runs each for some seconds: tools/run-fuzzers.sh [SECONDS] [JOBS].
# What a fuzzer finds lies in build/fuzz/findings/; what it learns is kept in build/fuzz/corpus/ for the next run.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-20}
jobs=${2:-2}

if ! compgen -G 'tests/fuzz/*_fuzz.cpp' >/dev/null; then
    echo "run-fuzzers: there is no tests/fuzz/*_fuzz.cpp"
    exit 0
fi
cmake --preset fuzz
cmake --build --preset fuzz -j "$jobs" --target fuzzers
mkdir -p build/fuzz/findings
for source in tests/fuzz/*_fuzz.cpp; do
    name=$(basename "$source" .cpp)
    corpus="build/fuzz/corpus/$name"
    mkdir -p "$corpus"
    seeds=()
    [ -d "tests/fuzz/${name%_fuzz}" ] && seeds=("tests/fuzz/${name%_fuzz}")
    echo "run-fuzzers: $name for $seconds s"
    build/fuzz/bin/"$name" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 -verbosity=0 \
        -artifact_prefix="build/fuzz/findings/$name-" "$corpus" "${seeds[@]}"
done
