#include "apps/config/segments_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <stdexcept>

#include "apps/process/printable.hpp"
#include "apps/text/json_number.hpp"
#include "apps/text/json_parts.hpp"
#include "dsp/io/small_file.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Index;

/// Both ends of a record, where they are spoilt.
std::vector<dsp::Interval> edges_of(const dsp::Motion& signals) {
  const double end = static_cast<double>(signals.num_samples()) / signals.sample_rate_hz;
  const double edge = static_cast<double>(signals.edge_samples) / signals.sample_rate_hz;
  if (edge == 0.0) return {};
  const char* why = "filters and derivatives depend on samples predicted beyond the record";
  return {{0.0, edge, why}, {end - edge, end, why}};
}

/// What is left of an interval outside of the excluded ones, in order of time.
std::vector<LabelledInterval> outside(const LabelledInterval& interval, std::vector<dsp::Interval> excluded) {
  std::sort(excluded.begin(), excluded.end(), [](const auto& a, const auto& b) { return a.from_s < b.from_s; });
  std::vector<LabelledInterval> left;
  LabelledInterval rest = interval;
  const auto keep_until = [&](double end_s) {
    LabelledInterval part = rest;
    part.to_s = std::min(end_s, rest.to_s);
    if (part.from_s > interval.from_s) part.from_std_s = std::nan("");
    if (part.to_s < interval.to_s) part.to_std_s = std::nan("");
    if (part.from_s < part.to_s) left.push_back(part);
  };
  for (const dsp::Interval& gap : excluded) {
    keep_until(gap.from_s);
    rest.from_s = std::max(rest.from_s, gap.to_s);
  }
  keep_until(interval.to_s);
  return left;
}

std::vector<LabelledInterval> intervals_of(const Input& input) {
  const dsp::Motion &signals = input.prepared.signals, &intermediate = input.prepared.intermediate;
  std::vector<dsp::Interval> excluded = input.prepared.excluded;
  for (const dsp::Interval& edge : edges_of(signals)) excluded.push_back(edge);
  std::vector<LabelledInterval> intervals;
  for (const dsp::Interval& interval : excluded)
    intervals.push_back({dsp::Regime::excluded, interval.from_s, interval.to_s, interval.why, {}});
  for (const dsp::Segment& segment : input.segmentation.segments) {
    if (segment.regime == dsp::Regime::excluded) continue;
    const LabelledInterval whole{segment.regime,
                                 static_cast<double>(segment.first) / intermediate.sample_rate_hz,
                                 static_cast<double>(segment.last) / intermediate.sample_rate_hz,
                                 segment.reason,
                                 {},
                                 segment.probability,
                                 segment.first_std_s,
                                 segment.last_std_s};
    for (LabelledInterval& part : outside(whole, excluded)) intervals.push_back(std::move(part));
  }
  std::stable_sort(intervals.begin(), intervals.end(),
                   [](const auto& a, const auto& b) { return a.from_s < b.from_s; });
  return intervals;
}

dsp::Fault segments_fault(std::string name, const fs::path& file, std::size_t number, const std::string& what) {
  const std::string place = number == 0 ? file.string() : fmt::format("{}: interval {}", file.string(), number);
  return {dsp::FaultKind::usage, std::move(name), fmt::format("{}: {}.", place, what)};
}

constexpr std::array<std::string_view, 8> keys{"label",     "from_s",      "to_s",       "reason",
                                               "recording", "probability", "from_std_s", "to_std_s"};

