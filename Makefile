# The usual ways to build and check Spinel. CMake does the work (see CMakePresets.json); every target first makes sure
# that the needed Debian packages are there. Builds land in build/<preset>/.
JOBS ?= $(shell nproc)
FUZZ_SECONDS ?= 20
PROGRAM := build/release/bin/spinel

.PHONY: all build demo test test-all bench format lint fuzz clean install-deps
all: build

install-deps:
	@tools/install-deps.sh

# The presets file alone is a prerequisite: a configured build re-runs CMake by itself.
build/%/build.ninja: CMakePresets.json | install-deps
	cmake --preset $*
	@touch $@

build: install-deps build/release/build.ninja
	@cmake --build --preset release -j $(JOBS)

# The program alone: the tests of a full build are not waited for.
demo: install-deps build/release/build.ninja
	@cmake --build --preset release -j $(JOBS) --target spinel_cli
	@mkdir -p out
	$(PROGRAM) render examples/demo.json -o out/demo.png

test: build
	@cmake --build --preset release -j $(JOBS) --target check_headers
	ctest --preset release

test-all: test build/asan/build.ninja build/tsan/build.ninja
	ctest --preset release-slow
	@cmake --build --preset asan -j $(JOBS)
	ctest --preset asan
	@cmake --build --preset tsan -j $(JOBS)
	ctest --preset tsan
	@$(MAKE) fuzz

# Each fuzzer runs for FUZZ_SECONDS; a finding leaves its input in build/fuzz/ and fails the target.
fuzz:
	@tools/install-deps.sh fuzz
	@tools/run-fuzzers.sh $(FUZZ_SECONDS) $(JOBS)

bench: build
	@cmake --build --preset release -j $(JOBS) --target spinel_bench
	build/release/bin/spinel_bench

format:
	@tools/install-deps.sh lint
	@tools/format.sh -i

lint: build
	@tools/install-deps.sh lint
	@tools/check-includes.py
	@cmake --build --preset release -j $(JOBS) --target check_headers
	@tools/format.sh --dry-run -Werror
	@cmake --preset lint > /dev/null
	@tools/clang-tidy.py $(JOBS)

clean:
	rm -rf build out
