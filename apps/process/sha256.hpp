#pragma once
#include <filesystem>
#include <string>
#include <string_view>

namespace apps {

/// Lower-case hexadecimal SHA-256 of the bytes.
[[nodiscard]] std::string sha256(std::string_view bytes);

/// The same of a file, read in blocks. Throws dsp::Fault (input) as dsp::InputFile.
[[nodiscard]] std::string sha256_file(const std::filesystem::path& path);

}  // namespace apps
