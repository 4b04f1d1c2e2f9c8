#include "apps/paper/paper_tables.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string_view>

namespace apps {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr const char *up = "v >= 0", *down = "v < 0";

// table, row, where, term, F-RVM, S-RVM, SINDy, CoV of F-RVM, CoV of S-RVM
constexpr PaperTerm terms[] = {
    {1, 1, "", "v", 0.9995, 0.9995, 0.9995, 0.0028, 7.5e-4},
    {1, 2, "", "f", 99.8353, 99.8353, 99.8381, 2.7e-4, 0.0017},
    {1, 2, "", "v", -0.9853, -0.9853, -0.9857, 0.0028, 0.0174},
    {1, 2, "", "x", -25.3157, -25.3157, -25.3271, 0.0042, 0.0259},
    {1, 2, "", "x^3", -2493.8, -2493.8, -2493.8, 2.1e-4, 0.0013},

    {2, 1, "", "v", 0.9994, 0.9994, 0.9994, 3.2e-4, 7.6e-4},
    {2, 2, "", "f", 100.4889, 100.4890, 100.4983, 1.2e-5, 0.0055},
    {2, 2, "", "v", -2.0206, -2.0206, -2.0134, 3.5e-4, 0.0163},
    {2, 2, "", "x", -1000.0, -1000.0, -1000.0, 1.6e-5, 7.7e-5},
    {2, 2, "", "sgn(v)", -1.0515, -1.0512, -1.2209, 0.0088, 0.4070},

    {3, 1, "", "v", 0.9993, 0.9993, 0.9993, 6.4e-4, 8.8e-4},
    {3, 2, "", "f", 100.0320, 100.0320, 100.0320, 1.4e-3, 0.0014},
    {3, 2, "", "z", -0.9962, -0.9962, -0.9962, 2.5e-2, 0.0024},
    {3, 3, "", "v", 49.9918, 49.9918, 49.9920, 3.8e-5, 0.0012},
    {3, 3, "", "z*abs(v)", -0.5015, -0.5015, -0.5015, 8.2e-5, 0.0026},
    {3, 3, "", "abs(z)*v", -0.4997, -0.4997, -0.4997, 1.4e-4, 0.0043},

    {4, 1, "", "v", 1.0012, 1.0012, 1.0012, 6.4e-4, 9.1e-4},
    {4, 2, "", "1", -24.6415, -24.6424, -21.7528, none, none},
    {4, 2, "", "x", -6.4423, -6.4392, -6.4999, none, none},
    {4, 2, "", "v", -2.2892, -2.2892, -2.3825, none, none},
    {4, 2, "", "x^2", -0.9961, -0.9961, -0.9166, none, none},
    {4, 2, "", "abs(x)", 8.3936, 8.3965, 7.4717, none, none},
    {4, 2, "", "abs(v)", 1.1851, 1.1853, 0.7333, none, none},
    {4, 2, "", "x*abs(v)", 0.2205, 0.2200, 0.2504, none, none},
    {4, 2, "", "abs(x)*abs(v)", -0.1725, -0.1729, -0.1434, none, none},
    {4, 2, "", "f", 130.4215, 130.4222, 131.5459, none, none},

    {5, 1, "", "v", 1.0006, 1.0006, 1.0006, none, none},
    {5, 2, "", "f", 0.9983, 0.9983, 0.9997, none, none},
    {5, 2, "", "x", -99.9523, -99.9506, -99.8679, none, none},
    {5, 2, "", "z", -1.0524, -1.0529, -1.0605, none, none},
    {5, 3, "", "v", 10.0185, 10.0185, 10.0186, none, none},
    {5, 3, "", "abs(v)*x", 5.0051, 5.0051, 5.0054, none, none},
    {5, 3, "", "abs(v)*z", -20.0376, -20.0376, -20.0378, none, none},

    {6, 1, "", "v", 0.9995, 0.9995, 0.9995, none, none},
    {6, 2, "", "f", 1.0079, 1.0079, 1.0079, none, none},
    {6, 2, "", "x", -99.8770, -99.8770, -99.9048, none, none},
    {6, 2, "", "z", -1.0046, -1.0046, -0.9964, none, none},
    {6, 3, "", "v", 9.9942, 9.9942, 9.9958, none, none},
    {6, 3, "", "abs(v)*x", 30.2019, 30.2019, 30.1965, none, none},
    {6, 3, "", "x^2*v^2", 1399.4, 1399.4, 1399.4, none, none},
    {6, 3, "", "abs(v)*z", -19.9829, -19.9829, -19.9829, none, none},

    {7, 1, "", "v", 0.9996, 0.9996, 0.9996, none, none},
    {7, 1, "", "x*v", none, none, 1.3676, none, none},
    {7, 2, "", "f", 0.9991, 0.9991, 0.9994, none, none},
    {7, 2, "", "x", -99.7381, -99.7377, -99.7443, none, none},
    {7, 2, "", "z", -0.9997, -0.9997, -0.9997, none, none},
    {7, 2, "", "x^2", none, none, 49.8043, none, none},
    {7, 2, "", "x*v", none, none, -7.5446, none, none},
    {7, 2, "", "abs(v)*x", none, none, -11.2788, none, none},
    {7, 3, "", "v", 28.8967, 28.8967, 28.9692, none, none},
    {7, 3, "", "abs(v)*x", 5.1739e4, 5.1740e4, 5.2060e4, none, none},
    {7, 3, "", "exp(x)*v*abs(v)", 3.0114e4, 3.0114e4, 3.0116e4, none, none},
    {7, 3, "", "abs(v)*z", -502.7737, -502.7739, -502.9504, none, none},
    {7, 3, "", "x", none, none, -3.5811, none, none},
    {7, 3, "", "x^2", none, none, 4.0966e3, none, none},
    {7, 3, "", "x*v", none, none, 226.7527, none, none},
    {7, 3, "", "x*z", none, none, -12.8410, none, none},
    {7, 3, "", "v^2", none, none, 9.9603, none, none},

    {8, 1, "", "v", 0.9997, 0.9997, 0.9997, none, none},
    {8, 2, "", "f", 1.0033, 1.0033, 1.0035, none, none},
    {8, 2, "", "x", -99.9195, -99.9216, -99.5150, none, none},
    {8, 2, "", "z", -1.0076, -1.0074, -1.0374, none, none},
    {8, 2, "", "x^2", none, none, 3.8197, none, none},
    {8, 3, up, "v", 10.0118, 10.0118, 10.0133, none, none},
    {8, 3, up, "v*z", -19.9631, -19.9631, -19.9589, none, none},
    {8, 3, up, "v*sin(x)", 39.0006, 39.0005, 232.1757, none, none},
    {8, 3, up, "x*v", none, none, -193.0051, none, none},
    {8, 3, down, "v", 9.9999, 9.9999, 9.9997, none, none},
    {8, 3, down, "x*v", -14.9991, -14.9991, -15.0229, none, none},
    {8, 3, down, "v*z", 20.0309, 20.0309, 20.0323, none, none},

    {10, 1, "", "x", -0.7623, -0.7623, -0.7621, 0.1740, 0.0214},
    {10, 1, "", "v", -0.6331, -0.6331, -0.6330, 0.0584, 0.0072},
    {10, 1, "", "sgn(v)", -0.0622, -0.0622, -0.0623, 0.3217, 0.0395},
    {10, 1, "", "ddr", -0.4919, -0.4919, -0.4921, 0.2593, 0.0318},

    {11, 1, "", "x", -0.6049, -0.6047, -0.6321, 0.3215, 0.0560},
    {11, 1, "", "v", -2.1243, -2.1255, -2.1983, 0.1833, 0.0319},
    {11, 1, "", "x*v", 0.1875, 0.1875, 0.1733, 0.2892, 0.0503},
    {11, 1, "", "v^2", -0.1839, -0.1838, none, 0.7174, 0.1247},
    {11, 1, "", "x^3", -2.2597, -2.2602, -2.2075, 0.1185, 0.0206},
    {11, 1, "", "x*v^2", 0.3990, 0.3988, 0.4248, 0.5347, 0.0931},
    {11, 1, "", "v^3", 0.6654, 0.6656, 0.7979, 0.3916, 0.0681},
    {11, 1, "", "ddr", -0.2978, -0.2990, -0.2214, 1.0149, 0.1763},

    {12, 1, "", "x", -0.9473, -0.9473, -0.9617, 0.1321, 0.0167},
    {12, 1, "", "v", -1.7042, -1.7042, -1.7911, 0.0534, 0.0068},
    {12, 1, "", "x^3", -1.2727, -1.2727, -1.2574, 0.1086, 0.0138},
    {12, 1, "", "x^2*v", -0.3258, -0.3258, -0.3334, 0.1506, 0.0191},
    {12, 1, "", "x*v^2", 0.1059, 0.1059, 0.1207, 1.3339, 0.1690},
    {12, 1, "", "v^3", -1.4196, -1.4196, -1.1905, 0.2482, 0.0315},
    {12, 1, "", "ddr", -0.6296, -0.6296, -0.6231, 0.0950, 0.0120},
};

constexpr PaperSeconds seconds[] = {
    {1, 26.1550, 212.6206, 0.0174}, {2, 21.9345, 90.2491, 0.0108},  {3, 28.7660, 122.2755, 0.0118},
    {4, 10.4534, 83.3005, 0.0078},  {5, 61.4065, 189.9256, 0.0206}, {6, 89.7748, 333.4480, 0.0175},
    {7, 52.1649, 200.3144, 0.0210}, {8, 96.1552, 280.5071, 0.0298}, {10, 5.3097, 20.8211, 1.965e-4},
    {11, 1.8154, 8.9556, 0.0051},   {12, 69.9780, 515.4777, 0.0087}};

constexpr PaperErrors errors[] = {{10, {0.0224, 0.0224, 0.0224}, {0.0240, 0.0240, 0.0240}},
                                  {11, {0.0142, 0.0142, 0.0149}, {0.0169, 0.0169, 0.0167}},
                                  {12, {0.0190, 0.0190, 0.0194}, {0.0907, 0.0907, 0.0938}}};

}  // namespace

