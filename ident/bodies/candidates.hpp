#pragma once
#include <string>
#include <vector>

#include "ident/state_space/problem.hpp"

namespace ident {

/// What displacements of bodies are measured against.
enum class Frame {
  ground,    ///< no base was recorded
  absolute,  ///< the base moves by r: they are its equals
  base       ///< they are relative to the base, whose acceleration ddr acts on all
};

/// Displacements x1 ... xn in a row, body i beside i - 1 and i + 1, and what acts on them from outside.
struct BodiesLayout {
  int num_bodies = 0;
  Frame frame = Frame::ground;
  std::vector<std::string> inputs = {};  ///< "f", "r", "dr", "ddr", by any other name too
  /// Own motion of a body as a term: "x1", "(x1 - r)"; its rate "v1", "(v1 - dr)".
  [[nodiscard]] std::string position(int body) const;
  [[nodiscard]] std::string speed(int body) const;
  /// Between a body and the next: "(x2 - x1)", "(v2 - v1)".
  [[nodiscard]] static std::string stretch(int lower);
  [[nodiscard]] static std::string stretch_rate(int lower);
};

/// A product in the equation of a body, from 1.
struct BodyTerm {
  int body = 1;
  std::string name;
};

struct BodyLibrary {
  int order = 3;                        ///< of products of own position and speed, and of powers of a stretch
  bool defaults = true;                 ///< friction, stretches and inputs
  std::vector<std::string> terms = {};  ///< for every body: of x1, v1, ... and inputs, as they stand
};

/// For each body: 1 and products of own position and speed up to the order, sgn of the speed; for each neighbour powers
/// of the stretch, its rate and the sgn of that, all written upwards in both equations; every input but r and dr, which
/// act through the first two.
[[nodiscard]] std::vector<BodyTerm> candidates_of(const BodiesLayout& layout, const BodyLibrary& library);

/// x1' = v1, v1' = terms of body 1, ...; states x1, v1, x2, v2 ... With `known` coefficients, or all sought.
[[nodiscard]] state_space::Equations equations_of(const BodiesLayout& layout, const std::vector<BodyTerm>& terms,
                                                  const std::vector<double>& known = {});

/// Unit of a term's coefficient in an equation for an acceleration, lengths in `length` ("m", "rad"), f in N, other
/// inputs not known; empty where it does not follow.
[[nodiscard]] std::string unit_of(const BodyTerm& term, const BodiesLayout& layout, const std::string& length);

}  // namespace ident
