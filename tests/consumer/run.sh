#!/usr/bin/env bash
# Installs the build tree into a folder, configures the consumer against it, builds and runs it.
# usage: run.sh BUILD_FOLDER
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
build=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --install "$build" --prefix "$work/installed" >/dev/null
cmake -S "$here" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Debug -DCMAKE_PREFIX_PATH="$work/installed" >/dev/null
cmake --build "$work/build"
cd "$work"
"$work/build/consumer"
test -s out.ply
"$work/installed/bin/beltrami" --version
