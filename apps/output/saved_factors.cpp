#include "apps/output/saved_factors.hpp"

#include <system_error>

#include "apps/output/factors_file.hpp"
#include "apps/process/output_file.hpp"
#include "apps/process/output_folder.hpp"
#include "apps/process/path.hpp"
#include "apps/process/staging_folder.hpp"
#include "apps/process/system_fault.hpp"

namespace apps {
namespace fs = std::filesystem;

void save_factors(const fs::path& file, const std::vector<ident::RecordFactors>& records,
                  const std::vector<fs::path>& read, bool force) {
  if (file.empty()) {
    if (!force) return;
    throw dsp::Fault(dsp::FaultKind::usage, "usage", "--force has no effect without --save. Leave it out");
  }
  const fs::path place = named_path(file);
  require_apart(place, read);
  StagingFolder staging(place);
  require_no_link(place);
  std::error_code unknown;
  if (fs::exists(fs::symlink_status(place, unknown))) {
    if (!force) throw output_fault("output.exists", place, "exists already. Use --force to replace it");
    try {
      (void)read_factors(place);
    } catch (const dsp::Fault&) {
      throw output_fault("output.foreign", place, "holds no R factors, so it is not replaced. Choose another name");
    }
  }
  write_file(staging.fresh(place), place, factors_json(records));
  staging.place({place}, force);
}

}  // namespace apps
