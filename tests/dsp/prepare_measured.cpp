// Measured records whose physics is known from their READMEs, through preparation and plain least squares.
#include <Eigen/QR>
#include <catch2/catch.hpp>
#include <complex>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "dsp/prepare.hpp"

namespace test_prepare_measured {

namespace {
const std::filesystem::path real_data = ARDENT_REAL_DATA;

// Numbers of a CSV file with one header line; a trailing comma is no column.
Eigen::MatrixXd read_table(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line, cell;
  std::getline(in, line);
  std::vector<std::vector<double>> rows;
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    rows.emplace_back();
    while (std::getline(cells, cell, ',')) rows.back().push_back(std::stod(cell));
  }
  Eigen::MatrixXd table(rows.size(), rows.front().size());
  for (Eigen::Index i = 0; i < table.rows(); ++i)
    for (Eigen::Index j = 0; j < table.cols(); ++j)
      table(i, j) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  return table;
}

struct LeastSquares {
  Eigen::VectorXd coefficients;
  double nmse;
};
LeastSquares least_squares(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target) {
  const Eigen::VectorXd c = columns.colPivHouseholderQr().solve(target);
  return {c, (columns * c - target).squaredNorm() / target.squaredNorm()};
}

// Columns of a LabVIEW text file, its clock among them.
Eigen::MatrixXd read_lvm(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line) && line.rfind("X_Value", 0) != 0) {
  }
  std::vector<double> numbers;
  Eigen::Index num_rows = 0;
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    for (double number = 0.0; cells >> number;) numbers.push_back(number);
    ++num_rows;
  }
  return Eigen::Map<const dsp::FrameBlock>(numbers.data(), num_rows,
                                           static_cast<Eigen::Index>(numbers.size()) / num_rows);
}

// Amplitude of the line at f, through a Hann window.
double line_amplitude(const Eigen::VectorXd& x, double rate_hz, double f) {
  std::complex<double> sum = 0.0;
  double weights = 0.0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double window =
        1.0 - std::cos(2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(x.size()));
    sum += window * (x(i) - x.mean()) * std::polar(1.0, -2.0 * std::numbers::pi * f * static_cast<double>(i) / rate_hz);
    weights += window;
  }
  return 2.0 * std::abs(sum) / weights;
}

// x'' of the top plate on x - y, x' - y', sgn(x'), 1 where it slides, with what `recipe` offers.
LeastSquares friction_frame(const std::string& name, dsp::Recipe recipe, double cutoff_hz) {
  const Eigen::MatrixXd table = read_table(real_data / "friction_frame" / name);
  dsp::Recording record{.name = name, .sample_rate_hz = 250.0};
  record.channels = {{.name = "top", .role = dsp::Role::y, .unit = "m"},
                     {.name = "base", .role = dsp::Role::r, .unit = "m"}};
  record.samples = 1e-3 * table.rightCols(2);
  const auto prepared = dsp::prepare(record, {.recipe = recipe, .cutoff_hz = cutoff_hz, .rolloff_hz = 0.8 * cutoff_hz});
  const bool matched = recipe == dsp::Recipe::matched;
  const auto& source = matched ? prepared.intermediate : prepared.signals;
  Eigen::MatrixXd columns(source.num_samples(), 4);
  columns << source.at("x"), source.at("v"), source.at("dy").cwiseSign(), Eigen::VectorXd::Ones(source.num_samples());
  if (matched)
    for (Eigen::Index j = 0; j < 4; ++j) columns.col(j) = prepared.filter.apply(columns.col(j));
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < columns.rows(); ++i)
    if (std::abs(prepared.signals.at("dy")(i)) > 0.004) rows.push_back(i);
  return least_squares(columns(rows, Eigen::all), prepared.signals.at("ddy")(rows));
}
}  // namespace

TEST_CASE("the friction frame shows its stiffness and friction", "[dsp][prepare][measured]") {
  if (!std::filesystem::exists(real_data / "friction_frame")) {
    WARN("skipped: no friction_frame in " << real_data);
    return;
  }
  // Figures of its README, made with Savitzky-Golay derivatives.
  const auto light = friction_frame("frame_250g.csv", dsp::Recipe::paper, 30.0);
  CHECK(-light.coefficients(0) == Approx(399.0).margin(5.0));
  CHECK(-light.coefficients(2) == Approx(0.223).epsilon(0.1));
  CHECK(light.nmse <= 0.03);
  const auto heavy = friction_frame("frame_450g.csv", dsp::Recipe::paper, 30.0);
  CHECK(-heavy.coefficients(0) == Approx(394.0).margin(5.0));
  CHECK(-heavy.coefficients(2) == Approx(0.418).epsilon(0.1));
  CHECK(heavy.nmse <= 0.03);

  // Matched columns see through the filter into the samples where the plate sticks: friction a little lower.
  const auto matched = friction_frame("frame_250g.csv", dsp::Recipe::matched, 30.0);
  CHECK(-matched.coefficients(0) == Approx(399.0).margin(5.0));
  CHECK(-matched.coefficients(2) == Approx(0.223).epsilon(0.1));
  CHECK(matched.nmse <= 0.03);
}

