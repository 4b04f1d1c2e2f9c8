#include "fuzz/harness.hpp"
#include "support/mat.hpp"

std::vector<std::string> fuzz::seeds() {
  std::vector<double> t, x;
  for (int i = 0; i < 12; ++i) t.push_back(i / 250.0), x.push_back(i * i % 7);
  std::vector<std::string> all;
  for (const bool big : {false, true}) {
    const support::Mat mat{big};
    const std::string vectors = mat.vector("t", t) + mat.vector("x_mm", x);
    all.push_back(mat.header() + vectors + mat.vector("k", {3.0}));
    all.push_back(mat.header() + mat.compressed(mat.vector("t", t)) + mat.compressed(mat.vector("v", x)));
    const std::string signal = mat.structure(
        "theta", {{"time", mat.vector("", t)}, {"signals", mat.structure("", {{"values", mat.vector("", x)}})}});
    all.push_back(mat.header() + signal);
    all.push_back(mat.header() + mat.compressed(signal));
  }
  return all;
}
