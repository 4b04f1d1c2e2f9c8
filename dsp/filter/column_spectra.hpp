#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "dsp/filter/spectral.hpp"
#include "dsp/values/recording.hpp"

namespace dsp {

/// Spectra of a recording's columns, each made when first asked for. Changes one after the other are products, and a
/// column is transformed back once, by store(). Different columns may be asked for from different threads at a time.
class ColumnSpectra {
 public:
  /// The recording is kept by reference; its columns must not change while their spectra do.
  explicit ColumnSpectra(Recording& recording)
      : recording_(recording), entries_(static_cast<std::size_t>(recording.samples.cols())) {}
  [[nodiscard]] const Recording& recording() const& { return recording_; }
  void recording() const&& = delete;
  /// Throws as ExtendedSpectrum.
  [[nodiscard]] const ExtendedSpectrum& of(Eigen::Index column) & { return entry(column).spectrum; }
  /// The same, to be changed.
  [[nodiscard]] ExtendedSpectrum& change(Eigen::Index column) &;
  /// Writes the changed columns into the recording, on up to so many threads.
  void store(int num_threads = 1);

 private:
  struct Entry {
    ExtendedSpectrum spectrum;
    bool changed = false;
  };
  Entry& entry(Eigen::Index column) &;

  Recording& recording_;
  std::vector<std::optional<Entry>> entries_;  ///< of each column; none: nobody asked for it
};

}  // namespace dsp
