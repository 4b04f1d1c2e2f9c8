#!/bin/sh
# run.sh BUILD SOURCE RECORDING: installs the build tree into a folder of its own, checks that the installed
# headers need none that is not installed, builds the consumer against the package, runs it on the recording.
set -eu
build=$1 source=$2 recording=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --install "$build" --prefix "$work/prefix" > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }
(cd "$work/prefix/include/ardent" && find . -name '*.hpp') | sed 's|^\./\(.*\)|#include "\1"|' > "$work/all.cpp"
# shellcheck disable=SC2046
c++ -std=c++20 -fsyntax-only -I "$work/prefix/include/ardent" $(pkg-config --cflags eigen3) "$work/all.cpp"
cmake -S "$source" -B "$work/build" -G Ninja -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_BUILD_TYPE=Release > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }
cmake --build "$work/build" > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }
"$work/build/consumer" "$recording"
"$work/prefix/bin/ardent" --version > /dev/null
