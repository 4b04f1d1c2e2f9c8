#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/equation/model.hpp"
#include "ident/ranges/ranges.hpp"
#include "ident/regression/fit.hpp"

namespace ident {

/// Whether the lower part of the band gives the coefficients that all of it gives. A filter changes no coefficient of
/// an equation that holds; where one changes, what lies above does not follow the equation: another mode, or products
/// that went through anti-alias filters, which turn their phases, with the motion, while a candidate such as x^3 is
/// formed behind them.
struct BandSplit {
  double stop_hz = 0.0;  ///< columns are gone from here on
  std::string term;      ///< label of the coefficient that differs most, against its interval; empty: none does
  double mean = 0.0, lower_mean = 0.0;  ///< of that coefficient, and of the same in the lower octave
};

/// Of the equation kept on these training rows, whose residual is given (sensors' errors taken off), by least squares
/// of the residual on the kept columns, both low-passed again, an octave lower. A coefficient differs if it does so by
/// more than its printed 95 % interval, and by more than the low-passed residual, in fifty blocks, can do by chance
/// (1 % for all coefficients together). Nothing where the rows of successive samples are too short for the filter, hold
/// too little, or do not tell the terms apart there, where recordings differ in rate or band, and for tables.
[[nodiscard]] std::optional<BandSplit> band_split(const Model& model, const std::vector<Eigen::Index>& terms,
                                                  const std::vector<Row>& rows, const std::vector<Columns>& recordings,
                                                  const Eigen::Ref<const Eigen::VectorXd>& residual, const Poll& poll);

}  // namespace ident