LabelledInterval read_interval(const Json& row, const fs::path& file, std::size_t number) {
  const auto wrong = [&](std::string name, const std::string& what) {
    return segments_fault(std::move(name), file, number, what);
  };
  if (!row.is_object()) throw wrong("segments.syntax", "want {\"label\": ..., \"from_s\": ..., \"to_s\": ...}");
  for (const auto& [key, value] : row.items())
    if (std::find(keys.begin(), keys.end(), key) == keys.end())
      throw wrong("segments.syntax",
                  fmt::format("unknown key '{}', want one of {}", printable(key, 80), fmt::join(keys, ", ")));
  const auto text = [&](const char* key) {
    if (!row.contains(key)) return std::string();
    if (!row[key].is_string()) throw wrong("segments.syntax", fmt::format("{} is no text in quotes", key));
    return row[key].get<std::string>();
  };
  const auto seconds = [&](const char* key) {
    if (!row.contains(key) || !row[key].is_number()) throw wrong("segments.time", fmt::format("{} is no number", key));
    return row[key].get<double>();
  };
  const auto estimate = [&](const char* key) {
    if (!row.contains(key) || row[key].is_null()) return std::nan("");
    if (!row[key].is_number()) throw wrong("segments.syntax", fmt::format("{} is neither a number nor null", key));
    return row[key].get<double>();
  };
  LabelledInterval interval{dsp::Regime::excluded,  seconds("from_s"),   seconds("to_s"),
                            text("reason"),         text("recording"),   estimate("probability"),
                            estimate("from_std_s"), estimate("to_std_s")};
  try {
    interval.label = dsp::regime_from_string(text("label"));
  } catch (const std::invalid_argument&) {
    std::vector<std::string_view> names;
    for (const dsp::RegimeInfo& regime : dsp::regime_table()) names.push_back(regime.name);
    throw wrong("segments.label",
                fmt::format("label '{}', want {}", printable(text("label"), 80), fmt::join(names, ", ")));
  }
  if (!(interval.from_s >= 0.0 && interval.from_s < interval.to_s))
    throw wrong("segments.time",
                fmt::format("from_s {:g} and to_s {:g}, want 0 <= from_s < to_s", interval.from_s, interval.to_s));
  return interval;
}

bool known(const dsp::Interval& interval, const std::vector<dsp::Interval>& excluded) {
  constexpr double rounding_s = 1e-6;
  return std::any_of(excluded.begin(), excluded.end(), [&](const dsp::Interval& other) {
    return other.from_s <= interval.from_s + rounding_s && other.to_s >= interval.to_s - rounding_s;
  });
}

void exclude(dsp::Prepared& prepared, const dsp::Interval& interval) {
  dsp::mark(prepared.intermediate, interval);
  dsp::mark(prepared.signals, interval);
  prepared.excluded.push_back(interval);
}

/// Samples [first, last) of an interval: a time on a sample up to rounding is that sample.
dsp::Segment samples_of(const LabelledInterval& interval, const dsp::Motion& intermediate) {
  const auto sample = [&](double t_s) {
    const double position = std::ceil(t_s * intermediate.sample_rate_hz - 1e-6);
    return static_cast<Index>(std::min(position, static_cast<double>(intermediate.num_samples())));
  };
  return {interval.label,       sample(interval.from_s), sample(interval.to_s), interval.reason,
          interval.probability, interval.from_std_s,     interval.to_std_s};
}

/// What each sample belongs to, as an index into the segments; -1: none of them. Excluded wins, then the later one.
std::vector<int> owners(const std::vector<dsp::Segment>& segments, Index num_samples) {
  std::vector<int> owner(static_cast<std::size_t>(num_samples), -1);
  std::vector<std::size_t> free(owner.size() + 1);  // a sample not before this one that may have no owner yet
  std::iota(free.begin(), free.end(), std::size_t{0});
  const auto next_free = [&](std::size_t sample) {
    while (free[sample] != sample) sample = free[sample] = free[free[sample]];
    return sample;
  };
  for (const bool excluded : {true, false})  // those that win first: no sample is visited for the others
    for (std::size_t i = segments.size(); i-- > 0;) {
      if ((segments[i].regime == dsp::Regime::excluded) != excluded) continue;
      const auto end = static_cast<std::size_t>(segments[i].last);
      for (auto n = next_free(static_cast<std::size_t>(segments[i].first)); n < end; n = next_free(n))
        owner[n] = static_cast<int>(i), free[n] = n + 1;
    }
  return owner;
}

/// What begins at `first` of an interval that was asked for.
dsp::Segment piece_of(const dsp::Segment& asked, dsp::Regime label, Index first) {
  dsp::Segment piece = asked;
  piece.regime = label, piece.first = piece.last = first;
  if (first != asked.first) piece.first_std_s = std::nan("");
  return piece;
}

}  // namespace

std::string segments_json(const std::vector<Input>& inputs) {
  std::string text;
  for (const Input& input : inputs)
    for (const LabelledInterval& interval : intervals_of(input)) {
      Json row{{"label", to_string(interval.label)},
               {"from_s", interval.from_s},
               {"to_s", interval.to_s},
               {"reason", printable(interval.reason)},
               {"probability", number_or_null(interval.probability)},
               {"from_std_s", number_or_null(interval.from_std_s)},
               {"to_std_s", number_or_null(interval.to_std_s)}};
      if (inputs.size() > 1) row["recording"] = printable(input.prepared.name);
      text += (text.empty() ? "  " : ",\n  ") + row.dump(-1, ' ', false, Json::error_handler_t::replace);
    }
  return text.empty() ? "[]\n" : "[\n" + text + "\n]\n";
}

