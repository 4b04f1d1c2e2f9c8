#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "dsp/filter/spectral.hpp"
#include "dsp/samples/hold_length.hpp"
#include "ident/bodies/bodies.hpp"
#include "ident/bodies/statement.hpp"
#include "ident/state_space/start.hpp"

// A recording of several bodies as their likelihood wants it.

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using std::size_t;

dsp::Fault question(const std::string& name, const std::string& recording, const std::string& what) {
  return {dsp::FaultKind::input, name, fmt::format("{}: {}", recording, what)};
}

bool is_term_name(const std::string& name) {
  return !name.empty() && std::isalpha(static_cast<unsigned char>(name.front())) != 0 &&
         std::all_of(name.begin(), name.end(),
                     [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; });
}

/// What acts from outside: by its role, of other channels by their unit.
std::string input_name(const dsp::Channel& channel) {
  const dsp::SignalInfo& role = dsp::info_of(channel.role);
  if (role.body == dsp::Body::base || channel.role == dsp::Role::f) return std::string(role.name);
  const bool is_force = channel.role == dsp::Role::other && (channel.unit == "N" || channel.unit == "N*m");
  return is_force && is_term_name(channel.name) ? channel.name : "";
}

std::vector<dsp::IndexRange> usable_of(const dsp::Recording& recording) {
  std::vector<unsigned char> bad(static_cast<size_t>(recording.samples.rows()), 0);
  for (const dsp::Interval& interval : recording.bad) {
    const auto from = static_cast<Index>(std::floor(interval.from_s * recording.sample_rate_hz)),
               to = static_cast<Index>(std::ceil(interval.to_s * recording.sample_rate_hz)) + 1;
    for (Index k = std::max<Index>(from, 0); k < std::min(to, recording.samples.rows()); ++k)
      bad[static_cast<size_t>(k)] = 1;
  }
  std::vector<dsp::IndexRange> usable;
  for (Index k = 0; k < std::ssize(bad); ++k) {
    if (bad[static_cast<size_t>(k)] != 0) continue;
    if (usable.empty() || usable.back().last != k) usable.push_back({k, k});
    ++usable.back().last;
  }
  return usable;
}

