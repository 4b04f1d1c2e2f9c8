// The public face of regression/fit.hpp.
#pragma once
#include "ident/regression/fit.hpp"
