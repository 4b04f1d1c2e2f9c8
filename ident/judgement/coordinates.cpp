#include "ident/judgement/coordinates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "ident/records/record.hpp"

namespace ident {

std::vector<Coordinates> coordinates_of(const RangeData& range, int recording, const std::vector<Columns>& recordings,
                                        const SensorPosterior* posterior) {
  std::vector<Coordinates> result;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (recordings[r].prepared == nullptr || (recording != 0 && static_cast<std::size_t>(recording) != r + 1)) continue;
    const dsp::Signal* x = recordings[r].signals->find("x");
    Coordinates& one =
        result.emplace_back(Coordinates{.recording = recordings[r].name,
                                        .of = recordings[r].prepared->x_is_difference ? "y - r" : "the displacement",
                                        .unit = x == nullptr ? "" : x->unit,
                                        .zero = recordings[r].zero,
                                        .prepared_zero = recordings[r].zero});
    if (posterior == nullptr) continue;
    if (const auto at = range.sensors->coordinate(r, Coordinate::zero_of_x))
      one.zero -= posterior->sensor_mean(*at), one.zero_std = posterior->sensor_std(*at);
    if (const auto at = range.sensors->coordinate(r, Coordinate::lead_of_f))
      one.lead_s = posterior->sensor_mean(*at), one.lead_std_s = posterior->sensor_std(*at);
  }
  return result;
}

void run_in_coordinates(const Model& model, const std::vector<Columns>& recordings, std::vector<dsp::Motion>& moved,
                        std::vector<Course>& courses) {
  moved.reserve(courses.size());  // the courses point at them
  for (Course& course : courses) {
    const Columns& columns = recordings[course.recording];
    const auto own = std::find_if(model.coordinates.begin(), model.coordinates.end(),
                                  [&](const Coordinates& one) { return one.recording == columns.name; });
    if (own == model.coordinates.end() || (own->zero == own->prepared_zero && own->lead_s == 0.0)) continue;
    moved.push_back(in_coordinates(columns.prepared->signals, own->zero - own->prepared_zero, own->lead_s));
    course.signals = &moved.back();
  }
}

std::vector<Extent> extents_of(const Model& model, const std::vector<Row>& rows,
                               const std::vector<Columns>& recordings) {
  std::vector<Extent> extents;
  for (const char* name : {"x", "v"}) {
    Extent extent{name, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (std::size_t r = 0; r < recordings.size(); ++r) {
      const dsp::Signal* signal = recordings[r].signals->find(name);
      if (signal == nullptr) continue;
      const auto own = std::find_if(model.coordinates.begin(), model.coordinates.end(),
                                    [&](const Coordinates& one) { return one.recording == recordings[r].name; });
      const bool moved = name[0] == 'x' && own != model.coordinates.end();
      const double shift = moved ? own->zero - own->prepared_zero : 0.0;
      for (const Row& row : rows)
        if (row.recording == r && std::isfinite(signal->values(row.sample))) {
          extent.lowest = std::min(extent.lowest, signal->values(row.sample) - shift);
          extent.highest = std::max(extent.highest, signal->values(row.sample) - shift);
        }
    }
    if (extent.lowest <= extent.highest) extents.push_back(std::move(extent));
  }
  return extents;
}

}  // namespace ident