bool has(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// What roles and recorded base motion say of the frame; nothing where columns named x1 may be either.
std::optional<Frame> frame_of(const BodiesRecord& record) {
  const bool has_r = has(record.inputs, "r"), has_base = has_r || has(record.inputs, "dr") || has(record.inputs, "ddr");
  const auto absolute = [](const dsp::Channel& channel) {
    return dsp::info_of(channel.role).body == dsp::Body::payload;
  };
  const auto count = std::count_if(record.channels.begin(), record.channels.end(), absolute);
  if (!has_base) return Frame::ground;
  if (count > 0 && count < std::ssize(record.channels))
    throw question("bodies.frame", record.name,
                   "some displacements of bodies are absolute (y) and some relative to the base (x). Give all of them "
                   "one role in a [[channel]] each");
  if (count > 0 && !has_r)
    throw question("bodies.frame", record.name,
                   "displacements of bodies are absolute (y), but that of the base (r) is missing. Record it, or give "
                   "the bodies role = \"x\" if they are relative to the base");
  if (count > 0) return Frame::absolute;
  const bool is_assumed = std::any_of(record.channels.begin(), record.channels.end(),
                                      [](const dsp::Channel& channel) { return channel.role_is_assumed; });
  return has_r && is_assumed ? std::nullopt : std::optional(Frame::base);
}

/// Channels of bodies, the displacements of 1 to n first.
std::vector<Index> columns_of_bodies(const std::string& name, const std::vector<dsp::Channel>& channels,
                                     int num_bodies) {
  std::vector<Index> columns;
  const auto order = [&](Index j) { return dsp::info_of(channels[static_cast<size_t>(j)].role).order; };
  for (int body = 1; body <= num_bodies; ++body) {
    for (Index j = 0; j < std::ssize(channels); ++j)
      if (channels[static_cast<size_t>(j)].body == body && order(j) == 0) columns.push_back(j);
    if (std::ssize(columns) != body)
      throw question(
          "bodies.displacement", name,
          fmt::format("of bodies 1 to {} body {} has {}. Want one displacement of each: give a channel "
                      "role = \"x\" and body = {}",
                      num_bodies, body, std::ssize(columns) < body ? "none" : "more than one displacement", body));
  }
  for (Index j = 0; j < std::ssize(channels); ++j)
    if (channels[static_cast<size_t>(j)].body > 0 && order(j) > 0) columns.push_back(j);
  return columns;
}

/// The mean, where that is further from zero than a motion about it is wide: a laser's distance.
double zero_of(const VectorXd& values) {
  constexpr double far = 3.0;
  const double mean = values.mean(), std = std::sqrt((values.array() - mean).square().mean());
  return std::abs(mean) > far * std ? mean : 0.0;
}

/// At either end a derivative over the whole record is less sure.
void leave_out_ends(BodiesRecord& record) {
  constexpr double most_s = 1.0, of_record = 0.02;
  const Index n = record.samples.rows(),
              margin = static_cast<Index>(std::min(most_s * record.sample_rate_hz, of_record * static_cast<double>(n)));
  for (dsp::IndexRange& one : record.usable) one = {std::max(one.first, margin), std::min(one.last, n - margin)};
  std::erase_if(record.usable, [](const dsp::IndexRange& one) { return one.first >= one.last; });
}

/// Of one body, which has no numbers that a person would look for.
void require_one_displacement(const std::string& name, const std::vector<dsp::Channel>& channels) {
  std::vector<std::string> names;
  for (const dsp::Channel& channel : channels)
    if (channel.body == 1 && dsp::info_of(channel.role).order == 0) names.push_back(channel.name);
  if (names.empty())
    throw question(
        "bodies.displacement", name,
        "no displacement of the body, which an inner state is found from. Record one, or leave [library] inner "
        "out");
  if (names.size() > 1)
    throw question("bodies.displacement", name,
                   fmt::format("{} displacements of the body: {}. Want one: give role = \"other\" to the others in a "
                               "[[channel]] each",
                               names.size(), fmt::join(names, ", ")));
}

/// What makes two recordings ones of the same system.
void require_same(const BodiesRecord& first, const BodiesRecord& other) {
  const auto differ = [&](const std::string& what) {
    return question("bodies.recordings", other.name,
                    fmt::format("{} than in {}. Several recordings of one system have the same channels; run this one "
                                "alone",
                                what, first.name));
  };
  if (other.num_bodies != first.num_bodies) throw differ(fmt::format("{} bodies, which is other", other.num_bodies));
  if (other.inputs != first.inputs)
    throw differ(fmt::format("the inputs {}, which are others, or in another order",
                             other.inputs.empty() ? "none" : fmt::format("{}", fmt::join(other.inputs, ", "))));
  constexpr double same = 1e-6;  // of clocks that were read from columns of times
  if (!(std::abs(other.sample_rate_hz - first.sample_rate_hz) <= same * first.sample_rate_hz))
    throw question("bodies.recordings", other.name,
                   fmt::format("{:.9g} Hz, {} has {:.9g}. Recordings of one equation have one rate: if it is one, give "
                               "both the same `rate` in their sidecars; else run this one alone",
                               other.sample_rate_hz, first.name, first.sample_rate_hz));
  if (other.length != first.length)
    throw differ(fmt::format("displacements in '{}', which is another unit", other.length));
  const auto is_same = [](const dsp::Channel& a, const dsp::Channel& b) {
    return a.role == b.role && a.body == b.body && a.delay_s == b.delay_s && a.highpass_hz == b.highpass_hz &&
           a.sensitivity_uncertainty == b.sensitivity_uncertainty;
  };
  if (!std::equal(first.channels.begin(), first.channels.end(), other.channels.begin(), other.channels.end(),
                  is_same) ||
      first.frame != other.frame)
    throw differ("a channel with another role, body, delay, coupling or uncertainty of its sensitivity");
}

/// Subtracts one zero from parts of a signal from which others were, and says which.
double one_zero(Eigen::Ref<VectorXd> signal, const std::vector<BodiesPart>& parts, const VectorXd& zeros) {
  for (size_t i = 0; i < parts.size(); ++i)
    signal.segment(parts[i].rows.first, parts[i].rows.last - parts[i].rows.first).array() +=
        zeros(static_cast<Index>(i));
  const double zero = zero_of(signal);
  signal.array() -= zero;
  return zero;
}

/// Where motions far from zero do not overlap a sensor was moved in between.
void require_one_zero(const BodiesRecord& whole, Index channel) {
  std::vector<double> means, stds;
  for (const BodiesPart& part : whole.parts) {
    const auto x = whole.samples.col(channel).segment(part.rows.first, part.rows.last - part.rows.first);
    means.push_back(x.mean()), stds.push_back(std::sqrt((x.array() - means.back()).square().mean()));
    means.back() += part.zeros(channel);
  }
  for (size_t i = 1; i < means.size(); ++i)
    if (const bool is_far = whole.parts[i].zeros(channel) != 0.0 || whole.parts[0].zeros(channel) != 0.0;
        is_far && std::abs(means[i] - means[0]) > stds[i] + stds[0])
      throw question("bodies.recordings", whole.parts[i].name,
                     fmt::format("'{}' moves about {:.4g} {}, in {} about {:.4g}: recordings of one equation have one "
                                 "zero. If the sensor was moved in between, subtract the difference in the file; else "
                                 "run this one alone",
                                 whole.channels[static_cast<size_t>(channel)].name, means[i], whole.length,
                                 whole.parts[0].name, means[0]));
}

void take_one_zero(BodiesRecord& whole) {
  VectorXd zeros(std::ssize(whole.parts));
  for (Index j = 0; j < whole.num_bodies && !whole.imposed; ++j) {
    require_one_zero(whole, j);
    for (Index i = 0; i < zeros.size(); ++i) zeros(i) = whole.parts[static_cast<size_t>(i)].zeros(j);
    const double zero = one_zero(whole.samples.col(j), whole.parts, zeros);
    for (BodiesPart& part : whole.parts) part.zeros(j) = zero;
  }
  const auto of_r = std::find(whole.inputs.begin(), whole.inputs.end(), whole.imposed ? "x" : "r");
  if (of_r == whole.inputs.end()) return;
  for (Index i = 0; i < zeros.size(); ++i) zeros(i) = whole.parts[static_cast<size_t>(i)].zero_of_r;
  const double zero = one_zero(whole.input_samples.col(of_r - whole.inputs.begin()), whole.parts, zeros);
  for (BodiesPart& part : whole.parts) part.zero_of_r = zero;
}

/// One part of a record as a record.
BodiesRecord alone(const BodiesRecord& whole, const BodiesPart& part) {
  BodiesRecord one = whole;
  const Index n = part.rows.last - part.rows.first;
  one.samples = whole.samples.middleRows(part.rows.first, n);
  one.input_samples = whole.input_samples.middleRows(part.rows.first, n);
  one.name = part.name;
  one.parts = {{part.name, {0, n}, part.zeros, part.zero_of_r}};
  one.usable.clear();
  for (const dsp::IndexRange& usable : whole.usable)
    if (part.holds(usable)) one.usable.push_back({usable.first - part.rows.first, usable.last - part.rows.first});
  return one;
}

std::vector<dsp::Channel> with_one_body(std::vector<dsp::Channel> channels) {
  for (dsp::Channel& channel : channels) {
    const dsp::Body whose = dsp::info_of(channel.role).body;
    if (channel.body == 0 && (whose == dsp::Body::relative || whose == dsp::Body::payload)) channel.body = 1;
  }
  return channels;
}

/// A staircase follows no equation of motion.
void refuse_held(const dsp::Recording& recording, const std::vector<Index>& columns) {
  for (const Index j : columns) {
    dsp::HoldLength hold;
    for (const double value : recording.samples.col(j)) hold.push(value);
    if (const int samples = hold.samples(); samples > 1)
      throw question("bodies.held", recording.name,
                     fmt::format("channel '{}' holds each of its values for {} samples, as of a sensor slower than the "
                                 "clock. Keep one row of {} in the file, which then has {:.6g} Hz",
                                 recording.channels[static_cast<size_t>(j)].name, samples, samples,
                                 recording.sample_rate_hz / samples));
  }
}

}  // namespace

