#!/usr/bin/env python3
"""Runs clang-tidy on every source of src/ that changed, itself or by what it includes, since it was last found clean.

Usage: tools/clang-tidy.py [JOBS]   (after `cmake --preset lint`, whose compile commands it reads)
Version 16 at least: older ones do not know C++20's aggregates by parentheses, which the kernels use.
"""
import concurrent.futures
import json
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

root = pathlib.Path(__file__).resolve().parent.parent
build = root / "build/lint"


def is_clean(command, source, stamp):
    """Whether nothing that the source is made of is younger than the stamp of its last clean run."""
    if not stamp.exists():
        return False
    listing = subprocess.run(shlex.split(command["command"]) + ["-MM", "-MF", "-", "-o", "/dev/null"],
                             cwd=command["directory"], capture_output=True, text=True)
    files = [pathlib.Path(f) for f in listing.stdout.replace("\\\n", " ").split()[1:]]
    clean_at = stamp.stat().st_mtime
    return listing.returncode == 0 and all(f.stat().st_mtime <= clean_at for f in [root / ".clang-tidy", source, *files])


def main():
    jobs = int(sys.argv[1]) if len(sys.argv) > 1 else 2
    tidy = shutil.which("clang-tidy-16")
    if not tidy:
        sys.exit("clang-tidy: clang-tidy-16 is not installed (tools/install-deps.sh lint)")
    # clang does not read what g++ precompiled; without it, every source has to include what it uses. Parameters are g++'s.
    commands = json.loads((build / "compile_commands.json").read_text())
    for command in commands:
        command["command"] = re.sub(r"-Winvalid-pch -include \S+|--param=\S+", "", command["command"])
    plain = build / "clang-tidy"
    plain.mkdir(exist_ok=True)
    (plain / "compile_commands.json").write_text(json.dumps(commands))

    def check(command):
        source = pathlib.Path(command["file"])
        stamp = plain / source.relative_to(root / "src").with_suffix(".clean")
        if is_clean(command, source, stamp):
            return None
        run = subprocess.run([tidy, "-p", plain, "--quiet", "--warnings-as-errors=*", source],
                             capture_output=True, text=True)  # stderr counts what was suppressed
        if run.returncode != 0:
            print(run.stdout or run.stderr, end="", flush=True)
        else:
            stamp.parent.mkdir(parents=True, exist_ok=True)
            stamp.touch()
        return run.returncode == 0

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        results = list(pool.map(check, [c for c in commands if pathlib.Path(c["file"]).is_relative_to(root / "src")]))
    print(f"clang-tidy: {len(results) - results.count(None)} sources checked, {results.count(False)} with findings")
    return 1 if False in results else 0


sys.exit(main())
