#!/bin/sh
# One definition of every type and function over all files (link-time optimisation sees them together), clang-tidy with
# the checks of .clang-tidy, the formatting of .clang-format; the fuzz harnesses, with clang, as ./run fuzz builds them;
# and that what refers into an object is handed out by lvalues only.
set -eu

# Of an object that is gone at the end of the line nobody is to keep a part: an accessor that returns a reference, a
# pointer or a view is `const&`, with `void NAME() const&& = delete;` beside it, or `&`. The compiler refuses then what
# only some of them warn of.
git ls-files -z '*.hpp' | xargs -0 awk '
  function report(place, what) { print place ": " what; found = 1 }
  FNR == 1 { member = "" }
  { sub(/\/\/.*/, "") }
  /^ *(public|private|protected):/ || /^#/ { next }
  member == "" { line = FNR }
  { member = member $0; gsub(/= [{][}]/, "", member) }
  /[;{}]/ || $0 == "" {
    sub(/[;{}].*/, "", member)
    name = member; sub(/[(].*/, "", name); sub(/.*[ &*]/, "", name)
    if (member ~ /^  +(\[\[nodiscard\]\] )?[A-Za-z][A-Za-z0-9_:<>, ]*([&*]|_view|span<.*>|Map<.*>|Ref<.*>) [a-z_]+[(].*[)]/) {
      if (member ~ /[)]( const)?( noexcept)?( override)?( = 0)? *$/) report(FILENAME ":" line, name " is to be called on lvalues only")
      if (member ~ /[)] const&( noexcept)?( override)?( = 0)? *$/) left[FILENAME ": " name]++ }
    if (member ~ /^  +void [a-z_]+[(].*[)] const&& = delete *$/) left[FILENAME ": " name]--
    member = "" }
  END { for (one in left) if (left[one] > 0) report(one, "is not deleted for const&&")
        exit found }'

cmake --preset lint
cmake --build --preset lint
git ls-files -z 'dsp/*.cpp' 'sim/*.cpp' 'ident/*.cpp' 'apps/*.cpp' |
  xargs -0 -P "$(nproc)" -n 4 clang-tidy -quiet -p build/lint --warnings-as-errors='*'
git ls-files -z '*.cpp' '*.hpp' | xargs -0 clang-format --dry-run -Werror
cmake --preset fuzz
cmake --build --preset fuzz
