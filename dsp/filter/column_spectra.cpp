#include "dsp/filter/column_spectra.hpp"

namespace dsp {

ColumnSpectra::Entry& ColumnSpectra::entry(Eigen::Index column) {
  const auto found = entries_.find(column);
  if (found != entries_.end()) return found->second;
  return entries_.insert({column, {ExtendedSpectrum(recording_.samples.col(column), recording_.sample_rate_hz)}})
      .first->second;
}

ExtendedSpectrum& ColumnSpectra::change(Eigen::Index column) {
  Entry& known = entry(column);
  known.changed = true;
  return known.spectrum;
}

void ColumnSpectra::store() {
  for (auto& [column, entry] : entries_) {
    if (!entry.changed) continue;
    recording_.samples.col(column) = entry.spectrum.signal();
    entry.changed = false;
  }
}

}  // namespace dsp
