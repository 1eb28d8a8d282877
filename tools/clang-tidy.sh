#!/bin/bash
# Runs clang-tidy on the sources that differ from a base commit: tools/clang-tidy.sh [BASE], default: the last commit,
# so uncommitted work and the newest commit; `all` means every source. Version 16 at least: older ones do not know C++20's
# aggregates by parentheses, which the kernels use.
set -euo pipefail
cd "$(dirname "$0")/.."
base=${1:-HEAD~1}

if ! command -v clang-tidy-16 >/dev/null; then
    echo "clang-tidy: clang-tidy-16 is not installed; skipped" >&2
    exit 0
fi
if [ "$base" = all ]; then
    files=$(find src -name '*.cpp' | sort)
else
    files=$(git diff --name-only --diff-filter=d "$base" -- 'src/*.cpp'; git ls-files --others --exclude-standard 'src/*.cpp')
fi
if [ -z "$files" ]; then
    echo "clang-tidy: no source differs from $base"
    exit 0
fi
xargs -P 2 -n 1 clang-tidy-16 -p build/release --quiet --warnings-as-errors='*' <<<"$files"
