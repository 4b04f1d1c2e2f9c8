#pragma once
#include <filesystem>
#include <vector>

#include "ident/joint_fit.hpp"

namespace apps {

/// Writes a file of R factors, complete or not at all; nothing where no `file` is named. Throws dsp::Fault: usage
/// "output.overlap" where it is one of the files that were read; output "output.exists" for a file that is there,
/// unless `force` and it holds R factors; "output.foreign", "output.symlink", "output.write". `force` without a file to
/// save is refused (usage).
void save_factors(const std::filesystem::path& file, const std::vector<ident::RecordFactors>& records,
                  const std::vector<std::filesystem::path>& read, bool force);

}  // namespace apps
