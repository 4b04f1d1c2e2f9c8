#!/bin/sh
# Pairs of folders of which each includes a header of the other, with an include either way, and how many there are.
# Usage: tests/folders.sh [TREE]
set -eu
cd "${1:-$(dirname "$0")/..}"

# What two folders need of one another lies in one of them, or in a third below both.
find dsp ident sim apps -name '*.hpp' -o -name '*.cpp' | sort | xargs awk '
  function folder(path) { sub(/\/[^\/]*$/, "", path); return path }
  /^#include "(dsp|ident|sim|apps)\// {
    split($0, quoted, "\"")
    if (folder(FILENAME) != folder(quoted[2])) edges[folder(FILENAME), folder(quoted[2])] = FILENAME " includes " quoted[2] }
  END {
    for (edge in edges) {
      split(edge, end, SUBSEP)
      if (end[1] < end[2] && (end[2], end[1]) in edges) { pairs++; print edges[edge] ", but " edges[end[2], end[1]] } }
    printf "%d pairs of folders that include each other\n", pairs
    exit pairs > 0 }'
