#include "apps/output/saved_factors.hpp"

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
  const auto require_factors = [&](const Folder& folder, const std::string& name) {
    if (!force) throw taken_at(place);
    try {
      if (!folder.entry(name)->is_file()) throw link_at(place);
      static_cast<void>(read_factors(folder.path() / name));
    } catch (const dsp::Fault&) {
      throw output_fault("output.foreign", place, "holds no R factors, so it is not replaced. Choose another name");
    }
  };
  StagingFolder staging(place, require_factors);
  const std::string name = place.filename();
  staging.require_free(name);
  write_file(staging.fresh(), name, place, factors_json(records));
  staging.place({name});
}

}  // namespace apps