VectorXd derived(const VectorXd& signal, double rate_hz, int order, double to_hz) {
  constexpr double flat = 0.8;
  return dsp::ExtendedSpectrum(signal, rate_hz).derivative(order, {flat * to_hz, to_hz});
}

BodiesRecord bodies_record(const dsp::Recording& recording, bool one_body) {
  const std::vector<dsp::Channel> channels = one_body ? with_one_body(recording.channels) : recording.channels;
  BodiesRecord record{.name = recording.name, .sample_rate_hz = recording.sample_rate_hz};
  for (const dsp::Channel& channel : channels) record.num_bodies = std::max(record.num_bodies, channel.body);
  if (one_body && record.num_bodies == 1) require_one_displacement(recording.name, channels);
  const std::vector<Index> columns = columns_of_bodies(recording.name, channels, record.num_bodies);
  refuse_held(recording, columns);
  std::vector<Index> of_inputs;
  for (Index j = 0; j < std::ssize(channels); ++j) {
    const dsp::Channel& channel = channels[static_cast<size_t>(j)];
    if (channel.body > 0) continue;
    const dsp::Body whose = dsp::info_of(channel.role).body;
    if (whose == dsp::Body::relative || whose == dsp::Body::payload)
      throw question("bodies.which", recording.name,
                     fmt::format("of which body is channel '{}' ({})? Others have a number. Add body = ... from 1 to "
                                 "{} to its [[channel]], or role = \"other\"",
                                 channel.name, dsp::to_string(channel.role), record.num_bodies));
    if (const std::string name = input_name(channel); !name.empty()) {
      if (channel.delay_s != 0.0)
        throw question("bodies.delay", recording.name,
                       fmt::format("channel '{}' lags by a stated delay, which is corrected for one body only. Correct "
                                   "the recording and leave `delay` out",
                                   channel.name));
      if (one_body && (name == "x" || name == "v" || name == "z" || name == "t"))
        throw question(
            "bodies.input", recording.name,
            fmt::format("the input '{0}' is called as a state of the equations is. Rename it: name = \"{0}_1\" "
                        "in its [[channel]], or in the file",
                        name));
      record.inputs.push_back(name), of_inputs.push_back(j);
    } else {
      record.unused.push_back(channel.name);
    }
  }
  record.samples = recording.samples(Eigen::indexing::all, columns);
  record.input_samples = recording.samples(Eigen::indexing::all, of_inputs);
  VectorXd zeros = VectorXd::Zero(std::ssize(columns));
  for (const Index j : columns) record.channels.push_back(channels[static_cast<size_t>(j)]);
  if (!record.channels.empty()) record.length = record.channels.front().unit;
  for (Index j = 0; j < record.num_bodies; ++j) {
    if (record.channels[static_cast<size_t>(j)].unit != record.length)
      throw question("bodies.unit", recording.name,
                     fmt::format("displacement of body 1 is in '{}', of body {} in '{}'. Want one unit for all",
                                 record.length, j + 1, record.channels[static_cast<size_t>(j)].unit));
    zeros(j) = zero_of(record.samples.col(j));
    record.samples.col(j).array() -= zeros(j);
  }
  record.parts = {{recording.name, {0, record.samples.rows()}, std::move(zeros)}};
  for (Index j = 0; j < record.input_samples.cols(); ++j)
    if (record.inputs[static_cast<size_t>(j)] == "r") {
      record.parts.front().zero_of_r = zero_of(record.input_samples.col(j));
      record.input_samples.col(j).array() -= record.parts.front().zero_of_r;
    }
  record.usable = usable_of(recording);
  record.frame = frame_of(record);
  return record;
}

