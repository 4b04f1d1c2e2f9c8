#include "apps/batch/ranks.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "dsp/values/fault.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void refuse_launch(std::string_view why) {
  throw dsp::Fault(dsp::FaultKind::usage, "batch.mpi", fmt::format("batch under mpirun or srun: {}", why));
}

int number_in_environment(const char* name) {
  const char* text = std::getenv(name);
  int number = 0;
  if (text != nullptr) std::from_chars(text, text + std::string_view(text).size(), number);
  return number;
}

#ifdef ARDENT_MPI_MODULE
/// Beside the program as it is built, in its library folder as it is installed.
void* load_module() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const fs::path& folder : {program, (program / ARDENT_MODULE_FOLDER).lexically_normal()}) {
    const fs::path file = folder / ARDENT_MPI_MODULE;
    if (!fs::exists(file, error)) continue;
    // Open MPI's own modules look for its names among the global ones.
    if (void* module = ::dlopen(file.c_str(), RTLD_NOW | RTLD_GLOBAL)) return module;
    refuse_launch(fmt::format("{}. Is openmpi-bin installed? Without it leave mpirun out", ::dlerror()));
  }
  refuse_launch(fmt::format(
      "{} is neither beside the program nor in its library folder. Install the package ardent-mpi, or leave mpirun out",
      ARDENT_MPI_MODULE));
}
#endif

}  // namespace

int launched_processes() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "SLURM_STEP_NUM_TASKS"})
    if (const int count = number_in_environment(name); count > 1) return count;
  return 1;
}

std::unique_ptr<Ranks> join_ranks() {
#ifdef ARDENT_MPI_MODULE
  // On one machine short messages need no more than shared memory; Open MPI's search for a fast network takes twice as
  // long as all the rest of its start. What mpirun or the environment sets stays.
  if (number_in_environment("OMPI_COMM_WORLD_LOCAL_SIZE") == launched_processes()) ::setenv("OMPI_MCA_pml", "ob1", 0);
  void* module = load_module();
  const auto join = reinterpret_cast<JoinFunction>(::dlsym(module, join_function_name));
  if (join == nullptr) refuse_launch(fmt::format("{} is of another version. Install it again", ARDENT_MPI_MODULE));
  std::unique_ptr<Ranks> ranks(join());
  if (ranks->size() == launched_processes()) return ranks;
  const int size = ranks->size();
  ranks->finish();
  refuse_launch(fmt::format("{} processes were started and MPI knows of {}. Under srun: srun --mpi=pmix",
                            launched_processes(), size));
#else
  refuse_launch(
      "this program was built without MPI. Leave mpirun out and use --jobs, or install libopenmpi-dev and build again");
#endif
}

}  // namespace apps
