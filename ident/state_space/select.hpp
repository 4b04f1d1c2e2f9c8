#pragma once
#include <vector>

#include "ident/state_space/fit.hpp"

namespace ident::state_space {

struct SelectOptions {
  FitOptions fit = {};           ///< its terms: where the search for terms begins; empty: with all
  std::vector<int> barred = {};  ///< coefficients that are scored and never taken: usual forms outside a library
};

/// What the data say of one term.
struct Score {
  double gain = 0.0;         ///< by how much -2 log likelihood falls with it, others of the selection adapted
  double probability = 0.0;  ///< of its belonging to the equation: from gain less price
};

/// A barred term that the data ask for: with it, or with it in the place of others, the equation is more likely by more
/// than its price.
struct Outside {
  int term = 0;
  double gain = 0.0;               ///< of -2 log likelihood, less the price of the terms
  double explains = 1.0;           ///< of the variance of the process noise, which falls by it; 1 where there is none
  std::vector<int> instead_of;     ///< of the selected ones
  std::vector<double> parameters;  ///< with it, as Layout has them
};

struct Selection {
  Fit fit;                       ///< of the selected terms; covariance with what others may take from them
  std::vector<Score> scores;     ///< of every coefficient; of those outside the score test
  std::vector<Outside> outside;  ///< the best first
  double price = 0.0;            ///< of a term: ln m + 2 ln b, m samples recorded, b terms to choose from
  bool settled = false;          ///< no exchange, addition or removal of a term is more likely
  bool hopeless = false;         ///< with the first terms the channels stay far above their floors
};

/// The terms for which J + price x number is least. All terms are fitted first (or those proposed) and the noise is
/// estimated there and held. Then one linear solution with every candidate freed answers for all subsets: those whose
/// quadratic cost is least are fitted anew, until the choice repeats itself. Throws as fit.
[[nodiscard]] Selection select(const Problem& problem, const SelectOptions& options);

}  // namespace ident::state_space
