#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "ident/candidate_library.hpp"
#include "sim/system.hpp"

namespace apps {

/// One identified state equation: d(state row)/dt = sum of mean_i term_i where `where` holds.
struct IdentifiedRow {
  int row = 1;                      ///< of the state equation, from 1: x, v, z
  std::string where;                ///< a condition on the sign of v; empty: always
  std::vector<Eigen::Index> terms;  ///< of the library
  Eigen::VectorXd mean;
};

/// Identified equations of all states as a system to integrate. sgn(v) and conditions on v switch at located zeros of
/// v; where friction holds from both sides, the system sticks. `library` must outlive it. Throws std::invalid_argument
/// for a switch on anything but v, or a signal that is not t, f or a state.
[[nodiscard]] sim::System identified_system(const ident::CandidateLibrary& library,
                                            const std::vector<IdentifiedRow>& rows, std::vector<std::string> states,
                                            std::function<double(double)> forcing);

}  // namespace apps
