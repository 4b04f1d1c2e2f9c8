#include "dsp/filter/column_spectra.hpp"

#include "dsp/values/for_each_index.hpp"

namespace dsp {

ColumnSpectra::Entry& ColumnSpectra::entry(Eigen::Index column) & {
  std::optional<Entry>& known = entries_[static_cast<std::size_t>(column)];
  if (!known) known = Entry{ExtendedSpectrum(recording_.samples.col(column), recording_.sample_rate_hz)};
  return *known;
}

ExtendedSpectrum& ColumnSpectra::change(Eigen::Index column) & {
  Entry& known = entry(column);
  known.changed = true;
  return known.spectrum;
}

void ColumnSpectra::store(int num_threads) {
  for_each_index(entries_.size(), num_threads, [&](std::size_t column) {
    std::optional<Entry>& known = entries_[column];
    if (!known || !known->changed) return;
    recording_.samples.col(static_cast<Eigen::Index>(column)) = known->spectrum.signal();
    known->changed = false;
  });
}

}  // namespace dsp
