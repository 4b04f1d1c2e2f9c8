#pragma once
#include <string>
#include <vector>

#include "apps/batch/record_results.hpp"
#include "apps/config/config.hpp"
#include "ident/joint_fit.hpp"

namespace apps {

/// What is known at the end of a batch.
struct BatchResults {
  std::string config;   ///< its file name
  ReportHeader header;  ///< what it states of the object
  std::vector<RecordResult> records;
  std::vector<ident::JointResult> joint;
  std::string joint_reason;           ///< not empty: there is no joint fit
  std::vector<std::string> warnings;  ///< on what is fitted together
};

/// report.html of a batch: counts, records that failed, joint equations, coefficients over the records, every record
/// with a link to its own page. One file that asks for nothing else; the same bytes for the same results.
[[nodiscard]] std::string batch_page(const BatchResults& results);

/// The same for a terminal, short.
[[nodiscard]] std::string batch_text(const BatchResults& results);

}  // namespace apps
