#include "fuzz/harness.hpp"
#include "fuzz/sample_seeds.hpp"

std::vector<std::string> fuzz::seeds() {
  return samples({"numpy.npy", "records.npy", "numpy.npz"});
}