TEST_CASE("decimation of the shaker's force leaves its 50 Hz line and folds none of the tones above",
          "[dsp][decimate][measured]") {
  if (!std::filesystem::exists(real_data / "shaker_beam_51k2")) {
    WARN("skipped: no shaker_beam_51k2 in " << real_data);
    return;
  }
  const Eigen::VectorXd force_lb = read_lvm(real_data / "shaker_beam_51k2" / "data_set_1_downsampled_by_16.lvm").col(2);
  const Eigen::VectorXd slow =
      dsp::decimate(force_lb, 3200.0, {.output_rate_hz = 200.0, .passband_end_hz = 80.0}).col(0);
  CHECK(line_amplitude(slow, 200.0, 50.0) == Approx(0.0562).epsilon(0.05));
  CHECK(line_amplitude(slow, 200.0, 80.0) <= 0.018);
  CHECK(slow.mean() == Approx(force_lb.mean()).margin(1e-3));
}

TEST_CASE("a pendulum's encoder at 10 kHz gives its frequency once decimated", "[dsp][prepare][measured]") {
  if (!std::filesystem::exists(real_data / "pendulum")) {
    WARN("skipped: no pendulum in " << real_data);
    return;
  }
  dsp::Recording record{.name = "pendulum", .sample_rate_hz = 1e4};
  record.channels = {{.name = "theta", .role = dsp::Role::x, .unit = "rad"}};
  record.samples = read_table(real_data / "pendulum" / "freeswing_10kHz.csv").col(1).array() - std::numbers::pi;
  const auto prepared = dsp::prepare(record, {.rate_hz = 100.0, .cutoff_hz = 10.0});
  CHECK(prepared.intermediate.sample_rate_hz == Approx(1000.0));
  // The swing dies within these 5 s and its start says most; the continued end is good to 0.2 s.
  const Eigen::Index edge = 20, rows = 500 - edge;
  Eigen::MatrixXd columns(prepared.signals.num_samples(), 4);
  columns << prepared.signals.at("x"), prepared.signals.at("v"),
      prepared.filter.apply(prepared.intermediate.at("v").cwiseSign()), Eigen::VectorXd::Ones(columns.rows());
  const auto fit = least_squares(columns.middleRows(edge, rows), prepared.signals.at("a").segment(edge, rows));
  // -64.84 by another decimation and Savitzky-Golay; 64.0 from the large swings.
  CHECK(-fit.coefficients(0) == Approx(64.84).epsilon(0.01));
  CHECK(fit.nmse <= 1.2e-3);
}

TEST_CASE("the Silverbox shows its cubic spring when columns are matched, and loses a quarter of it when not",
          "[dsp][prepare][measured]") {
  if (!std::filesystem::exists(real_data / "silverbox_multisine")) {
    WARN("skipped: no silverbox_multisine in " << real_data);
    return;
  }
  dsp::Recording record{.name = "silverbox", .sample_rate_hz = 1e7 / 16384.0};
  record.channels = {{.name = "u", .role = dsp::Role::f, .unit = "V"},
                     {.name = "y", .role = dsp::Role::x, .unit = "V"}};
  record.samples = read_table(real_data / "silverbox_multisine" / "snls80mv_rows_40496_118723.csv");
  const auto fit = [&](dsp::Recipe recipe) {
    const auto prepared = dsp::prepare(record, {.recipe = recipe, .cutoff_hz = 160.0});
    const bool matched = recipe == dsp::Recipe::matched;
    const auto& source = matched ? prepared.intermediate : prepared.signals;
    const Eigen::VectorXd y = source.at("x");
    Eigen::MatrixXd columns(y.size(), 6);
    columns << y, source.at("v"), y.cwiseAbs2(), y.cwiseAbs2().cwiseProduct(y), source.at("f"),
        Eigen::VectorXd::Ones(y.size());
    if (matched)
      for (Eigen::Index j = 0; j < 6; ++j) columns.col(j) = prepared.filter.apply(columns.col(j));
    const Eigen::Index edge = prepared.signals.edge_samples, inside = y.size() - 2 * edge;
    return least_squares(columns.middleRows(edge, inside), prepared.signals.at("a").segment(edge, inside));
  };
  const auto matched = fit(dsp::Recipe::matched);
  CHECK(matched.coefficients(0) == Approx(-184266.0).epsilon(0.01));
  CHECK(matched.coefficients(1) == Approx(-41.95).epsilon(0.01));
  CHECK(matched.coefficients(3) == Approx(-733300.0).epsilon(0.03));
  CHECK(matched.coefficients(4) == Approx(186052.0).epsilon(0.01));
  CHECK(matched.nmse <= 2e-5);
  const auto paper = fit(dsp::Recipe::paper);
  CHECK(paper.coefficients(3) == Approx(0.75 * -733300.0).epsilon(0.1));
}

}  // namespace test_prepare_measured
