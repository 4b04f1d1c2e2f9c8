#!/bin/sh
# Every accessor of the headers that hands out a part of its object, read by its declaration.
set -eu
cd "$(dirname "$0")/.."

# Of an object that is gone at the end of the line nobody is to keep a part: an accessor that returns a reference, a
# pointer or a view is `const&`, with `void NAME() const&& = delete;` beside it, or `&`. The compiler refuses then what
# only some of them warn of.
find dsp sim ident apps tests -name '*.hpp' | sort | xargs awk '
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
