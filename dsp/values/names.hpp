#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace dsp {

/// A name from a file, fit to be shown: invalid UTF-8 becomes U+FFFD, control characters are escaped (\x1b), and what
/// goes beyond 200 characters is cut and ends in "...". Surrounding blanks are dropped.
[[nodiscard]] std::string clean_name(std::string_view raw);

/// ASCII letters in lower case, everything else as it is.
[[nodiscard]] std::string lower(std::string_view text);

/// A name fit for a path: [a-z0-9_-] only, at most 64 characters, never empty and never a reserved device name.
[[nodiscard]] std::string slug(std::string_view name);

/// The candidate with the smallest edit distance; where none is near (a third of the word, at least 2), one that begins
/// with the word; else empty.
[[nodiscard]] std::string nearest(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace dsp
