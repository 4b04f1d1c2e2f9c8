#pragma once
#include <string>

#include "apps/page/figures.hpp"

namespace apps {

/// How the terms of a fit were chosen: log evidence by move where a method searches move by move, and what the best
/// model of each number of terms leaves over where Selection::evidence compared them. `slug`: what names begin with.
void evidence_figures(const ident::JudgedFit& fit, const std::string& slug, const FigureTaker& take);

}  // namespace apps
