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

/// A state that nothing records.
enum class Inner {
  none,
  hysteresis,  ///< of one body: a force per mass z with a memory; it stands in the equation as -z, which fixes its
               ///< scale. Of the force on an imposed motion: a part z of it
  lag          ///< of one body: z follows an input, z' = (input - z) / lag, and acts in its place; or it follows x, and
               ///< is what the displacement's sensor shows
};

/// Displacements x1 ... xn in a row, body i beside i - 1 and i + 1, and what acts on them from outside. One body alone
/// is x and v. Of an imposed motion x and v are inputs, and the one equation is of the force f that it takes.
struct BodiesLayout {
  int num_bodies = 0;
  Frame frame = Frame::ground;
  std::vector<std::string> inputs = {};  ///< "f", "r", "dr", "ddr", by any other name too
  Inner inner = Inner::none;
  std::string lagging = {};      ///< the input that z follows, or x
  bool imposed = false;          ///< the motion, as by a testing machine
  std::string force_unit = "N";  ///< of f where it is
  /// x and v of each body, or the impulse of f, whose rate it is; then z.
  [[nodiscard]] int num_states() const { return (imposed ? 1 : 2 * num_bodies) + (inner == Inner::none ? 0 : 1); }
  [[nodiscard]] bool sensor_lags() const { return inner == Inner::lag && lagging == named('x', 1); }
  /// The state that a channel of a body's displacement records.
  [[nodiscard]] int shown_state(int body) const { return sensor_lags() ? 2 * num_bodies : 2 * (body - 1); }
  /// What a run of the equations is compared in: "x1", of an imposed motion "f".
  [[nodiscard]] std::string response(int body) const { return imposed ? "f" : named('x', body); }
  /// "x1", "v1" of a body, and what its equation is for, "a1"; of the equation behind that of the last body "dz".
  [[nodiscard]] std::string named(char letter, int body) const;
  [[nodiscard]] std::string target(int equation) const;
  /// Empty: not known, as of a force that is not called f.
  [[nodiscard]] std::string target_unit(int equation, const std::string& length) const;
  [[nodiscard]] int num_equations() const { return num_bodies + (inner == Inner::none ? 0 : 1); }
  /// Own motion of a body as a term: "x1", "(x1 - r)"; its rate "v1", "(v1 - dr)".
  [[nodiscard]] std::string position(int body) const;
  [[nodiscard]] std::string speed(int body) const;
  /// Between a body and the next: "(x2 - x1)", "(v2 - v1)".
  [[nodiscard]] static std::string stretch(int lower);
  [[nodiscard]] static std::string stretch_rate(int lower);
};

/// A product in the equation of a body, from 1; behind the last that of z.
struct BodyTerm {
  int body = 1;
  std::string name;
  [[nodiscard]] bool operator==(const BodyTerm& other) const = default;
};
/// How a hysteretic z stands in the equation of its body, and by what coefficient: -1 in one of motion, 1 in a force.
[[nodiscard]] BodyTerm inner_force();
[[nodiscard]] double inner_force_coefficient(const BodiesLayout& layout);
/// What a lagging z is behind, the one term of its equation.
[[nodiscard]] BodyTerm behind_input(const BodiesLayout& layout);

struct BodyLibrary {
  int order = 3;                        ///< of products of own position and speed, and of powers of a stretch
  bool constant = true;                 ///< whether 1 is one
  bool defaults = true;                 ///< friction, stretches and inputs
  std::vector<std::string> terms = {};  ///< for every body: of x1, v1, ... and inputs, as they stand
};

/// For each body: 1 and products of own position and speed up to the order, sgn of the speed; for each neighbour powers
/// of the stretch, its rate and the sgn of that, all written upwards in both equations; every input but r and dr, which
/// act through the first two. For z the products of [Wen76] with exponents 1 and 2, that of [Val71] with x,
/// and z itself, by which it creeps back. With a lag z stands in the place of the input that it follows, alone and not
/// in products, and has one term: what it is behind.
[[nodiscard]] std::vector<BodyTerm> candidates_of(const BodiesLayout& layout, const BodyLibrary& library);

/// x1' = v1, v1' = terms of body 1, ...; states x1, v1, x2, v2 ... z; of an imposed motion the impulse of f, whose rate
/// is f's terms. With `known` coefficients, or all sought but that
/// of inner_force, which need not be among the terms.
[[nodiscard]] state_space::Equations equations_of(const BodiesLayout& layout, const std::vector<BodyTerm>& terms,
                                                  const std::vector<double>& known = {});

/// Unit of a term's coefficient in an equation for an acceleration or the rate of one, lengths in `length` ("m",
/// "rad"), f in N, other forces not known; empty where it does not follow.
[[nodiscard]] std::string unit_of(const BodyTerm& term, const BodiesLayout& layout, const std::string& length);

}  // namespace ident
