#pragma once
#include <catch2/catch.hpp>
#include <functional>
#include <string>

#include "dsp/values/fault.hpp"

namespace support {

/// The fault that `act` ends in; a failed test if it ends in none.
inline dsp::Fault fault_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const dsp::Fault& fault) {
    return fault;
  }
  FAIL("no fault was raised");
  throw std::logic_error("unreachable");
}

/// Of the fault that `act` ends in.
inline std::string name_of_fault(const std::function<void()>& act) {
  const dsp::Fault fault = fault_of(act);
  return fault.name();
}

/// Checks kind and name of the fault, that its message is one line and holds every piece, and its lines theirs.
inline void check_fault(const std::function<void()>& act, dsp::FaultKind kind, const std::string& name,
                        const std::vector<std::string>& pieces, const std::vector<std::string>& lines = {}) {
  const auto fault = fault_of(act);
  CHECK(fault.kind() == kind);
  CHECK(fault.name() == name);
  for (const auto& piece : pieces) CHECK_THAT(fault.what(), Catch::Contains(piece));
  for (const auto& piece : lines) CHECK_THAT(fault.lines(), Catch::Contains(piece));
  CHECK(std::string(fault.what()).find('\n') == std::string::npos);
}

}  // namespace support
