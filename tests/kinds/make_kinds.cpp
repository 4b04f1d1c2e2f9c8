// make_kinds SEED FOLDER [COUNT]: labelled records, half of them of laws that the default library does not hold.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "kinds/record.hpp"

int main(int count, char** words) {
  if (count < 3) {
    std::fputs("make_kinds SEED FOLDER [COUNT]\n", stderr);
    return 2;
  }
  try {
    const std::filesystem::path folder = words[2];
    std::filesystem::create_directories(folder);
    const std::uint64_t records = count > 3 ? std::stoull(words[3]) : 300;
    for (std::uint64_t index = 0; index < records; ++index)
      kinds::write_record(kinds::draw_record(std::stoull(words[1]), index), folder);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
