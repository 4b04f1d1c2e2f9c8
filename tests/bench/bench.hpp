#pragma once
#include <filesystem>
#include <functional>

namespace bench {

/// CPU seconds, user and system, of this process and of the children it waited for.
[[nodiscard]] double cpu_s(const std::function<void()>& work);
/// What nobody can go below who reads through libsndfile: every sample as a double, and nothing done with it.
void bare_read(const std::filesystem::path& file);

/// What a run does to each raw sample, over 200 s, against a bare read; the decimator alone against soxr.
void raw_part(const std::filesystem::path& folder);
/// `ardent run` on 1800 s of the rig's raw record, against a bare read, and how much of it is hashing.
void whole_run(const std::filesystem::path& ardent, const std::filesystem::path& folder);

}  // namespace bench
