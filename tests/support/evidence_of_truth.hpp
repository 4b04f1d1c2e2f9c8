#pragma once
#include <string>
#include <utility>
#include <vector>

#include "ident/ranges/ranges.hpp"
#include "support/labelled_record.hpp"

namespace support {

/// Terms with their coefficients: an equation for a.
using WrittenEquation = std::vector<std::pair<std::string, double>>;

/// What the rows of a simulated record know of an equation beside the true one, by the noise that the simulation put
/// in: twice the log likelihood ratio for the true one, of spectra, each frequency weighed by the noise that draws of
/// the same record have there. Nothing of the identification or of its judgement takes part.
struct EvidenceOfTruth {
  double least = 0.0;    ///< expected for the coefficients that come closest, without noise of this record's own
  double of_this = 0.0;  ///< of these coefficients and this record's noise
};
/// Infinite where nothing can be tied: the record has no noise, `found` no term, or `rows` no stretch that is long
/// enough; of_this where the truth itself leaves more than noise, as while friction holds the body. `rows`: of the
/// first recording, ascending.
[[nodiscard]] EvidenceOfTruth evidence_of_truth(const LabelledRecord& record, const std::vector<ident::Row>& rows,
                                                const WrittenEquation& found);

}  // namespace support