BodiesRecord imposed_record(const dsp::Recording& recording) {
  BodiesRecord record{.name = recording.name, .sample_rate_hz = recording.sample_rate_hz, .imposed = true};
  std::vector<unsigned char> taken(recording.channels.size(), 0);
  const auto find = [&](dsp::Role role) {
    const Index at = recording.find(role);
    if (at >= 0) taken[static_cast<size_t>(at)] = 1;
    return at;
  };
  const Index x = find(dsp::Role::x), y = x < 0 ? find(dsp::Role::y) : -1, r = y >= 0 ? find(dsp::Role::r) : -1;
  if (x < 0 && y < 0)
    throw question("bodies.imposed", recording.name,
                   "no displacement, which a force with a memory is found from. Give its channel role = \"x\" in a "
                   "[[channel]], or leave [library] inner out");
  const Index v = r >= 0 ? -1 : find(y < 0 ? dsp::Role::v : dsp::Role::dy), f = find(dsp::Role::f);
  std::vector<Index> columns{x < 0 ? y : x};
  if (v >= 0) columns.push_back(v);
  for (const Index at : {r, f})
    if (at >= 0) columns.push_back(at);
  refuse_held(recording, columns);
  for (const Index at : columns)
    if (const dsp::Channel& channel = recording.channels[static_cast<size_t>(at)];
        channel.delay_s != 0.0 || !channel.highpass_hz.empty())
      throw question("bodies.delay", recording.name,
                     fmt::format("channel '{}' has a stated {}, which is not corrected for the force on an imposed "
                                 "motion. Correct the recording and leave `{}` out",
                                 channel.name, channel.delay_s != 0.0 ? "delay" : "highpass",
                                 channel.delay_s != 0.0 ? "delay" : "highpass"));
  record.length = recording.channels[static_cast<size_t>(columns.front())].unit;
  VectorXd displacement = recording.samples.col(columns.front());
  if (r >= 0) displacement -= recording.samples.col(r);
  const double zero = zero_of(displacement);
  record.inputs = {"x"};
  record.input_samples = displacement.array() - zero;
  if (v >= 0) {
    record.inputs.emplace_back("v");
    record.input_samples.conservativeResize(Eigen::NoChange, 2);
    record.input_samples.col(1) = recording.samples.col(v);
  }
  record.samples.resize(recording.samples.rows(), f < 0 ? 0 : 1);
  if (f >= 0) {
    record.num_bodies = 1;
    record.channels = {recording.channels[static_cast<size_t>(f)]};
    record.samples.col(0) = recording.samples.col(f);
  }
  for (size_t j = 0; j < taken.size(); ++j)
    if (taken[j] == 0) record.unused.push_back(recording.channels[j].name);
  record.parts = {{recording.name, {0, recording.samples.rows()}, VectorXd::Zero(record.samples.cols()), zero}};
  record.usable = usable_of(recording);
  record.frame = Frame::ground;
  return record;
}

