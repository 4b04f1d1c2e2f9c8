#include "dsp/io/small_file.hpp"

#include <fmt/format.h>

#include "dsp/io/input_file.hpp"

namespace dsp {

std::string read_small_file(const std::filesystem::path& file, const SmallFile& as) {
  try {
    const InputFile input(file);
    if (input.size() > as.most_bytes)
      throw Fault(as.kind, as.fault,
                  fmt::format("{}: has {} bytes, want at most {}", input.name(), input.size(), as.most_bytes));
    std::string bytes = input.text(0, input.size());
    input.check_unchanged();
    return bytes;
  } catch (const Fault& fault) {
    throw Fault(as.kind, as.fault,
                as.wanted.empty() ? fault.what() : fmt::format("{}; want {}", fault.what(), as.wanted));
  }
}

}  // namespace dsp
