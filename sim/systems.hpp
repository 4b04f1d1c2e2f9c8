#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/ode/system.hpp"

// The oscillators of Section 4 of [QZS23] with the paper's parameters as defaults, every switch (sgn, |.|, stick)
// located and none smoothed. Unless another drive is given, all are driven at omega = ratio * omega_n. Their input is f
// = cos(omega t) (sin for Valanis) and `force_n` multiplies it: as in the paper, f is the candidate term and the force
// its coefficient.

namespace sim {

/// f(t); empty: the sine or cosine.
using Forcing = std::function<double(double t)>;

/// m x'' + c x' + k x = F0 f, by omega_n and zeta per unit mass.
struct Linear {
  double omega_n = 5.0, zeta = 0.1, force_n = 100.0, ratio = 1.0, x0 = 0.0, v0 = 0.0;
  Forcing drive = {};
};

/// x'' + 2 zeta omega_n x' + omega_n^2 x + epsilon omega_n^2 x^3 = F0 f (Eq. 38).
struct Duffing {
  double omega_n = 5.0, zeta = 0.1, epsilon = 100.0, force_n = 100.0, ratio = 1.0, x0 = 0.0, v0 = 0.0;
  Forcing drive = {};
};

/// m x'' + c x' + k x + c_f sgn(x') = F0 f (Eq. 40); at rest it sticks while |F0 f - k x| <= c_f.
struct Coulomb {
  double m = 1.0, c = 2.0, k = 1000.0, c_f = 1.0, force_n = 100.0, ratio = 1.0, x0 = 0.0, v0 = 0.0;
  Forcing drive = {};
};

/// m x'' + a k x + (1 - a) k z = F0 f, z' = x' - delta z |z|^(alpha-1) |x'| - gamma |z|^alpha x' (Eq. 42). The third
/// state is the restoring force k z, as in Eq. 43.
struct BoucWen {
  double m = 1.0, k = 50.0, a = 0.0, alpha = 1.0, delta = 0.5, gamma = 0.5, force_n = 100.0, ratio = 1.0;
  double x0 = 0.0, v0 = 0.0, z0 = 0.0;
  Forcing drive = {};
};

/// m x'' + k x + z = F0 f, z' = (E1 + sgn(x') (P - E2 z)) x' (Eq. 44 corrected: its second line is the force's rate).
struct Valanis1 {  ///< P = alpha x (Eq. 45 corrected: 10 + sgn(v) (5 x - 20 z))
  double m = 1.0, k = 100.0, e1 = 10.0, e2 = 20.0, alpha = 5.0, force_n = 1.0, ratio = 1.0;
  double x0 = 0.0, v0 = 0.0, z0 = 0.0;
  Forcing drive = {};
};
struct Valanis2 {  ///< P = alpha x + beta x^2 |x'| (Eq. 46)
  double m = 1.0, k = 100.0, e1 = 10.0, e2 = 20.0, alpha = 30.0, beta = 1400.0, force_n = 1.0, ratio = 1.0;
  double x0 = 0.0, v0 = 0.0, z0 = 0.0;
  Forcing drive = {};
};
struct Valanis3 {  ///< P = alpha x + beta e^x x' (Eq. 47)
  double m = 1.0, k = 100.0, e1 = 30.0, e2 = 500.0, alpha = 5e4, beta = 3e4, force_n = 1.0, ratio = 1.0;
  double x0 = 0.0, v0 = 0.0, z0 = 0.0;
  Forcing drive = {};
};
struct Valanis4 {  ///< P = alpha1 sin x for x' >= 0, alpha2 x for x' < 0 (Eq. 48)
  double m = 1.0, k = 100.0, e1 = 10.0, e2 = 20.0, alpha1 = 40.0, alpha2 = 15.0, force_n = 1.0, ratio = 1.0;
  double x0 = 0.0, v0 = 0.0, z0 = 0.0;
  Forcing drive = {};
};

/// One term of the true equations in the candidate terms of the paper's libraries.
struct TrueTerm {
  int row = 1;         ///< of the state equation, from 1
  std::string target;  ///< the derivative in that row: "v" (of x), "a" (of v), "dz" (of z)
  std::string name;    ///< "x^3", "abs(v)*z", "f" ...
  double value = 0.0;
  std::string where = {};  ///< condition under which the row holds; empty: always
};

/// A system ready to run, with what is true about it.
struct Experiment {
  System system;
  Eigen::VectorXd initial;
  double omega_n = 0.0;                                    ///< rad/s, undamped and small: what `ratio` refers to
  std::vector<std::pair<std::string, double>> parameters;  ///< all of them, by field name
  std::vector<TrueTerm> truth;
};

[[nodiscard]] Experiment make_experiment(const Linear& parameters);
[[nodiscard]] Experiment make_experiment(const Duffing& parameters);
[[nodiscard]] Experiment make_experiment(const Coulomb& parameters);
[[nodiscard]] Experiment make_experiment(const BoucWen& parameters);
[[nodiscard]] Experiment make_experiment(const Valanis1& parameters);
[[nodiscard]] Experiment make_experiment(const Valanis2& parameters);
[[nodiscard]] Experiment make_experiment(const Valanis3& parameters);
[[nodiscard]] Experiment make_experiment(const Valanis4& parameters);

/// "linear", "duffing", "coulomb", "bouc-wen", "valanis-1" ... "valanis-4".
[[nodiscard]] std::vector<std::string> experiment_names();
/// By name, with parameters set by field name. Throws std::invalid_argument that lists the names there are.
[[nodiscard]] Experiment make_experiment(std::string_view name,
                                         const std::vector<std::pair<std::string, double>>& set = {},
                                         const Forcing& drive = {});

}  // namespace sim
