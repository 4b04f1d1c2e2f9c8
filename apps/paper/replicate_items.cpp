#include "apps/paper/replicate_items.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "dsp/fault.hpp"

namespace apps {
namespace {

[[noreturn]] void refuse(const std::string& text) {
  throw dsp::Fault(dsp::FaultKind::usage, "replicate.item", "replicate: " + text);
}

bool want_case(std::vector<WantedCase>& cases, const std::string& item) {
  bool known = false;
  for (WantedCase& one : cases) {
    const bool whole = item == "all" || item == one.definition->name;
    const bool table = whole || item == fmt::format("table-{}", one.definition->table);
    const bool figure = whole || item == fmt::format("fig-{}", one.definition->figure);
    one.table |= table;
    one.figure |= figure;
    known |= table || figure;
  }
  return known;
}

bool want_rig(WantedOfRig& rig, const std::string& item) {
  const bool whole = item == "all" || item == "qzs";
  bool known = whole;
  for (const Section5Case& one : section5_cases()) {
    if (!whole && item != one.name && item != fmt::format("table-{}", one.table)) continue;
    if (std::find(rig.tables.begin(), rig.tables.end(), &one) == rig.tables.end()) rig.tables.push_back(&one);
    known = true;
  }
  for (const auto& [name, flag] : {std::pair{"table-9", &WantedOfRig::errors},
                                   {"fig-11", &WantedOfRig::responses},
                                   {"fig-12", &WantedOfRig::states},
                                   {"fig-13", &WantedOfRig::identified}})
    if (whole || item == name) rig.*flag = known = true;
  return known;
}

}  // namespace

std::vector<const Section5Case*> WantedOfRig::cases() const {
  if (!errors && !states && !identified) return tables;
  std::vector<const Section5Case*> all;
  for (const Section5Case& known : section5_cases()) all.push_back(&known);
  return all;
}

ReplicateItems items_of(const std::vector<std::string>& names) {
  ReplicateItems items;
  for (const Section4Case& known : section4_cases()) items.cases.push_back({&known, false, false});
  for (const std::string& name : names) {
    const bool of_section4 = want_case(items.cases, name), of_section5 = want_rig(items.rig, name);
    if (of_section4 || of_section5) continue;
    std::vector<std::string> known;
    for (const Section4Case& one : section4_cases()) known.push_back(one.name);
    for (const Section5Case& one : section5_cases()) known.push_back(one.name);
    refuse(
        fmt::format("'{}' is not known; there are table-1 to table-12, fig-2 to fig-9, fig-11 to fig-13, {}, qzs, all",
                    name, fmt::join(known, ", ")));
  }
  std::erase_if(items.cases, [](const WantedCase& one) { return !one.table && !one.figure; });
  if (names.empty()) refuse("nothing to do; name a table, a figure, a case, or all");
  return items;
}

}  // namespace apps
