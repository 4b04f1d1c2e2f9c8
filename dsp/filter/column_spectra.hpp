#pragma once
#include <Eigen/Core>
#include <map>

#include "dsp/filter/spectral.hpp"
#include "dsp/recording.hpp"

namespace dsp {

/// Spectra of a recording's columns, each made when first asked for. Changes one after the other are products, and a
/// column is transformed back once, by store().
class ColumnSpectra {
 public:
  /// The recording is kept by reference; its columns must not change while their spectra do.
  explicit ColumnSpectra(Recording& recording) : recording_(recording) {}
  [[nodiscard]] const Recording& recording() const { return recording_; }
  /// Throws as ExtendedSpectrum.
  [[nodiscard]] const ExtendedSpectrum& of(Eigen::Index column) { return entry(column).spectrum; }
  /// The same, to be changed.
  [[nodiscard]] ExtendedSpectrum& change(Eigen::Index column);
  /// Writes the changed columns into the recording.
  void store();

 private:
  struct Entry {
    ExtendedSpectrum spectrum;
    bool changed = false;
  };
  Entry& entry(Eigen::Index column);

  Recording& recording_;
  std::map<Eigen::Index, Entry> entries_;
};

}  // namespace dsp
