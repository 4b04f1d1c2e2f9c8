#pragma once
#include <vector>

#include "dsp/sensors/motion.hpp"
#include "ident/equation/model.hpp"
#include "ident/evidence/range_data.hpp"
#include "ident/validate/free_run.hpp"

namespace ident {

/// Where the zeros of x and the leads of f are: those of each recording of the range (`recording` 0: all, else that
/// one, 1-based) as it was prepared, and where the fit found otherwise (`posterior`, may be nullptr), as it found them.
[[nodiscard]] std::vector<Coordinates> coordinates_of(const RangeData& range, int recording,
                                                      const std::vector<Columns>& recordings,
                                                      const SensorPosterior* posterior);

/// The signals of the free run in the coordinates that the model states, and in no others: what is judged is what is
/// printed. `moved` keeps them.
void run_in_coordinates(const Model& model, const std::vector<Columns>& recordings, std::vector<dsp::Motion>& moved,
                        std::vector<Course>& courses);

/// Of x and v over the training rows, in the model's coordinates.
[[nodiscard]] std::vector<Extent> extents_of(const Model& model, const std::vector<Row>& rows,
                                             const std::vector<Columns>& recordings);

}  // namespace ident
