#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "dsp/prepare.hpp"
#include "dsp/sensors/motion.hpp"
#include "ident/library/expression.hpp"

namespace ident {

struct LibraryOptions {
  int order = 3;  ///< all products of `variables` up to this degree; 0: only `terms`
  std::vector<std::string> variables = {"x", "v"};
  std::vector<std::string> terms = {};  ///< further expressions; "1" is the constant
  bool constant = true;                 ///< "1" goes with order >= 1
  int max_terms = 1000;                 ///< more is refused before anything is formed
  bool operator==(const LibraryOptions&) const = default;
};

/// A candidate term: its name is the expression as a person would write it.
struct Term {
  std::string name;
  Expression expression;
  std::string unit;              ///< of the term's values, where it follows from the signals' units; else empty
  int recording = 0;             ///< 1-based: of its rows alone, zero on those of others; 0: of all
  std::string recording_name{};  ///< its name
  bool by_record = false;        ///< stands aside for terms of one recording each (terms_by_record)
  /// As a person would tell it from others: "sgn(v)", "sgn(v) in run2".
  [[nodiscard]] std::string label() const { return recording == 0 ? name : name + " in " + recording_name; }
};

/// The columns of Phi, in order.
struct CandidateLibrary {
  std::vector<Term> terms;
};

/// Degrees of these terms (indices into the library) as polynomials: 0 for the constant, 1 for a signal or a sign, of
/// others Expression::band_factor.
[[nodiscard]] Eigen::VectorXd degrees(const CandidateLibrary& library, const std::vector<Eigen::Index>& terms);

/// Throws dsp::Fault (usage): too many terms ("library.too_large", with the count), a name twice ("library.duplicate"),
/// the target among its own terms ("library.target"), or what Expression throws; of several terms as SeveralFaults.
[[nodiscard]] CandidateLibrary make_library(const LibraryOptions& options, const std::string& target,
                                            const dsp::Motion& signals);

/// The same for a recording. Relative, payload's and base's motion of one order are one identity: with its other
/// members among the terms the target explains itself, which is refused ("library.target"), as is a target that is no
/// signal of the recording ("target.unknown").
[[nodiscard]] CandidateLibrary record_library(const LibraryOptions& options, const std::string& target,
                                              const dsp::Prepared& prepared);

/// Unit of the coefficient of a term in an equation for the target: "1/s^2", "m/s^2"; empty where it does not follow.
[[nodiscard]] std::string coefficient_unit(const std::string& target_unit, const std::string& term_unit);

}  // namespace ident
