#!/bin/sh
# Counts of the tree: code lines (no blanks, no comments) by folder, long functions, long files, long commands, folders
# that include each other.
# Usage: tests/counts.sh [TREE]
set -eu
folders=$(cd "$(dirname "$0")" && pwd)/folders.sh
cd "${1:-$(dirname "$0")/..}"

code() { # code FILE...: lines that are neither blank nor comments
  awk '{ line = $0; sub(/^[ \t]+/, "", line) } line != "" && line !~ /^\/\// && line !~ /^\*/ { n++ } END { print n + 0 }' "$@"
}
sources() { find "$@" -name '*.hpp' -o -name '*.cpp' | sort; }

total=0
for folder in dsp ident sim apps tests; do
  lines=$(sources $folder | xargs cat | code)
  printf '%-8s %6d code lines in %d files\n' $folder "$lines" "$(sources $folder | wc -l)"
  total=$((total + lines))
done
printf '%-8s %6d code lines\n' total "$total"

# The layout is clang-format's: a function at namespace scope begins in column 0, its head goes on until a line that ends
# with a brace, and it ends with a brace in column 0.
sources dsp ident sim apps | xargs awk '
  FNR == 1 { head = inside = 0 }
  !inside && !head && /^[A-Za-z].*\(/ && !/;$/ && !/^(namespace|constexpr|struct|class|enum|extern|union|using)/ { head = 1; lines = 0; from = FNR }
  head && /;$/ { head = 0 }
  head && /\{$/ { head = 0; inside = 1; next }
  inside && /^\}/ { functions++; if (lines > 60) { over++; printf "function of %d lines: %s:%d\n", lines, FILENAME, from } inside = 0 }
  inside { line = $0; sub(/^[ \t]+/, "", line); if (line != "" && line !~ /^\/\//) lines++ }
  END { printf "%d functions, %d of more than 60 lines\n", functions, over }'
sources dsp ident sim apps | while read -r file; do
  lines=$(wc -l < "$file")
  [ "$lines" -le 400 ] || printf 'file of %d lines: %s\n' "$lines" "$file"
done
commands=apps/cli
[ -d $commands ] && sources $commands | while read -r file; do
  lines=$(code "$file")
  [ "$lines" -le 100 ] || printf 'command of %d code lines: %s\n' "$lines" "$file"
done
[ ! -f ident/regression/fast_rvm.cpp ] || printf 'Algorithm 1, ident/regression/fast_rvm.cpp: %d code lines\n' "$(code ident/regression/fast_rvm.cpp)"
"$folders" . | tail -n 1
