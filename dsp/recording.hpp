// The public face of values/recording.hpp.
#pragma once
#include "dsp/values/recording.hpp"
