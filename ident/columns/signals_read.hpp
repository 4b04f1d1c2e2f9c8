#pragma once
#include <string>

#include "dsp/prepare.hpp"
#include "ident/library/library.hpp"

namespace ident {

/// Frees the samples of y at the intermediate rate, which nobody reads once the columns of this library are formed and
/// neither its terms nor the target are of y: other signals are of terms, of signs that are tried beside them
/// (column_beside), or what an error of a sensor goes by (SensorShape), of y its speed. The signal stays by its name,
/// as columns refer to others.
void free_signals_read(dsp::Prepared& prepared, const CandidateLibrary& library, const std::string& target);

}  // namespace ident
