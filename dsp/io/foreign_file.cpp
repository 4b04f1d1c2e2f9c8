#include "dsp/io/foreign_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

namespace dsp {
namespace {

struct Foreign {
  std::string_view magic, name;
  std::string_view what, command;  // its {} is the file
};

constexpr std::string_view from_mdf =
    "with pip install asammdf: python3 -c \"from asammdf import MDF; MDF('{}').to_dataframe().to_csv('{}.csv')\"";
constexpr std::string_view from_excel =
    "with pip install pandas {}: python3 -c \"import pandas; pandas.read_excel('{{}}').to_csv('{{}}.csv', "
    "index=False)\"";
constexpr std::string_view lossless = "Want WAV, RF64, W64, CAF, FLAC or AIFF";

constexpr std::array foreign{
    Foreign{"MDF     ", "container.unsupported", "MDF is not read. Make a table of it, ", from_mdf},
    Foreign{"UnFinMF ", "container.unsupported", "MDF is not read. Make a table of it, ", from_mdf},
    Foreign{"PAR1", "container.unsupported", "Parquet is not read. Make a table of it, ",
            "with pip install pandas pyarrow: python3 -c \"import pandas; "
            "pandas.read_parquet('{}').reset_index().to_csv('{}.csv', index=False)\""},
    Foreign{"OggS", "container.lossy", "Ogg holds lossy codecs. ", lossless},
    Foreign{"ID3", "container.lossy", "MPEG audio is lossy. ", lossless},
    Foreign{"\xff\xfb", "container.lossy", "MPEG audio is lossy. ", lossless},
};
constexpr std::string_view old_office = "\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", gzip = "\x1f\x8b";

std::string with_path(std::string_view command, const InputFile& file) {
  std::string text(command);
  const std::string path = path_to_paste(file);
  for (auto at = text.find("{}"); at != text.npos; at = text.find("{}", at + path.size())) text.replace(at, 2, path);
  return text;
}

Fault not_read(const InputFile& file, std::string_view what, std::string_view command) {
  return {FaultKind::input, "container.unsupported",
          fmt::format("{}: {}{}", file.name(), what, with_path(command, file))};
}

Fault not_unpacked(const InputFile& file) {
  const bool is_named_so = file.path().extension() == ".gz";  // gunzip wants that
  return not_read(
      file, "a gzip file is not read. Unpack it: ", is_named_so ? "gunzip -k '{}'" : "gunzip < '{}' > '{}.unpacked'");
}

}  // namespace

std::string path_to_paste(const InputFile& file) {
  const std::string path = file.path().string();
  const bool is_plain = std::all_of(path.begin(), path.end(), [](char c) {
    constexpr std::string_view marks = "/._-+,=@%: ";
    const auto byte = static_cast<unsigned char>(c);
    return std::isalnum(byte) != 0 || byte >= 0x80 || marks.find(c) != marks.npos;
  });
  return is_plain && !path.starts_with('-') ? path : "FILE";
}

void refuse_foreign(const InputFile& file, std::string_view head) {
  if (head.starts_with(gzip)) throw not_unpacked(file);
  if (head.starts_with(old_office))
    throw not_read(file, "an old spreadsheet is not read. Make a table of it, ", fmt::format(from_excel, "xlrd"));
  for (const Foreign& other : foreign)
    if (head.starts_with(other.magic))
      throw Fault(FaultKind::input, std::string(other.name),
                  fmt::format("{}: {}{}", file.name(), other.what, with_path(other.command, file)));
}

Fault foreign_archive(const InputFile& file, ForeignArchive kind) {
  if (kind == ForeignArchive::zip)
    return not_read(file,
                    "a ZIP archive without arrays of NumPy. Unpack it, and name the recording in it: ", "unzip '{}'");
  return not_read(file, "a spreadsheet is not read. Make a table of it, ",
                  fmt::format(from_excel, kind == ForeignArchive::spreadsheet ? "openpyxl" : "odfpy"));
}

}  // namespace dsp
