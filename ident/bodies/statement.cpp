#include "ident/bodies/statement.hpp"

#include <algorithm>
#include <utility>

#include "dsp/values/constants.hpp"
#include "ident/ranges/pieces.hpp"
#include "ident/state_space/start.hpp"
#include "ident/state_space/thin.hpp"

namespace ident {
namespace {

using Eigen::Index;
using std::size_t;

constexpr Index most_samples = 10'000;  // of all pieces together, as for one body

std::vector<Piece> pieces_in(const BodiesRecord& record, const std::vector<dsp::IndexRange>& over) {
  std::vector<Piece> pieces;
  for (size_t i = 0; i < over.size(); ++i)
    for (const dsp::IndexRange& one : record.usable) {
      const Piece piece{i, std::max(one.first, over[i].first), std::min(one.last, over[i].last)};
      if (piece.size() >= least_samples) pieces.push_back(piece);
    }
  return pieces;
}

state_space::Channel channel_of(const dsp::Channel& recorded, bool is_measure, const BodiesLayout& layout) {
  if (layout.imposed) return {.name = recorded.name, .state = 0, .rate = true};
  const int order = dsp::info_of(recorded.role).order;
  state_space::Channel channel{.name = recorded.name,
                               .state = order == 0 ? layout.shown_state(recorded.body) : 2 * recorded.body - 1,
                               .rate = order == 2};
  channel.lag_s = {recorded.delay_s, 0.0};
  if (order > 0) channel.offset = {0.0, state_space::unknown};
  if (!is_measure) channel.gain = {1.0, recorded.sensitivity_uncertainty};
  if (!recorded.highpass_hz.empty()) {
    constexpr double of_corner = 0.05;  // a maker's usual
    const double corner = dsp::two_pi * recorded.highpass_hz.front();
    channel.corner_rad_s = {corner, of_corner * corner};
  }
  return channel;
}

void take_pieces(state_space::Problem& problem, const BodiesRecord& record, const std::vector<Piece>& pieces) {
  problem.records.clear();
  for (const Piece& piece : pieces) {
    Index since = piece.first;
    for (const BodiesPart& part : record.parts)
      if (part.rows.first <= piece.first) since = piece.first - part.rows.first;
    problem.records.push_back({.channels = record.samples.middleRows(piece.first, piece.size()),
                               .inputs = record.input_samples.middleRows(piece.first, piece.size()),
                               .begin_s = static_cast<double>(since) / record.sample_rate_hz});
  }
  std::vector<size_t> recordings;
  for (const Piece& piece : pieces) recordings.push_back(piece.recording);
  state_space::tell_noise_apart(problem, recordings);
}

}  // namespace

BodiesStatement statement_of(const BodiesRecord& record, const BodiesLayout& layout, const std::vector<BodyTerm>& terms,
                             const std::vector<double>& known, const std::vector<dsp::IndexRange>& over,
                             Index thinned_by) {
  BodiesStatement result;
  state_space::Problem& problem = result.problem;
  problem.equations = equations_of(layout, terms, known);
  problem.sample_rate_hz = record.sample_rate_hz;
  problem.input_noise_std = record.input_noise_std;
  for (size_t j = 0; j < record.channels.size(); ++j)
    problem.channels.push_back(channel_of(record.channels[j], std::cmp_less(j, record.num_bodies), layout));
  const std::vector<Piece> pieces = pieces_in(record, over);
  const std::vector<Piece> fewer = shortened(pieces, most_samples);
  take_pieces(problem, record, fewer);
  if (fewer.empty()) return result;
  const Index factor = thinned_by > 0 ? thinned_by : state_space::thinning(problem);
  if (factor == 1) {
    for (const Piece& piece : fewer) result.origins.push_back({piece.recording, piece.last - 1});
  } else {
    const std::vector<Piece> more = shortened(pieces, factor * most_samples);
    take_pieces(problem, record, more);
    problem = state_space::thinned(std::move(problem), factor);
    constexpr Index of_ends = 8, least_thin = 32;  // samples that are left out at either end; pieces below are, whole
    for (const Piece& piece : more)
      if ((piece.size() - 1) / factor + 1 >= least_thin)
        result.origins.push_back({piece.recording, piece.first + ((piece.size() - 1) / factor - of_ends) * factor});
    result.thinned_by = static_cast<double>(factor);
  }
  return result;
}

}  // namespace ident
