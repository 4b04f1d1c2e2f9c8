#pragma once
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "ident/bodies/bodies.hpp"
#include "sim/chain.hpp"

namespace support {

/// The equations that a chain obeys.
[[nodiscard]] inline ident::BodiesModel true_model(const sim::Experiment& experiment, const sim::Chain& chain) {
  ident::BodiesModel model;
  model.layout = {static_cast<int>(chain.masses.size()),
                  chain.base_driven ? ident::Frame::absolute : ident::Frame::ground,
                  chain.base_driven ? std::vector<std::string>{"r", "dr"} : std::vector<std::string>{"f"}};
  std::map<std::pair<int, std::string>, double> sums;
  for (const sim::TrueTerm& term : experiment.truth)
    if (term.target.front() == 'a') sums[{term.row / 2, term.name}] += term.value;
  model.mean.resize(std::ssize(sums));
  for (const auto& [term, value] : sums) {
    model.mean(std::ssize(model.terms)) = value;
    model.terms.push_back({term.first, term.second});
  }
  return model;
}

}  // namespace support
