#pragma once
#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "dsp/fault.hpp"

namespace dsp {

/// Several things are wrong at once. Caught as a Fault it is the first of them.
class SeveralFaults : public Fault {
 public:
  /// At least one.
  explicit SeveralFaults(std::vector<Fault> faults) : Fault(faults.at(0)), faults_(std::move(faults)) {}
  [[nodiscard]] const std::vector<Fault>& all() const noexcept { return faults_; }

 private:
  std::vector<Fault> faults_;
};

/// Collects what is wrong, so that all of it can be said at once.
class Faults {
 public:
  /// Does what `body` does; false if it threw a Fault, which is kept.
  template <class Body>
  bool attempt(Body&& body) {
    try {
      body();
      return true;
    } catch (const SeveralFaults& several) {
      for (const Fault& fault : several.all()) add(fault);
    } catch (const Fault& fault) {
      add(fault);
    }
    return false;
  }
  /// Once, however often it is found.
  void add(const Fault& fault) {
    const auto same = [&](const Fault& other) { return std::string_view(other.what()) == fault.what(); };
    if (std::none_of(faults_.begin(), faults_.end(), same)) faults_.push_back(fault);
  }
  [[nodiscard]] bool empty() const { return faults_.empty(); }
  [[nodiscard]] const std::vector<Fault>& all() const { return faults_; }
  /// Throws what was collected: nothing, a Fault or SeveralFaults.
  void raise() const {
    if (faults_.size() == 1) throw Fault(faults_.front());
    if (!faults_.empty()) throw SeveralFaults(faults_);
  }

 private:
  std::vector<Fault> faults_;
};

}  // namespace dsp
