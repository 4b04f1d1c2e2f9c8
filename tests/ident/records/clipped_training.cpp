#include "ident/records/clipped_training.hpp"

#include <catch2/catch.hpp>

#include "support/fault.hpp"

TEST_CASE("clipping counts within the stretch a range is trained on, and in its recording only",
          "[ident][clipped_training]") {
  ident::Record record;
  record.prepared.name = "rig";
  record.prepared.signals.sample_rate_hz = 10.0;
  record.prepared.signals.signals = {{"t", "s", Eigen::VectorXd::LinSpaced(1000, 0.0, 99.9)}};
  record.prepared.clipped = {{45.0, 47.0, "laser"}};
  const ident::Record clean{.prepared = {.name = "other", .signals = record.prepared.signals}};
  ident::Range range;
  range.spec.name = "all";
  const auto require = [&](double max_share) { ident::require_unclipped(range, {&record, &clean}, max_share); };
  support::check_fault([&] { require(0.01); }, dsp::FaultKind::input, "sample.clipped",
                       {"rig", "range 'all'", "laser is clipped for 2 s of the 60 s", "3.3 %"});
  CHECK_NOTHROW(require(0.04));
  range.train_fraction = 0.4;  // trained on before it clips
  CHECK_NOTHROW(require(0.01));
  range.train_fraction = 0.6;
  range.spec.train_to_s = 44.0;
  CHECK_NOTHROW(require(0.01));
  range.spec.train_to_s.reset();
  range.recording = 2;
  CHECK_NOTHROW(require(0.01));
}
