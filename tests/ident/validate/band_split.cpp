// Whether one equation holds in the whole band: of a record as it is, and of one whose force an anti-alias filter
// turned.
#include "ident/validate/band_split.hpp"

#include <catch2/catch.hpp>

#include "ident/identify.hpp"
#include "ident/records/record.hpp"
#include "support/turned_force_record.hpp"

namespace {

ident::BandSplit split_of(double turn_rad) {
  const auto found = ident::identify(ident::find_regimes(dsp::prepare(support::turned_force_record(turn_rad), {})),
                                     {.order = 3, .terms = {"f"}}, {.methods = {ident::FastRvmOptions{}}});
  REQUIRE(found.front().fits.front().band);
  return *found.front().fits.front().band;
}

}  // namespace

TEST_CASE("the lower octave gives the coefficients of the band unless products lost their phase", "[ident][band]") {
  const ident::BandSplit whole = split_of(0.0), turned = split_of(1.5);
  CHECK(whole.term == "");
  CHECK(whole.stop_hz == Approx(0.4 * 12.0));
  CHECK(turned.term != "");
}