double PaperTerm::printed(std::string_view method) const {
  return method == "fast_rvm" ? fast_rvm : method == "slow_rvm" ? slow_rvm : sindy;
}

std::span<const PaperTerm> paper_terms() {
  return terms;
}
std::span<const PaperSeconds> paper_seconds() {
  return seconds;
}

std::span<const PaperErrors> paper_errors() {
  return errors;
}

PaperVerdict judge_coefficient(double printed, double expected, double se) {
  const double off = std::abs(printed - expected) / se;
  if (off <= stds_allowed)
    return {"within noise", expected != 0.0
                                ? ""
                                : "a false term, let in by a threshold on raw coefficients; one on unit-norm "
                                  "columns (0.02) leaves it out"};
  return {"not reproducible", fmt::format("{:.3g} standard deviations from what the stated method gives", off)};
}

double expected_cov(double mean, double se) {
  // mean = L gamma with gamma = 1 - (se / L)^2, so L^2 - mean L - se^2 = 0.
  const double least_squares = 0.5 * (std::abs(mean) + std::sqrt(mean * mean + 4.0 * se * se));
  return se * std::sqrt(std::abs(mean) / least_squares) / std::abs(mean);
}

PaperVerdict judge_cov(double printed, double expected) {
  const double ratio = printed / expected, decades = std::round(std::log10(ratio));
  if (std::abs(ratio - 1.0) <= 0.05) return {"within noise", ""};
  if (decades != 0.0 && std::abs(ratio / std::pow(10.0, decades) - 1.0) <= 0.05)
    return {"misprint", fmt::format("expected {:.2g}: {} off (inferred)", expected,
                                    std::abs(decades) == 1.0 ? "a power of ten"
                                                             : fmt::format("{:g} powers of ten", std::abs(decades)))};
  const std::string a = fmt::format("{:.1e}", printed), b = fmt::format("{:.1e}", expected);
  int different = 0;
  for (std::size_t i = 0; i < a.size(); ++i) different += a[i] != b[i];
  if (a.size() == b.size() && different == 1)
    return {"misprint",
            fmt::format("expected {:.2g}: one digit off (inferred; one number in a few differs by no more)", expected)};
  return {"not reproducible", fmt::format("expected {:.3g}", expected)};
}

}  // namespace apps
