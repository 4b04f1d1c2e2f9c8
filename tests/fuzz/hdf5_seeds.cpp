#include "fuzz/harness.hpp"
#include "fuzz/sample_seeds.hpp"

std::vector<std::string> fuzz::seeds() {
  return samples({"h5py.h5", "matlab_v73.mat"});
}
