#!/bin/bash
# Runs clang-format with the given options over every C++ and kernel source.
set -euo pipefail
cd "$(dirname "$0")/.."
find src include tests bench -name '*.h' -o -name '*.cpp' | sort | xargs clang-format "$@"
