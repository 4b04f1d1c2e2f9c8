// segments.json: read, put on a record, written, read again.
#include "apps/config/segments_file.hpp"

#include "dsp/sensors/motion.hpp"
#include "fuzz/harness.hpp"

namespace {

// 20 s at 10 Hz, the first second ruled out.
dsp::Prepared prepared() {
  dsp::Prepared result{.name = "a.wav"};
  for (dsp::Motion* motion : {&result.intermediate, &result.signals}) {
    motion->sample_rate_hz = 10.0;
    motion->signals.push_back({"x", "m", Eigen::VectorXd::Zero(200)});
    motion->excluded.assign(200, 0);
    motion->edge_samples = 3;
    dsp::mark(*motion, {0.0, 1.0, "start"});
  }
  result.excluded = {{0.0, 1.0, "start"}};
  return result;
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  return {R"([
  {"label": "low", "from_s": 0.0, "to_s": 12.5, "reason": "by eye"},
  {"label": "high", "from_s": 10, "to_s": 1.5e1, "recording": "a.wav"},
  {"label": "stick", "from_s": 16, "to_s": 100},
  {"label": "excluded", "from_s": 3, "to_s": 4.25, "reason": "\u00e9\n"}
]
)",
          R"([{"label":"low","from_s":0,"to_s":20},{"label":"high","from_s":0,"to_s":20,"recording":"b.wav"}])"};
}

void fuzz::run(const std::string& input) {
  const MemoryFile file(input);
  apps::Input record;
  record.prepared = prepared();
  record.segmentation = apps::apply_segments(apps::read_segments(file.path()), file.path(), record.prepared);
  const MemoryFile again(apps::segments_json({record}));
  auto fresh = prepared();
  (void)apps::apply_segments(apps::read_segments(again.path()), again.path(), fresh);
}
