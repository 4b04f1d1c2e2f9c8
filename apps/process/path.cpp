#include "apps/process/path.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <system_error>

namespace apps {
namespace fs = std::filesystem;

fs::path resolved_path(const fs::path& path) {
  std::error_code error;
  fs::path result = fs::absolute(path, error);
  if (error) result = path;
  const fs::path followed = fs::weakly_canonical(result, error);
  result = error ? result.lexically_normal() : followed;
  return result.has_filename() ? result : result.parent_path();
}

fs::path named_path(const fs::path& path) {
  const fs::path bare = path.has_filename() ? path : path.parent_path();
  return bare.filename() == "." || bare.filename() == ".." ? resolved_path(bare) : bare;
}

fs::path located_path(const fs::path& path) {
  const fs::path named = named_path(path);
  return resolved_path(named.has_parent_path() ? named.parent_path() : fs::path(".")) / named.filename();
}

std::vector<std::string> distinct_names(const std::vector<fs::path>& paths) {
  std::vector<fs::path> whole;
  for (const fs::path& path : paths) whole.push_back(named_path(path).lexically_normal());
  std::vector<std::string> names;
  std::vector<int> kept(whole.size(), 1);  // how many parts of each make its name
  for (const fs::path& path : whole) names.push_back(path.filename().string());
  for (bool longer = true; longer;) {
    longer = false;
    std::map<std::string, std::set<fs::path>> called;
    for (std::size_t i = 0; i < names.size(); ++i) called[names[i]].insert(whole[i]);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto parts = static_cast<int>(std::distance(whole[i].begin(), whole[i].end()));
      if (called[names[i]].size() < 2 || kept[i] == parts) continue;
      ++kept[i];
      names[i] = (*std::next(whole[i].begin(), parts - kept[i]) / names[i]).string();
      longer = true;
    }
  }
  return names;
}

bool lies_in(const fs::path& inner, const fs::path& outer) {
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

bool is_plain(const fs::path& path) {
  return !path.empty() && path.is_relative() &&
         std::none_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".." || part == "."; });
}

}  // namespace apps