BodiesRecord joined(const std::vector<BodiesRecord>& records) {
  const BodiesRecord& first = records.front();
  BodiesRecord whole = first;
  Index rows = 0;
  for (const BodiesRecord& one : records) {
    require_same(first, one);
    rows += one.samples.rows();
  }
  whole.samples.resize(rows, first.samples.cols()), whole.input_samples.resize(rows, first.input_samples.cols());
  whole.parts.clear(), whole.usable.clear();
  if (records.size() > 1) whole.name = fmt::format("{} and {} more", first.name, records.size() - 1);
  Index begin = 0;
  for (const BodiesRecord& one : records) {
    const Index n = one.samples.rows();
    whole.samples.middleRows(begin, n) = one.samples, whole.input_samples.middleRows(begin, n) = one.input_samples;
    for (BodiesPart part : one.parts) {
      part.rows = {part.rows.first + begin, part.rows.last + begin};
      whole.parts.push_back(std::move(part));
    }
    for (const dsp::IndexRange& usable : one.usable)
      whole.usable.push_back({usable.first + begin, usable.last + begin});
    for (size_t j = 0; j < whole.input_noise_std.size(); ++j)
      whole.input_noise_std[j] = std::max(whole.input_noise_std[j], one.input_noise_std[j]);
    begin += n;
  }
  if (records.size() > 1) take_one_zero(whole);
  return whole;
}

BodiesRecord in_frame(BodiesRecord record, Frame frame) {
  if (record.parts.size() > 1) {
    std::vector<BodiesRecord> framed;
    for (const BodiesPart& part : record.parts) framed.push_back(in_frame(alone(record, part), frame));
    return joined(framed);
  }
  record.frame = frame;
  std::vector<std::string> inputs;
  std::vector<VectorXd> signals;
  std::vector<double> noise;
  std::vector<double> ends_hz;
  for (size_t j = 0; j < record.inputs.size(); ++j) {
    state_space::Input input =
        state_space::without_noise(record.input_samples.col(static_cast<Index>(j)), record.sample_rate_hz);
    inputs.push_back(record.inputs[j]), signals.push_back(std::move(input.signal));
    noise.push_back(input.noise_std), ends_hz.push_back(input.to_hz);
  }
  const auto derive = [&](const char* wanted, std::initializer_list<std::pair<const char*, int>> sources) {
    if (has(inputs, wanted)) return;
    for (const auto& [source, order] : sources) {
      const auto found = std::find(inputs.begin(), inputs.end(), source) - inputs.begin();
      if (found == std::ssize(inputs)) continue;
      const auto at = static_cast<size_t>(found);
      signals.push_back(derived(signals[at], record.sample_rate_hz, order, ends_hz[at]));
      inputs.emplace_back(wanted), noise.push_back(0.0), ends_hz.push_back(ends_hz[at]);
      leave_out_ends(record);
      return;
    }
  };
  if (record.imposed) derive("v", {{"x", 1}});
  if (frame == Frame::absolute) derive("dr", {{"r", 1}});
  if (frame == Frame::base) derive("ddr", {{"dr", 1}, {"r", 2}});
  record.inputs.clear(), record.input_noise_std.clear();
  record.input_samples.resize(record.samples.rows(), 0);
  for (size_t j = 0; j < inputs.size(); ++j) {
    const bool is_of_base = inputs[j] == "r" || inputs[j] == "dr";
    if (frame == Frame::base ? is_of_base : inputs[j] == "ddr") continue;
    record.inputs.push_back(inputs[j]), record.input_noise_std.push_back(noise[j]);
    record.input_samples.conservativeResize(Eigen::NoChange, record.input_samples.cols() + 1);
    record.input_samples.rightCols(1) = signals[j];
  }
  return record;
}

}  // namespace ident
