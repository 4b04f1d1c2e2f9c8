#include "bench/bench.hpp"

#include <sndfile.h>
#include <sys/resource.h>

#include <vector>

namespace {

double seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

double cpu_now_s() {
  double sum = 0.0;
  for (const int whose : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(whose, &usage);
    sum += seconds(usage.ru_utime) + seconds(usage.ru_stime);
  }
  return sum;
}

}  // namespace

double bench::cpu_s(const std::function<void()>& work) {
  const double start = cpu_now_s();
  work();
  return cpu_now_s() - start;
}

void bench::bare_read(const std::filesystem::path& file) {
  constexpr sf_count_t block = 65536;
  SF_INFO info{};
  SNDFILE* sound = sf_open(file.c_str(), SFM_READ, &info);
  std::vector<double> buffer(static_cast<std::size_t>(block * info.channels));
  while (sf_readf_double(sound, buffer.data(), block) > 0) {
  }
  sf_close(sound);
}

int main(int, char** arguments) {
  const auto folder = std::filesystem::temp_directory_path() / "ardent_bench";
  std::filesystem::create_directories(folder);
  bench::raw_part(folder);
  bench::whole_run(std::filesystem::path(arguments[0]).parent_path() / "ardent", folder);
  std::filesystem::remove_all(folder);
}