std::vector<LabelledInterval> read_segments(const fs::path& file) {
  const std::string bytes = dsp::read_small_file(file, {.kind = dsp::FaultKind::usage, .fault = "segments.file"});
  Json document;
  try {
    document = parsed_json(bytes);
  } catch (const Json::parse_error& error) {
    const auto line =
        1 + std::count(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(std::min(error.byte, bytes.size())),
                       '\n');
    throw segments_fault("segments.syntax", file, 0,
                         fmt::format("no JSON at line {}: a comma or a bracket is missing "
                                     "or too many",
                                     line));
  } catch (const Json::out_of_range&) {
    throw segments_fault("segments.syntax", file, 0, "a number is beyond what a double holds");
  } catch (const std::invalid_argument& error) {
    throw segments_fault("segments.syntax", file, 0, error.what());
  }
  if (!document.is_array() || document.empty())
    throw segments_fault("segments.syntax", file, 0, "want a list of intervals in [ ]");
  std::vector<LabelledInterval> intervals;
  for (std::size_t i = 0; i < document.size(); ++i) intervals.push_back(read_interval(document[i], file, i + 1));
  return intervals;
}

dsp::Segmentation apply_segments(const std::vector<LabelledInterval>& intervals, const fs::path& file,
                                 dsp::Prepared& prepared) {
  const std::vector<dsp::Interval> edges = edges_of(prepared.signals);
  std::vector<dsp::Segment> asked;
  for (const LabelledInterval& interval : intervals) {
    const bool meant = interval.recording.empty() || interval.recording == printable(prepared.name);
    const bool is_edge = interval.label == dsp::Regime::excluded &&
                         known({interval.from_s, interval.to_s, {}}, edges);  // set aside anyway
    if (meant && !is_edge) asked.push_back(samples_of(interval, prepared.intermediate));
  }
  if (asked.empty()) {
    std::set<std::string> given;
    for (const LabelledInterval& interval : intervals) given.insert(interval.recording);
    throw segments_fault("segments.recording", file, 0,
                         fmt::format("no interval is given for {}; there are those of {}", printable(prepared.name),
                                     printable(fmt::format("{}", fmt::join(given, ", ")), 400)));
  }
  asked.push_back({dsp::Regime::excluded, 0, 0, fmt::format("no interval of {} covers it", file.filename().string())});
  const auto nowhere = static_cast<int>(asked.size()) - 1;
  std::vector<int> owner = owners(asked, prepared.intermediate.num_samples());
  std::replace(owner.begin(), owner.end(), -1, nowhere);

  dsp::Segmentation result;
  result.remarks = {fmt::format("regimes as in {}", file.filename().string())};
  const std::vector<unsigned char> ruled_out = prepared.intermediate.excluded;
  const auto label = [&](std::size_t i) {
    return ruled_out[i] != 0 ? dsp::Regime::excluded : asked[static_cast<std::size_t>(owner[i])].regime;
  };
  for (std::size_t i = 0; i < owner.size(); ++i) {
    const auto index = static_cast<Index>(i);
    if (i == 0 || owner[i] != owner[i - 1] || label(i) != label(i - 1))
      result.segments.push_back(piece_of(asked[static_cast<std::size_t>(owner[i])], label(i), index));
    result.segments.back().last = index + 1;
  }
  for (dsp::Segment& segment : result.segments) {
    const auto at = static_cast<std::size_t>(segment.last - 1);
    if (segment.last != asked[static_cast<std::size_t>(owner[at])].last) segment.last_std_s = std::nan("");
  }
  std::vector<dsp::Interval> ruled_out_s = edges;
  ruled_out_s.insert(ruled_out_s.end(), prepared.excluded.begin(), prepared.excluded.end());
  for (const dsp::Segment& segment : result.segments) {
    const double rate_hz = prepared.intermediate.sample_rate_hz;
    const dsp::Interval interval{static_cast<double>(segment.first) / rate_hz,
                                 static_cast<double>(segment.last - 1) / rate_hz, segment.reason};
    if (segment.regime == dsp::Regime::excluded && !known(interval, ruled_out_s)) exclude(prepared, interval);
  }
  return result;
}

}  // namespace apps
