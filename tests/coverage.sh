#!/bin/sh
# Lines and branches the tests reach, by folder, and a page a file in build/coverage/html. Branches that only a throw
# takes are left out: every call has one.
set -eu
cmake --preset coverage -DARDENT_TESTS=ON "$@"
cmake --build --preset coverage
find build/coverage -name '*.gcda' -delete
ctest --preset coverage
mkdir -p build/coverage/html
gcovr --root . --object-directory build/coverage -j 2 --exclude-throw-branches --exclude-unreachable-branches \
  --filter '(dsp|sim|ident|apps)/' --json-summary build/coverage/summary.json \
  --html-details build/coverage/html/index.html >/dev/null
