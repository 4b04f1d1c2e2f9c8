#pragma once
#include <filesystem>
#include <stop_token>
#include <string>
#include <string_view>

namespace apps {

/// Lower-case hexadecimal SHA-256 of the bytes.
[[nodiscard]] std::string sha256(std::string_view bytes);

/// The same of a file, read in blocks; empty where it was asked to stop before the end. Throws dsp::Fault (input) as
/// dsp::InputFile.
[[nodiscard]] std::string sha256_file(const std::filesystem::path& path, const std::stop_token& stop = {});

}  // namespace apps
