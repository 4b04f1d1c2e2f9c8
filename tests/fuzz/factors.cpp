// factors.json: read, written, read again; fitted together with itself left out.
#include "apps/output/factors_file.hpp"

#include "fuzz/harness.hpp"

namespace {

ident::RFactor factor(Eigen::Index rows) {
  Eigen::MatrixXd phi(rows, 2);
  for (Eigen::Index i = 0; i < rows; ++i) phi.row(i) << static_cast<double>(i % 7) - 3.0, 1.0;
  return ident::r_factor(phi, phi * Eigen::Vector2d(-2.0, 0.5));
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  ident::RecordFactors record{
      .record = "a.wav", .range = "all", .target = "a", .target_unit = "m/s^2", .rate_hz = 100.0};
  record.sources = {{"../a.wav", std::string(64, 'f')}};
  record.terms = {{"x", "m", 3.0}, {"1", "1", 1.0}};
  record.white = factor(20);
  record.evidence = factor(9);
  record.size = {.num_rows = 20.0, .num_uncorrelated = 9.0, .num_noise = 9.0, .num_states = 12.0};
  record.blocks = {{0.0, 0.1, 1.0, factor(11)}, {0.1, 0.2, -1.0, factor(9)}};
  ident::RecordFactors bare = record;
  bare.evidence = {};
  return {apps::factors_json({record}), apps::factors_json({record, bare})};
}

void fuzz::run(const std::string& input) {
  const MemoryFile file(input);
  const std::vector<ident::RecordFactors> records = apps::read_factors(file.path());
  const MemoryFile again(apps::factors_json(records));
  (void)apps::read_factors(again.path());
  (void)ident::joint_fit({&records.front()}, {ident::OlsOptions{}, ident::FastRvmOptions{}});
}
