#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "support/scratch.hpp"

namespace fuzz {

/// Files that other software wrote.
inline std::vector<std::string> samples(const std::vector<std::string>& names) {
  std::vector<std::string> all;
  for (const std::string& name : names) all.push_back(support::bytes_of(std::filesystem::path(ARDENT_SAMPLES) / name));
  return all;
}

}  // namespace fuzz
