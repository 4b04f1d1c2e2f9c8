#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "ident/identify.hpp"
#include "ident/judgement/judge.hpp"
#include "support/labelled_record.hpp"

// Records without noise, of whose motion the filters keep all but what their stop bands let through. The seeds are the
// noise-free ones of a self-excited and a free oscillator among 20001 to 26300 in which terms used to be kept that
// contributed a millionth of the acceleration; and free decays among 48001 to 56300 in which terms below 0.3 % were
// kept whose intervals include zero.
TEST_CASE("what the filters leave of an exact record is no term", "[ident][selection][exact_record]") {
  for (const std::uint32_t seed : {22089U, 22240U, 24256U, 48130U, 56270U}) {
    const support::LabelledRecord record = support::labelled_record(seed);
    REQUIRE(record.noise == 0.0);
    const auto ranges = ident::identify(ident::find_regimes(dsp::prepare(record.recording, record.prepare)),
                                        record.library, {.methods = {ident::FastRvmOptions{}}});
    const auto chosen = ident::chosen_fit(ranges);
    REQUIRE(chosen.has_value());
    std::set<std::string> found, truth;
    for (const auto& term : ranges[chosen->range].fits[chosen->method].model.terms) found.insert(term.name);
    for (const auto& [name, value] : record.truth) truth.insert(name);
    CAPTURE(seed);
    CHECK(found == truth);
  }
}
