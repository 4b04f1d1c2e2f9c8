#pragma once
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/io/array_file.hpp"

// What texts of a container say of its numbers: names and units of columns, under keys as people choose them.

namespace dsp {

/// The texts among arrays, which must outlive it.
class ArrayLabels {
 public:
  explicit ArrayLabels(const std::vector<FileArray>& arrays);
  /// What names the `width` columns of an array: under a key as names, labels, channels or columns as many texts in its
  /// group, else the only such list elsewhere, that are no units; null where there is none. Of a vector called values,
  /// data or samples: the only text in its group that is called name, label, channel or title.
  [[nodiscard]] const FileArray* names_beside(const FileArray& array, std::size_t width) const&;
  void names_beside(const FileArray& array, std::size_t width) const&& = delete;
  /// What has their units: as many texts that are units or say that there is none ("mm", "N", "-"), likewise, under any
  /// key; of a vector the text whose key is its own and the word unit ("disp_unit", "units.disp", "disp.unit" beside
  /// "disp.values").
  [[nodiscard]] const FileArray* units_beside(const FileArray& array, std::size_t width) const&;
  void units_beside(const FileArray& array, std::size_t width) const&& = delete;

 private:
  std::vector<const FileArray*> lists_, texts_;                 // of several texts, of one
  std::map<std::vector<std::string>, const FileArray*> units_;  // by the words of what has the unit
};

/// "disp" for values, data or samples in a group of this name; empty for anything else.
[[nodiscard]] std::string name_of_values(const FileArray& array);

/// Whether a text in the place of a unit says that there is none: empty, "-", "none".
[[nodiscard]] bool is_no_unit(std::string_view text);

}  // namespace dsp
