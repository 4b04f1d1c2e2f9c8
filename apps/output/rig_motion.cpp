#include "apps/output/rig_motion.hpp"

#include <fmt/format.h>

#include <optional>

namespace apps {
namespace {
constexpr int rows_per_response = 10;  // of the truth's: 25.6 Hz, the rate of regression
}  // namespace

sim::RigTruth write_motion(const sim::RigTest& test, bool with_truth, const OutputFolder& folder,
                           const std::function<void(double)>& progress) {
  OutputFile response = folder.file("response.csv");
  std::optional<OutputFile> exact;
  response.write("t,x,v,a,r,dr,ddr\n");
  if (with_truth) exact.emplace(folder.file("truth.csv")).write("t,x,v,r,ddr,mode\n");
  const auto write = [&, row = 0](const sim::QzsState& s) mutable {
    const double t = s.t_s - test.from_s;
    if (row++ % rows_per_response == 0)
      response.write(fmt::format("{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g}\n", t, s.x, s.v, s.a,
                                 s.base.r_m, s.base.dr_m_per_s, s.base.ddr_m_per_s2));
    if (exact)
      exact->write(fmt::format("{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{}\n", t, s.x, s.v, s.base.r_m,
                               s.base.ddr_m_per_s2, s.mode));
  };
  sim::RigTruth truth = sim::rig_truth(test, {.take = write, .progress = progress});
  response.close();
  if (exact) exact->close();
  return truth;
}

double motion_bytes_per_s(bool with_truth) {
  constexpr double bytes_per_response = 140.0, bytes_per_truth = 110.0;
  return sim::truth_rate_hz * (bytes_per_response / rows_per_response + (with_truth ? bytes_per_truth : 0.0));
}

}  // namespace apps
