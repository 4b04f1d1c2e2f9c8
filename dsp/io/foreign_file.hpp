#pragma once
#include <string>
#include <string_view>

#include "dsp/io/input_file.hpp"
#include "dsp/values/fault.hpp"

namespace dsp {

/// Throws Fault (input) where a file is known by its first bytes and not read: container.unsupported (MDF, Parquet, old
/// spreadsheets, gzip), with a command that makes of it what is, or container.lossy.
void refuse_foreign(const InputFile& file, std::string_view head);

enum class ForeignArchive { spreadsheet, open_document, zip };
/// The same of a ZIP archive that is one of these.
[[nodiscard]] Fault foreign_archive(const InputFile& file, ForeignArchive kind);

/// The path of a file as shells and Python take it between quotation marks; FILE where it would not do.
[[nodiscard]] std::string path_to_paste(const InputFile& file);

}  // namespace dsp
