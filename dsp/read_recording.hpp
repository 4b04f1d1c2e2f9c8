// The public face of io/read_recording.hpp.
#pragma once
#include "dsp/io/read_recording.hpp"
