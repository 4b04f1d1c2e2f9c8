#include "ident/library/library.hpp"

#include <catch2/catch.hpp>

#include "support/fault.hpp"
#include "support/motion.hpp"

using Eigen::VectorXd;

namespace {

dsp::Motion signals() {
  const VectorXd some = VectorXd::LinSpaced(5, 0.0, 1.0);
  return support::motion_of(10.0, {{"t", some}, {"x", some}, {"v", some}, {"a", some}, {"f", some}});
}

std::vector<std::string> names_of(const ident::CandidateLibrary& library) {
  std::vector<std::string> names;
  for (const auto& term : library.terms) names.push_back(term.name);
  return names;
}

}  // namespace

TEST_CASE("order three in x and v is the paper's eleven terms with the force", "[ident][library]") {
  const auto library = ident::make_library({.order = 3, .terms = {"f"}}, "a", signals());
  CHECK(names_of(library) ==
        std::vector<std::string>{"1", "x", "v", "x^2", "x*v", "v^2", "x^3", "x^2*v", "x*v^2", "v^3", "f"});
}

TEST_CASE("units of coefficients follow from those of target and signals", "[ident][library]") {
  const auto library =
      ident::make_library({.order = 3, .terms = {"sgn(v)", "abs(x)*v", "x/v^2", "f", "sin(x)"}}, "a", signals());
  const auto unit = [&](std::size_t term) { return ident::coefficient_unit("m/s^2", library.terms[term].unit); };
  CHECK(unit(0) == "m/s^2");
  CHECK(unit(1) == "1/s^2");
  CHECK(unit(2) == "1/s");
  CHECK(unit(6) == "1/(m^2*s^2)");
  CHECK(unit(10) == "m/s^2");
  CHECK(unit(11) == "1/(m*s)");
  CHECK(unit(12) == "m^2/s^4");
  CHECK(unit(13) == "m/(N*s^2)");
  CHECK(unit(14).empty());  // of sin(x) nothing is claimed
}

TEST_CASE("libraries that cannot serve are refused before anything is formed", "[ident][library]") {
  const auto refused = [](const ident::LibraryOptions& options, const std::string& name, const std::string& part) {
    support::check_fault([&] { (void)ident::make_library(options, "a", signals()); }, dsp::FaultKind::usage, name,
                         {part});
  };
  refused({.order = 50}, "library.too_large", "1326 terms");
  refused({.order = 3, .terms = std::vector<std::string>(1000000, "x")}, "library.too_large", "1000010 terms");
  refused({.order = 2, .terms = {"x * v"}}, "library.duplicate", "'x*v'");
  refused({.order = 0, .terms = {"x", "a"}}, "library.target", "'a'");
  refused({.order = 0, .terms = {}}, "library.empty", "no terms");
  refused({.order = 2, .variables = {}}, "library.variables", "empty");
  refused({.order = -1}, "library.order", "-1");
  refused({.order = 1, .terms = {"w"}}, "term.unknown_name", "'w'");
}

TEST_CASE("the target is refused among its own terms however it is written", "[ident][library]") {
  for (const std::string term : {"a", "a+0", "1*a", "a^1", "(a)", "-a", "2*a", "a*x/x", "a/4 + a"}) {
    CAPTURE(term);
    support::check_fault(
        [&] {
          (void)ident::make_library({.order = 0, .terms = {"x", term}}, "a", signals());
        },
        dsp::FaultKind::usage, "library.target", {"is the target 'a'"});
  }
  for (const std::string term : {"a*x", "a^2", "a+1", "abs(a)", "sgn(a)", "0*a", "a-x"}) {
    CAPTURE(term);
    support::check_fault(
        [&] {
          (void)ident::make_library({.order = 0, .terms = {"x", term}}, "a", signals());
        },
        dsp::FaultKind::usage, "library.target", {"contains the target 'a'"});
  }
}

TEST_CASE("a target that other terms make up is refused, and one beside the motion of its base alone is not",
          "[ident][library]") {
  const VectorXd some = VectorXd::LinSpaced(5, 0.0, 1.0);
  const auto with = [&](std::vector<std::string> accelerations) {
    std::vector<std::pair<std::string, VectorXd>> columns{{"t", some}, {"x", some}, {"v", some}, {"a", some}};
    for (const std::string& name : accelerations) columns.emplace_back(name, some);
    dsp::Prepared prepared;
    prepared.signals = support::motion_of(10.0, columns);
    return ident::record_library({.order = 1, .terms = accelerations}, "a", prepared);
  };
  // a = ddy - ddr, and a = ddy where the base rests. Of ddr alone a is no function.
  support::check_fault([&] { (void)with({"ddy"}); }, dsp::FaultKind::usage, "library.target", {"no base moves"});
  support::check_fault([&] { (void)with({"ddy", "ddr"}); }, dsp::FaultKind::usage, "library.target", {"made of"});
  CHECK(names_of(with({"ddr"})) == std::vector<std::string>{"1", "x", "v", "ddr"});
}
