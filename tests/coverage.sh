#!/bin/sh
# Lines and branches the tests reach, by folder, and a page a file in build/coverage/html; of the files whose words a
# person reads first, each line and branch that no test reaches: words can be wrong, too, and end the program. Branches that only a throw
# takes are left out: every call has one. So are the consumer, which is linked without coverage's library, and the tests
# that fail one write or allocation after the other, and that of memory: coverage's own would be among them.
set -eu
cmake --preset coverage -DARDENT_TESTS=ON "$@"
cmake --build --preset coverage
find build/coverage -name '*.gcda' -delete
ctest --preset coverage
mkdir -p build/coverage/html
gcovr --root . --object-directory build/coverage -j 2 --exclude-throw-branches --exclude-unreachable-branches \
  --filter '(dsp|sim|ident|apps)/' --csv build/coverage/files.csv --html-details build/coverage/html/index.html
awk -F, '
  NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
  { split($1, path, "/")
    for (i = 1; i <= 2; i++) { folder = i == 1 ? path[1] : "all"
      lines[folder] += $at["line_total"]; reached[folder] += $at["line_covered"]
      branches[folder] += $at["branch_total"]; taken[folder] += $at["branch_covered"] } }
  END { for (folder in lines) if (folder != "all") print_one(folder); print_one("all") }
  function percent(part, whole) { return whole > 0 ? 100 * part / whole : 0 }
  function print_one(folder) {
    printf "%-6s %6d lines %5.1f %%  %6d branches %5.1f %%\n", folder, lines[folder],
      percent(reached[folder], lines[folder]), branches[folder], percent(taken[folder], branches[folder]) }
' build/coverage/files.csv
words='apps/(page/(first_screen|remedies|page|range_section|record_section|run_results)|output/report_text)\.cpp'
for what in "" --branches; do
  gcovr --root . --object-directory build/coverage -j 2 --exclude-throw-branches --exclude-unreachable-branches \
    --filter "$words" $what
done
echo "file by file: build/coverage/html/index.html"
