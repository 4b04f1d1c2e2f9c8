#include "dsp/signal_table.hpp"

#include <fmt/format.h>

#include <cctype>

#include "dsp/io/sample_source.hpp"

namespace dsp {
namespace {

using Eigen::Index;

// The column's name as one that an expression can hold, short enough to read.
std::string identifier(const std::string& column, std::size_t index) {
  constexpr std::size_t most_characters = 60;
  std::string name;
  for (const char c : column.substr(0, most_characters)) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      name += c;
    else if (!name.empty() && name.back() != '_')
      name += '_';
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  if (name.empty()) return fmt::format("column_{}", index + 1);
  return std::isdigit(static_cast<unsigned char>(name.front())) != 0 ? "_" + name : name;
}

}  // namespace

SignalTable read_signal_table(const std::filesystem::path& file) {
  const auto source = open_source(file, {.with_clock = false});  // rows as they are: a fit asks for no time
  const SourceInfo& info = source->info();
  SignalTable result;
  Motion& table = result.signals;
  table.sample_rate_hz = 1.0;
  for (std::size_t i = 0; i < info.columns.size(); ++i) {
    const std::string name = identifier(info.columns[i], i);
    if (table.find(name) != nullptr)
      throw Fault(FaultKind::input, "channel.name",
                  fmt::format("{}: two columns are called '{}'. Rename one.", file.string(), name));
    if (name != info.columns[i]) result.renamed.emplace_back(info.columns[i], name);
    table.signals.push_back({name, info.units[i], Eigen::VectorXd(info.num_frames)});
  }
  FrameBlock block;
  Index done = 0;
  constexpr Index rows_at_once = 4096;
  while (const Index count = source->read(block, rows_at_once)) {
    for (Index j = 0; j < block.cols(); ++j)
      table.signals[static_cast<std::size_t>(j)].values.segment(done, count) = block.col(j).head(count);
    done += count;
  }
  return result;
}

}  // namespace dsp
