#pragma once
#include <string>
#include <vector>

#include "apps/paper/section4.hpp"
#include "ident/equation/equation_of_motion.hpp"
#include "sim/simulate.hpp"

namespace apps {

/// These equations of a case's states run free from rest, driven by the force of a record, over that record's time.
/// Ends early (diverged) where a state grows beyond a hundred times the largest true one.
[[nodiscard]] sim::Simulation free_response(const Section4Case& definition,
                                            const std::vector<ident::StateEquation>& equations,
                                            const Section4Record& record);

/// Of one state of a free response, against the truth.
struct StateError {
  std::string signal;
  double nmse = 0.0;   ///< NaN: the run diverged
  std::string status;  ///< "finished", or why not and when
};
/// One for each state.
[[nodiscard]] std::vector<StateError> state_errors(const sim::Simulation& run, const Section4Case& definition,
                                                   const Section4Record& record);

}  // namespace apps
