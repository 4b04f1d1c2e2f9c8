#pragma once
#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "dsp/values/fault.hpp"

namespace dsp {

/// Several things are wrong at once. Caught as a Fault it is the first of them.
class SeveralFaults : public Fault {
 public:
  /// At least one.
  explicit SeveralFaults(std::vector<Fault> faults) : Fault(faults.at(0)), faults_(std::move(faults)) {}
  [[nodiscard]] const std::vector<Fault>& all() const& noexcept { return faults_; }
  void all() const&& = delete;

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
  /// Once, however often it is found. After `most` it is only said that there is more.
  void add(const Fault& fault) {
    const auto same = [&](const Fault& other) { return std::string_view(other.what()) == fault.what(); };
    if (is_full() || std::any_of(faults_.begin(), faults_.end(), same)) return;
    faults_.push_back(faults_.size() < most ? fault
                                            : Fault(fault.kind(), fault.name(), "more is wrong. Mend the above first"));
  }
  [[nodiscard]] bool empty() const { return faults_.empty(); }
  [[nodiscard]] bool is_full() const { return faults_.size() > most; }
  [[nodiscard]] const std::vector<Fault>& all() const& { return faults_; }
  void all() const&& = delete;
  /// Throws what was collected: nothing, a Fault or SeveralFaults.
  void raise() const {
    if (faults_.size() == 1) throw Fault(faults_.front());
    if (!faults_.empty()) throw SeveralFaults(faults_);
  }

 private:
  static constexpr std::size_t most = 100;  ///< more than anybody mends at one go

  std::vector<Fault> faults_;
};

}  // namespace dsp
