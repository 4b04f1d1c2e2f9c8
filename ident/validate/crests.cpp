#include "ident/validate/crests.hpp"

#include <algorithm>
#include <cmath>

namespace ident {

std::vector<double> crests(const Eigen::Ref<const Eigen::VectorXd>& displacement) {
  std::vector<double> found;
  if (displacement.size() < 2) return found;
  const double mean = displacement.mean();
  bool whole = false;  // the cycle under way has begun within the record
  double largest = 0.0;
  for (Eigen::Index i = 1; i < displacement.size(); ++i) {
    const double before = displacement(i - 1) - mean, now = displacement(i) - mean;
    if (before < 0.0 && now >= 0.0) {
      if (whole) found.push_back(largest);
      whole = true;
      largest = now;
    }
    largest = std::max(largest, now);
  }
  return found;
}

double renewed_amplitude(const std::vector<double>& crests, double least) {
  if (crests.empty()) return 0.0;
  // Between turning points a crest moves one way; a turn counts once the crest has come back by `least`.
  double rises = 0.0, falls = 0.0, turn = crests.front(), extreme = crests.front();
  int direction = 0;
  const auto close = [&] { (direction > 0 ? rises : falls) += std::abs(extreme - turn); };
  for (const double crest : crests) {
    if (direction == 0) {
      if (std::abs(crest - turn) < least) continue;
      direction = crest > turn ? 1 : -1;
      extreme = crest;
    } else if (direction * (crest - extreme) >= 0.0) {
      extreme = crest;
    } else if (direction * (extreme - crest) >= least) {
      close();
      turn = extreme;
      extreme = crest;
      direction = -direction;
    }
  }
  if (direction != 0) close();
  const double largest = *std::max_element(crests.begin(), crests.end());
  return largest > 0.0 ? std::min(rises, falls) / largest : 0.0;
}

std::vector<std::vector<double>> crests_of(const RangeRows& rows, const std::vector<Columns>& recordings) {
  std::vector<std::vector<double>> result;
  for (std::size_t r = 0; r < rows.usable.size(); ++r) {
    const dsp::Signal* x = recordings[r].signals->find("x");
    const std::vector<Eigen::Index>& samples = rows.usable[r];
    for (std::size_t first = 0, last = 0; x != nullptr && first < samples.size(); first = last) {
      for (last = first + 1; last < samples.size() && samples[last] == samples[last - 1] + 1;) ++last;
      result.push_back(crests(x->values.segment(samples[first], static_cast<Eigen::Index>(last - first))));
    }
  }
  return result;
}

}  // namespace ident
