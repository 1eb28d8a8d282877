#!/bin/bash
# Builds the fuzzers of tests/fuzz and runs each for some seconds, JOBS at a time: tools/run-fuzzers.sh [SECONDS] [JOBS].
# All of them run, whatever one finds. An input that crashes, takes 10 s or 2 GiB is a finding and lies in
# build/fuzz/findings/; what a fuzzer learns is kept in build/fuzz/corpus/ for the next run, what it said in build/fuzz/logs/.
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

export LSAN_OPTIONS="suppressions=$PWD/tools/lsan-suppressions.txt"
run() {
    local name=$1 seconds=$2
    local corpus="build/fuzz/corpus/$name" log="build/fuzz/logs/$name.log" seeds=()
    mkdir -p "$corpus" build/fuzz/findings build/fuzz/logs
    [ -d "tests/fuzz/${name%_fuzz}" ] && seeds=("tests/fuzz/${name%_fuzz}")
    if build/fuzz/bin/"$name" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 \
        -artifact_prefix="build/fuzz/findings/$name-" "$corpus" "${seeds[@]}" >"$log" 2>&1; then
        echo "run-fuzzers: $name: $(awk '/number_of_executed_units/ { print $2 }' "$log") inputs in $seconds s, no finding"
    else
        tail -n 60 "$log"
        echo "run-fuzzers: $name: a finding, see $log"
        return 1
    fi
}
export -f run
for source in tests/fuzz/*_fuzz.cpp; do basename "$source" .cpp; done | xargs -P "$jobs" -I{} bash -euo pipefail -c 'run {} '"$seconds"
