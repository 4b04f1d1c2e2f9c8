// A sidecar: parsed, then applied to a small table.
#include "dsp/io/sidecar.hpp"

#include "dsp/io/read_recording.hpp"
#include "dsp/values/fault.hpp"
#include "fuzz/harness.hpp"

namespace {

const std::string table = "t,x,y_mm,ddr,r\n0,1,2,3,4\n0.5,2,3,4,5\n1,3,4,5,6\n1.5,4,5,6,7\n2,1,2,3,4\n";

void read(const std::filesystem::path& file, const dsp::ReadOptions& options) {
  dsp::RecordingReader reader(file, options);
  dsp::FrameBlock block;
  while (reader.read(block, 1000) > 0) {
  }
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  const MemoryFile recording(table);
  return {dsp::draft_sidecar(recording.path()),
          R"(schema = 1
title = "rig"
rate = "4/2"
start = 2023-05-04T10:12:30Z
[[channel]]
name = "base"
index = 5
role = "r"
unit = "mm"
sensitivity = "250 mV/mm"
full_scale = "10 V"
coupling = "DC"
sensor = { model = "ZX2", calibrated = 2022-11-02 }
[[channel]]
name = "acc"
column = "ddr"
role = "ddr"
sensitivity = "100.1 mV/g"
full_scale = "5 V"
coupling = "AC"
highpass = [0.4, 0.3]
sign = -1
delay = "0.23 ms"
offset = "2.5 V"
[[range]]
name = "low"
from = 0.5
to = 2
train_to = 1
where = "abs(v) > 0"
[[bad]]
from = 1
to = 1.5
why = "knock"
)",
          "clock = \"interpolate\"\nrate = 2\n[[channel]]\nname = \"x\"\nunit = \"um\"\nhighpass = 0.5\n"};
}

void fuzz::run(const std::string& input) {
  (void)dsp::parse_sidecar(input, "a.toml");
  const MemoryFile recording(table), sidecar(input);
  dsp::ReadOptions options;
  options.sidecar = sidecar.path();
  options.max_memory_bytes = std::size_t{16} << 20;
  try {
    read(recording.path(), options);
  } catch (const dsp::Fault&) {
    options.uncalibrated = true;
    read(recording.path(), options);
  }
}
