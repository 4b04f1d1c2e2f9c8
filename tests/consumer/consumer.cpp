#include <cmath>
#include <iostream>

#include "dsp/prepare.hpp"
#include "dsp/read_recording.hpp"
#include "ident/identify.hpp"
#include "ident/validate/predict.hpp"

// A recording to its judged equations; the coefficient of x is known to be -50 within a per cent.
int main(int /*argc*/, char** argv) {
  dsp::RecordingReader recording(argv[1]);
  const dsp::Prepared prepared = dsp::prepare(recording, {.rate_hz = 25.6, .cutoff_hz = 10.24, .rolloff_hz = 8.0});
  const auto ranges =
      ident::identify(ident::find_regimes(prepared), {.order = 0, .terms = {"x", "v", "x^3", "sgn(v)", "ddr"}});
  for (const ident::RangeResult& range : ranges)
    std::cout << range.spec.name << ": " << ident::to_text(range.fits.front().model) << "\n  "
              << range.fits.front().judgement.sentence << "\n";
  for (const ident::ModelTerm& term : ranges.back().fits.front().model.terms)
    if (term.name == "x") return std::abs(term.mean / -50.0 - 1.0) < 0.01 ? 0 : 1;
  return 1;
}
