#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "dsp/values/fault.hpp"

namespace apps {

/// "path: text." as a fault of kind output.
[[nodiscard]] dsp::Fault output_fault(std::string name, const std::filesystem::path& path, std::string_view text);

/// What is where Ardent would write, remove or replace: "output.symlink", "output.exists", "output.foreign".
[[nodiscard]] dsp::Fault link_at(const std::filesystem::path& path);
[[nodiscard]] dsp::Fault taken_at(const std::filesystem::path& path);
[[nodiscard]] dsp::Fault foreign_at(const std::filesystem::path& path);

/// What the system said (errno) when `path` could not be written, with what to try: "output.write".
[[nodiscard]] dsp::Fault cannot_write(const std::filesystem::path& path, int error);

}  // namespace apps
