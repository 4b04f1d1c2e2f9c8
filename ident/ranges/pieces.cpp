#include "ident/ranges/pieces.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ident {
namespace {

using Eigen::Index;
using std::size_t;

constexpr Index least_samples = 32;  // of a piece: less says nothing but where it begins

}  // namespace

std::vector<Piece> pieces_of(const Range& range, const std::vector<Row>& rows, bool are_last,
                             const std::vector<Columns>& recordings, bool with_gaps) {
  std::vector<Piece> pieces;
  const auto end = static_cast<Index>(rows.size());
  for (Index first = 0; first < end;) {
    const Index behind = end_of_stretch(rows, first, end);
    const Row &from = rows[static_cast<size_t>(first)], &to = rows[static_cast<size_t>(behind - 1)];
    const dsp::Prepared& prepared = *recordings[from.recording].prepared;
    const double samples_a_row = prepared.intermediate.sample_rate_hz / prepared.signals.sample_rate_hz;
    const auto sample = [&](Index row) { return std::lround(static_cast<double>(row) * samples_a_row); };
    const Index num_rows = prepared.signals.num_samples(), edge = prepared.signals.edge_samples;
    Piece piece{from.recording, sample(from.sample), sample(to.sample) + 1};
    if (from.sample <= edge && range.spec.from_s <= 0.0) piece.first = 0;
    if (to.sample + 1 >= num_rows - edge && are_last) piece.last = prepared.intermediate.num_samples();
    if (with_gaps && !pieces.empty() && pieces.back().recording == piece.recording)
      pieces.back().last = piece.last;
    else
      pieces.push_back(piece);
    first = behind;
  }
  std::erase_if(pieces, [](const Piece& piece) { return piece.size() < least_samples; });
  return pieces;
}

Index num_samples(const std::vector<Piece>& pieces) {
  return std::accumulate(pieces.begin(), pieces.end(), Index{0},
                         [](Index sum, const Piece& piece) { return sum + piece.size(); });
}

std::vector<Piece> shortened(const std::vector<Piece>& pieces, Index most) {
  const Index all = num_samples(pieces);
  if (all <= most) return pieces;
  constexpr Index most_parts = 8;  // of a long record, spread over it
  std::vector<Piece> shorter;
  for (const Piece& piece : pieces) {
    const auto size =
        static_cast<Index>(static_cast<double>(piece.size()) * static_cast<double>(most) / static_cast<double>(all));
    const Index parts = std::clamp<Index>(piece.size() / (16 * least_samples), 1, most_parts);
    const Index each = std::max(size / parts, std::min(piece.size() / parts, 16 * least_samples));
    for (Index i = 0; i < parts; ++i) {
      const Index first = piece.first + i * piece.size() / parts + (piece.size() / parts - each) / 2;
      shorter.push_back({piece.recording, first, first + each});
    }
  }
  return shorter;
}

}  // namespace ident
