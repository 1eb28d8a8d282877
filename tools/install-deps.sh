#!/bin/bash
# Installs what packages.txt lists and this machine lacks; quick and silent when everything is there.
# Usage: tools/install-deps.sh [GROUP...]   (groups: lint, fuzz, bench)
set -euo pipefail
cd "$(dirname "$0")"

packages=$(awk -v groups=" $* " '/^[^#]/ && ($2 == "" || index(groups, " " $2 " ")) { print $1 }' packages.txt)

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "install-deps: this system has no apt; install these packages' equivalents yourself (then use CMake directly):" $packages >&2
    exit 1
fi

missing=""
installed=$(dpkg-query -W -f '${db:Status-Abbrev} ${Package}\n' | awk '$1 == "ii" { print $2 }')
for package in $packages; do
    grep -qxF -- "$package" <<<"$installed" || missing+=" $package"
done
[ -z "$missing" ] && exit 0

sudo=""
if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
        echo "install-deps: missing packages:$missing; run 'apt-get install$missing' as root" >&2
        exit 1
    fi
    sudo="sudo"
fi
echo "install-deps: installing$missing" >&2
$sudo apt-get update -qq
# shellcheck disable=SC2086  # the list is split on purpose
$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends -o Dpkg::Use-Pty=0 $missing >/dev/null
