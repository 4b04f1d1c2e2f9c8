// Certified least-squares problems of NIST through the R-factor route. The floors are those of the data's README.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "ident/regression/fit.hpp"

namespace {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd read_table(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  std::vector<std::vector<double>> rows;
  while (std::getline(in, line)) {
    std::stringstream cells(line);
    std::string cell;
    rows.emplace_back();
    while (std::getline(cells, cell, ',')) rows.back().push_back(std::stod(cell));
  }
  MatrixXd table(static_cast<Index>(rows.size()), static_cast<Index>(rows.front().size()));
  for (Index i = 0; i < table.rows(); ++i)
    for (Index j = 0; j < table.cols(); ++j)
      table(i, j) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  return table;
}

MatrixXd columns_of(const std::string& name, const MatrixXd& table) {
  const Index rows = table.rows();
  if (name == "noint1" || name == "noint2") return table.col(1);
  MatrixXd phi;
  if (name == "longley") {
    phi.resize(rows, 7);
    phi << Eigen::VectorXd::Ones(rows), table.rightCols(6);
    return phi;
  }
  const Index degree = name == "norris" ? 1 : name == "pontius" ? 2 : name == "filip" ? 10 : 5;
  phi.resize(rows, degree + 1);
  for (Index j = 0; j <= degree; ++j) phi.col(j) = table.col(1).array().pow(static_cast<double>(j));
  return phi;
}

}  // namespace

TEST_CASE("certified coefficients to the digits double precision allows", "[ident][nist]") {
  const std::filesystem::path folder = std::filesystem::path(ARDENT_DATA) / "nist-strd";
  const std::map<std::string, double> floors{{"norris", 11},  {"pontius", 11},   {"noint1", 14},   {"noint2", 14},
                                             {"filip", 6.5},  {"longley", 10.5}, {"wampler1", 8},  {"wampler2", 12},
                                             {"wampler3", 8}, {"wampler4", 7.5}, {"wampler5", 5.5}};
  const auto certified = nlohmann::json::parse(std::ifstream(folder / "certified.json"));
  std::size_t seen = 0;
  for (const auto& set : certified["datasets"]) {
    const std::string name = set["name"];
    const MatrixXd table = read_table(folder / set["file"].get<std::string>());
    const auto fit = ident::fit_ols(ident::r_factor(columns_of(name, table), table.col(0)));
    double digits = 16.0;
    Index j = 0;
    REQUIRE(fit.mean.size() == static_cast<Index>(set["exact25"]["estimate"].size()));
    for (const auto& text : set["exact25"]["estimate"]) {
      const double exact = std::stod(text.get<std::string>()), got = fit.mean(j++);
      const double error = exact == 0.0 ? std::abs(got) : std::abs(got - exact) / std::abs(exact);
      if (error > 0.0) digits = std::min(digits, -std::log10(error));
    }
    UNSCOPED_INFO(name << ": " << digits << " digits");
    CHECK(digits >= floors.at(name));
    CHECK(fit.status == ident::FitStatus::converged);
    ++seen;
  }
  CHECK(seen == floors.size());
}
