#!/bin/sh
# One definition of every type and function over all files (link-time optimisation sees them together), clang-tidy with
# the checks of .clang-tidy, the formatting of .clang-format; the fuzz harnesses, with clang, as ./run fuzz builds them;
# and that what refers into an object is handed out by lvalues only.
set -eu

tests/handed_out.sh
cmake --preset lint
cmake --build --preset lint
git ls-files -z 'dsp/*.cpp' 'sim/*.cpp' 'ident/*.cpp' 'apps/*.cpp' |
  xargs -0 -P "$(nproc)" -n 4 clang-tidy -quiet -p build/lint --warnings-as-errors='*'
git ls-files -z '*.cpp' '*.hpp' | xargs -0 clang-format --dry-run -Werror
cmake --preset fuzz
cmake --build --preset fuzz
